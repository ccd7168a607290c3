//! States what a device must offer, so that a program can check it before it creates the device.
//!
//! The engine needs an instance for Vulkan 1.1 or later and a device with a queue family for compute. No
//! extension and no feature has to be enabled, and no limit has to exceed the minimum that Vulkan guarantees.
//! [`unmet`] lists the requirements that a physical device does not meet. [`API_VERSION`],
//! [`DEVICE_EXTENSIONS`] and [`features`] let a program merge the requirements with its own. Such a program
//! stays correct if the requirements ever grow. A device that offers `VK_KHR_portability_subset`, such as a
//! device of MoltenVK, requires every program to enable that extension. This crate uses nothing that such a
//! device leaves out.
//!
//! ```no_run
//! # use geosweep::ash::{self, vk};
//! # fn pick(instance: &ash::Instance) -> Result<vk::PhysicalDevice, Box<dyn std::error::Error>> {
//! use geosweep::vulkan::requirements;
//! for physical_device in unsafe { instance.enumerate_physical_devices() }? {
//!     match requirements::unmet(instance, physical_device).as_slice() {
//!         [] => return Ok(physical_device),
//!         lacking => eprintln!("not this one: {}", lacking.join("; ")),
//!     }
//! }
//! # Err("none".into()) }
//! ```

use std::ffi::CStr;

use ash::{khr, vk};

use super::descriptors::{SETS, most_seen};
use super::driver;
use super::memory::{FORMAT, IMAGE_USAGE, RESULT_FORMAT};
use super::passes::PUSH_CONSTANT_BYTES;
use crate::constants::{MOST_GROUPS, SURROUNDINGS_WORKGROUP};

/// Vulkan version needed. Instances should be created for this version or a later one.
pub const API_VERSION: u32 = vk::API_VERSION_1_1;

/// Device extensions needed: none.
pub const DEVICE_EXTENSIONS: &[&CStr] = &[];

/// Returns the device features needed: none.
pub fn features() -> vk::PhysicalDeviceFeatures {
    vk::PhysicalDeviceFeatures::default()
}

/// Shared memory of a workgroup that every device offers, in bytes. The pass over the surroundings of sources
/// needs most of it.
const SHARED_MEMORY_BYTES: u32 = 16 << 10;

