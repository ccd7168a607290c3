//! Lists the Vulkan devices of this machine and chooses one.

use ash::vk;

use super::driver;
use super::instance::Instance;
use super::requirements::{unmet, version_text};
use crate::vulkan::VulkanError;

/// Kinds of devices, from the best to the worst, with their names.
const KINDS: [(vk::PhysicalDeviceType, &str); 5] = [
    (vk::PhysicalDeviceType::DISCRETE_GPU, "discrete GPU"),
    (vk::PhysicalDeviceType::INTEGRATED_GPU, "integrated GPU"),
    (vk::PhysicalDeviceType::VIRTUAL_GPU, "virtual GPU"),
    (vk::PhysicalDeviceType::CPU, CPU),
    (vk::PhysicalDeviceType::OTHER, "other"),
];
/// Kind of a device that computes on the processor's cores.
const CPU: &str = "CPU";

/// Choice of a Vulkan device. An index is a position in the list that [`devices`] returns.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DeviceChoice {
    /// The best usable device. Discrete GPUs come first, then integrated GPUs, virtual GPUs, CPUs and other
    /// devices.
    #[default]
    Any,
    /// The best usable device that is not a CPU.
    Gpu,
    /// The first device whose name contains this text, ignoring case.
    Name(String),
    /// The device with this index.
    Index(usize),
}

/// Parses an index. Any other text is taken as a part of the name.
impl std::str::FromStr for DeviceChoice {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(text.parse().map_or_else(|_| Self::Name(text.to_owned()), Self::Index))
    }
}

/// Description of a Vulkan device of this machine.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceInfo {
    /// Position of the device in the list.
    pub index: usize,
    /// Name of the device.
    pub name: String,
    /// Kind of the device: `discrete GPU`, `integrated GPU`, `virtual GPU`, `CPU` or `other`.
    pub kind: &'static str,
    /// Vulkan version that the device supports.
    pub api_version: String,
    /// Name and version of the driver, where the driver reports them.
    pub driver: String,
    /// Requirements of this crate that the device does not meet, and known faults of its driver. The list is
    /// empty for a usable device.
    pub unmet: Vec<String>,
}

/// Lists the Vulkan devices of this machine, usable or not.
///
/// # Errors
/// If there is no Vulkan loader, or the loader finds no device.
pub fn devices() -> Result<Vec<DeviceInfo>, VulkanError> {
    let instance = Instance::new(false)?;
    Ok(found(&instance)?.into_iter().map(|(info, _)| info).collect())
}

/// Chooses a device.
pub(crate) fn choose(
    instance: &Instance,
    choice: &DeviceChoice,
) -> Result<(DeviceInfo, vk::PhysicalDevice), VulkanError> {
    let (mut infos, devices): (Vec<_>, Vec<_>) = found(instance)?.into_iter().unzip();
    let index = position(&infos, choice)?;
    let info = infos.swap_remove(index);
    if info.unmet.is_empty() {
        Ok((info, devices[index]))
    } else {
        Err(VulkanError::Unusable { device: info.name, unmet: info.unmet.join("; ") })
    }
}

/// Returns the index in `infos` of the device that `choice` means.
fn position(infos: &[DeviceInfo], choice: &DeviceChoice) -> Result<usize, VulkanError> {
    let unknown = |wanted| {
        let entry = |info: &DeviceInfo| format!("{}: \"{}\"", info.index, info.name);
        let available = infos.iter().map(entry).collect::<Vec<_>>().join(", ");
        VulkanError::UnknownDevice { wanted, available }
    };
    match choice {
        DeviceChoice::Any => first_usable(infos, |_| true),
        DeviceChoice::Gpu => first_usable(infos, |info| info.kind != CPU),
        DeviceChoice::Name(name) => {
            let matches =
                |info: &DeviceInfo| info.name.to_lowercase().contains(&name.to_lowercase());
            let position = infos.iter().position(matches);
            position.ok_or_else(|| unknown(format!("called \"{name}\"")))
        }
        DeviceChoice::Index(index) if *index < infos.len() => Ok(*index),
        DeviceChoice::Index(index) => Err(unknown(format!("number {index}"))),
    }
}

