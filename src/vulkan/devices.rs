//! What Vulkan offers on this machine.

use std::ffi::CStr;

use ash::vk;

use super::VulkanError;
use super::instance::Instance;
use super::requirements::{API_VERSION, unmet, version_text};

/// Which Vulkan device, in the order of [`devices`].
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DeviceChoice {
    /// The first usable one: a discrete GPU before an integrated one before others.
    #[default]
    Any,
    /// The first whose name contains this text, whatever the case.
    Name(String),
    /// The one with this index.
    Index(usize),
}

/// An index, or else a part of the name.
impl std::str::FromStr for DeviceChoice {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(text.parse().map_or_else(|_| Self::Name(text.to_owned()), Self::Index))
    }
}

/// A Vulkan device of this machine.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceInfo {
    /// Position in the list.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// `discrete GPU`, `integrated GPU`, `virtual GPU`, `CPU` or `other`.
    pub kind: &'static str,
    /// The Vulkan version it supports.
    pub api_version: String,
    /// Name and version of its driver, where the driver tells them.
    pub driver: String,
    /// What it lacks for this crate; empty if it is usable.
    pub unmet: Vec<String>,
}

/// Lists the Vulkan devices of this machine, usable or not.
///
/// # Errors
/// If there is no loader, or it finds no device.
pub fn devices() -> Result<Vec<DeviceInfo>, VulkanError> {
    let instance = Instance::new(false)?;
    Ok(found(&instance)?.into_iter().map(|(info, _)| info).collect())
}

/// Chooses a device.
pub(crate) fn choose(
    instance: &Instance,
    choice: &DeviceChoice,
) -> Result<(DeviceInfo, vk::PhysicalDevice), VulkanError> {
    let mut found = found(instance)?;
    let available = || {
        let entry = |info: &DeviceInfo| format!("{}: \"{}\"", info.index, info.name);
        found.iter().map(|(info, _)| entry(info)).collect::<Vec<_>>().join(", ")
    };
    let wanted = match choice {
        DeviceChoice::Any => {
            found.sort_by_key(|(info, _)| rank(info.kind));
            let reasons: Vec<_> = found
                .iter()
                .map(|(info, _)| format!("\"{}\": {}", info.name, info.unmet.join("; ")))
                .collect();
            let usable = found.into_iter().find(|(info, _)| info.unmet.is_empty());
            return usable.ok_or_else(|| VulkanError::NoUsableDevice(reasons.join("; ")));
        }
        DeviceChoice::Name(name) => {
            let matches =
                |info: &DeviceInfo| info.name.to_lowercase().contains(&name.to_lowercase());
            found.iter().position(|(info, _)| matches(info)).ok_or_else(|| {
                VulkanError::UnknownDevice {
                    wanted: format!("called \"{name}\""),
                    available: available(),
                }
            })?
        }
        DeviceChoice::Index(index) if *index < found.len() => *index,
        DeviceChoice::Index(index) => {
            return Err(VulkanError::UnknownDevice {
                wanted: format!("number {index}"),
                available: available(),
            });
        }
    };
    let (info, physical_device) = found.swap_remove(wanted);
    if info.unmet.is_empty() {
        Ok((info, physical_device))
    } else {
        Err(VulkanError::Unusable { device: info.name, unmet: info.unmet.join("; ") })
    }
}

fn found(instance: &Instance) -> Result<Vec<(DeviceInfo, vk::PhysicalDevice)>, VulkanError> {
    // SAFETY: the instance is alive.
    let physical_devices = unsafe { instance.handle.enumerate_physical_devices() };
    let physical_devices = match physical_devices {
        // Loaders without any driver answer so.
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
    DeviceInfo {
        index,
        name: name.to_string_lossy().into_owned(),
        kind: match properties.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete GPU",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated GPU",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual GPU",
            vk::PhysicalDeviceType::CPU => "CPU",
            _ => "other",
        },
        api_version: version_text(properties.api_version),
        driver: driver(instance, device, properties.api_version),
        unmet: unmet(instance, device),
    }
}

fn driver(instance: &ash::Instance, device: vk::PhysicalDevice, api_version: u32) -> String {
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

fn rank(kind: &str) -> usize {
    let order = ["discrete GPU", "integrated GPU", "virtual GPU", "CPU"];
    order.iter().position(|&other| other == kind).unwrap_or(order.len())
}
