//! What drivers say of themselves, and those that are known to be wrong.

use std::ffi::CStr;

use ash::vk;

use super::requirements::API_VERSION;

/// Its name and version, in its own words; empty where it is older than Vulkan 1.1.
pub(super) fn words(
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
    let text = |chars: &[std::ffi::c_char]| {
        let bytes: Vec<u8> = chars.iter().map(|&char| char as u8).collect();
        CStr::from_bytes_until_nul(&bytes)
            .map_or(String::new(), |text| text.to_string_lossy().into())
    };
    let (name, info): (String, String) = (text(&driver.driver_name), text(&driver.driver_info));
    format!("{name} {info}").trim().to_owned()
}

/// What is wrong with a driver of this name and version, and what to do; `None` of most.
pub(super) fn known_fault(words: &str) -> Option<&'static str> {
    // Measured with 24.0.5: whole tiles are left out, and maps of pairs end early, since loops end after fewer trips
    // than elsewhere. 22.3, 25.0 and 25.2 are right.
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