/// Returns the index of the best device that meets the requirements and for which `will_do` holds.
fn first_usable(
    infos: &[DeviceInfo],
    will_do: impl Fn(&DeviceInfo) -> bool,
) -> Result<usize, VulkanError> {
    let usable = |info: &DeviceInfo| info.unmet.is_empty() && will_do(info);
    let usable = (0..infos.len()).filter(|&index| usable(&infos[index]));
    usable.min_by_key(|&index| rank(infos[index].kind)).ok_or_else(|| {
        let reason = |info: &DeviceInfo| match info.unmet.is_empty() {
            true => format!("\"{}\" is a CPU", info.name),
            false => format!("\"{}\": {}", info.name, info.unmet.join("; ")),
        };
        VulkanError::NoUsableDevice(infos.iter().map(reason).collect::<Vec<_>>().join("; "))
    })
}

fn found(instance: &Instance) -> Result<Vec<(DeviceInfo, vk::PhysicalDevice)>, VulkanError> {
    // SAFETY: the instance is alive.
    let physical_devices = unsafe { instance.handle.enumerate_physical_devices() };
    let physical_devices = match physical_devices {
        // Loaders without any driver return this error.
        Err(vk::Result::ERROR_INITIALIZATION_FAILED) => Vec::new(),
        other => other.map_err(VulkanError::from_call("vkEnumeratePhysicalDevices"))?,
    };
    if physical_devices.is_empty() {
        return Err(VulkanError::NoDevice);
    }
    let describe = |(index, device)| (describe(&instance.handle, index, device), device);
    Ok(physical_devices.into_iter().enumerate().map(describe).collect())
}

fn describe(instance: &ash::Instance, index: usize, device: vk::PhysicalDevice) -> DeviceInfo {
    // SAFETY: the physical device is from this instance.
    let properties = unsafe { instance.get_physical_device_properties(device) };
    let name = properties.device_name_as_c_str().unwrap_or(c"unnamed");
    let driver = driver::words(instance, device, properties.api_version);
    DeviceInfo {
        index,
        name: name.to_string_lossy().into_owned(),
        kind: KINDS
            .iter()
            .find(|kind| kind.0 == properties.device_type)
            .map_or("other", |kind| kind.1),
        api_version: version_text(properties.api_version),
        driver,
        unmet: unmet(instance, device),
    }
}

fn rank(kind: &str) -> usize {
    KINDS.iter().position(|&(_, other)| other == kind).unwrap_or(KINDS.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn devices(kinds: &[(&'static str, bool)]) -> Vec<DeviceInfo> {
        let info = |(index, &(kind, is_usable)): (usize, &(&'static str, bool))| DeviceInfo {
            index,
            name: format!("device {index}"),
            kind,
            api_version: "1.1.0".into(),
            driver: String::new(),
            unmet: if is_usable { Vec::new() } else { vec!["too old".into()] },
        };
        kinds.iter().enumerate().map(info).collect()
    }

    #[test]
    fn the_best_usable_device_is_taken_and_a_cpu_only_where_any_will_do() {
        let machine = devices(&[
            (CPU, true),
            ("integrated GPU", true),
            ("discrete GPU", false),
            ("discrete GPU", true),
            ("discrete GPU", true),
        ]);
        for choice in [DeviceChoice::Any, DeviceChoice::Gpu] {
            assert_eq!(position(&machine, &choice).unwrap(), 3, "{choice:?}");
            assert_eq!(position(&machine[..3], &choice).unwrap(), 1, "{choice:?}");
        }
        let without_gpu = [&machine[..1], &machine[2..3]].concat();
        assert_eq!(position(&without_gpu, &DeviceChoice::Any).unwrap(), 0);
        let error = position(&without_gpu, &DeviceChoice::Gpu).unwrap_err().to_string();
        assert!(error.contains("\"device 0\" is a CPU; \"device 2\": too old"), "{error}");
    }

    #[test]
    fn devices_are_named_by_a_part_of_the_name_or_an_index() {
        let machine = devices(&[("other", true), (CPU, false)]);
        let position = |text: &str| position(&machine, &text.parse().unwrap());
        // `position` also returns devices that are not usable. Its caller checks whether a device is usable.
        assert_eq!((position("DEVICE 1").unwrap(), position("1").unwrap()), (1, 1));
        for wanted in ["2", "card"] {
            let error = position(wanted).unwrap_err().to_string();
            assert!(error.contains("available: 0: \"device 0\", 1: \"device 1\""), "{error}");
        }
    }
}
