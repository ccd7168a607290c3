//! Reads the name and version of a driver, and recognizes drivers that compute wrong results.

use ash::vk;

use super::requirements::API_VERSION;

/// Returns the driver's name and version, as it reports them. The text is empty for a device older than
/// Vulkan 1.1.
pub(in crate::vulkan) fn words(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    api_version: u32,
) -> String {
    if api_version < API_VERSION {
        return String::new();
    }
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: the physical device is from this instance and supports Vulkan 1.1; a driver that
    // does not know the second structure leaves it zero.
    unsafe { instance.get_physical_device_properties2(device, &mut properties) };
    let texts = [driver.driver_name_as_c_str(), driver.driver_info_as_c_str()];
    let [name, info] = texts.map(|text| text.unwrap_or_default().to_string_lossy());
    format!("{name} {info}").trim().to_owned()
}

/// Returns the known fault of a driver and its remedy; `None` for most drivers. `words` are the
/// driver's name and version.
pub(in crate::vulkan) fn known_fault(words: &str) -> Option<&'static str> {
    // Measured with 24.0.5: loops end after fewer trips than on other versions. As a result whole tiles are
    // left out, and maps of pairs end early. Versions 22.3, 25.0 and 25.2 are correct.
    words.starts_with("llvmpipe Mesa 24.0.").then_some(
        "lavapipe of Mesa 24.0 leaves out parts of maps: install a newer Mesa, which Ubuntu 24.04 has among its updates",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drivers_that_are_wrong_are_known_by_their_words() {
        assert!(known_fault("llvmpipe Mesa 24.0.5-1ubuntu1 (LLVM 17.0.6)").is_some());
        for right in [
            "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)",
            "llvmpipe Mesa 25.2.8-0ubuntu0.24.04.5 (LLVM 20.1.2)",
            "radv Mesa 24.0.5-1ubuntu1",
            "",
        ] {
            assert_eq!(known_fault(right), None, "{right}");
        }
    }
}