/// Returns the requirements that a device does not meet, and known faults of its driver that make maps wrong. If the
/// list is empty, the engine runs on the device.
pub fn unmet(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> Vec<String> {
    // SAFETY: the physical device is from this instance.
    let properties = unsafe { instance.get_physical_device_properties(physical_device) };
    let mut unmet = Vec::new();
    if properties.api_version < API_VERSION {
        let version = version_text(properties.api_version);
        unmet.push(format!("it supports Vulkan {version}, but 1.1 is needed"));
    }
    let driver = driver::words(instance, physical_device, properties.api_version);
    unmet.extend(driver::known_fault(&driver).map(str::to_owned));
    let limits = properties.limits;
    for (what, offered, needed) in [
        // The widest workgroup whose size is not a matter of tuning.
        (
            "workgroups hold # invocations",
            limits.max_compute_work_group_invocations,
            SURROUNDINGS_WORKGROUP,
        ),
        (
            "workgroups are # invocations wide",
            limits.max_compute_work_group_size[0],
            SURROUNDINGS_WORKGROUP,
        ),
        (
            "workgroups share # bytes of memory",
            limits.max_compute_shared_memory_size,
            SHARED_MEMORY_BYTES,
        ),
        (
            "dispatches are # workgroups wide",
            limits.max_compute_work_group_count.into_iter().min().unwrap_or(0),
            MOST_GROUPS,
        ),
        ("shaders see # descriptor sets", limits.max_bound_descriptor_sets, SETS),
        (
            "shaders see # storage images",
            limits.max_per_stage_descriptor_storage_images,
            most_seen(vk::DescriptorType::STORAGE_IMAGE),
        ),
        (
            "shaders see # storage buffers",
            limits.max_per_stage_descriptor_storage_buffers,
            most_seen(vk::DescriptorType::STORAGE_BUFFER),
        ),
        (
            "there are # bytes of push constants",
            limits.max_push_constants_size,
            PUSH_CONSTANT_BYTES,
        ),
    ] {
        if offered < needed {
            let what = what.replace('#', &offered.to_string());
            unmet.push(format!("{what}, but {needed} are needed"));
        }
    }
    if compute_queue_family(instance, physical_device).is_none() {
        unmet.push("it has no queue for compute".into());
    }
    if largest_side(instance, physical_device).is_none() {
        unmet.push("it has no storage images of four 32-bit floats".into());
    }
    if largest(instance, physical_device, RESULT_FORMAT).is_none() {
        unmet.push("it has no storage images of one 32-bit float".into());
    }
    unmet
}

/// Message about an instance that was created for Vulkan 1.0.
pub const FOR_VULKAN_1_0: &str = "its instance was created for Vulkan 1.0, but 1.1 is needed: request it in \
                                         VkApplicationInfo::apiVersion";

/// Returns whether a device lacks the functions of Vulkan 1.1, as it does if its instance was created for 1.0, whatever
/// the driver supports.
pub fn is_for_vulkan_1_0(instance: &ash::Instance, device: &ash::Device) -> bool {
    let name = c"vkTrimCommandPool".as_ptr();
    // SAFETY: the device is from this instance.
    unsafe { (instance.fp_v1_0().get_device_proc_addr)(device.handle(), name) }.is_none()
}

/// Returns a queue family for compute. A family without graphics is preferred: on large GPUs that is the
/// async compute queue.
pub fn compute_queue_family(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
) -> Option<u32> {
    // SAFETY: the physical device is from this instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical_device) };
    compute_family(&families)
}

fn compute_family(families: &[vk::QueueFamilyProperties]) -> Option<u32> {
    let with = |wanted: vk::QueueFlags, unwanted: vk::QueueFlags| {
        families.iter().position(|family| {
            family.queue_flags.contains(wanted) && !family.queue_flags.intersects(unwanted)
        })
    };
    with(vk::QueueFlags::COMPUTE, vk::QueueFlags::GRAPHICS)
        .or_else(|| with(vk::QueueFlags::COMPUTE, vk::QueueFlags::empty()))
        .map(|index| index as u32)
}

/// Returns whether a device offers the extension `VK_KHR_portability_subset`. Such a device implements Vulkan
/// except for some features, and requires programs to enable that extension.
pub(crate) fn is_portable_subset(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
) -> bool {
    // SAFETY: the physical device is from this instance.
    let offered = unsafe { instance.enumerate_device_extension_properties(physical_device) };
    have(&offered.unwrap_or_default(), khr::portability_subset::NAME)
}

/// Returns whether an extension is among those that are offered.
pub(in crate::vulkan) fn have(offered: &[vk::ExtensionProperties], name: &CStr) -> bool {
    offered.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name))
}

/// Returns the largest side of a grid's images in texels, and their largest size in bytes.
pub(crate) fn largest_side(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
) -> Option<(u32, u64)> {
    largest(instance, physical_device, FORMAT)
}

fn largest(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
    format: vk::Format,
) -> Option<(u32, u64)> {
    // SAFETY: the physical device is from this instance.
    let properties = unsafe {
        instance.get_physical_device_image_format_properties(
            physical_device,
            format,
            vk::ImageType::TYPE_2D,
            vk::ImageTiling::OPTIMAL,
            IMAGE_USAGE,
            vk::ImageCreateFlags::empty(),
        )
    };
    let properties = properties.ok()?;
    let side = properties.max_extent.width.min(properties.max_extent.height);
    Some((side, properties.max_resource_size))
}

pub(crate) fn version_text(version: u32) -> String {
    let (major, minor) = (vk::api_version_major(version), vk::api_version_minor(version));
    format!("{major}.{minor}.{}", vk::api_version_patch(version))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_family_without_graphics_goes_first() {
        let (graphics, compute) = (vk::QueueFlags::GRAPHICS, vk::QueueFlags::COMPUTE);
        let chosen = |flags: &[vk::QueueFlags]| {
            let family =
                |&queue_flags| vk::QueueFamilyProperties { queue_flags, ..Default::default() };
            compute_family(&flags.iter().map(family).collect::<Vec<_>>())
        };
        let transfer = vk::QueueFlags::TRANSFER;
        assert_eq!(chosen(&[graphics | compute, transfer, compute | transfer]), Some(2));
        assert_eq!(chosen(&[graphics, graphics | compute]), Some(1));
        assert_eq!(chosen(&[graphics, transfer]), None);
        assert_eq!(chosen(&[]), None);
    }
}
