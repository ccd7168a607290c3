//! What a device must offer.

use ash::vk;

use super::memory::{FORMAT, IMAGE_USAGE};
use super::pipelines::binding;
use crate::constants::WORKGROUP;

/// The Vulkan version needed; instances should be created for it or a later one.
pub const API_VERSION: u32 = vk::API_VERSION_1_1;

/// Names what a device lacks; an empty list means that the engine runs on it. No device
/// extension and no feature is needed.
pub fn unmet_requirements(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
) -> Vec<String> {
    // SAFETY: the physical device is from this instance.
    let properties = unsafe { instance.get_physical_device_properties(physical_device) };
    let mut unmet = Vec::new();
    if properties.api_version < API_VERSION {
        let version = version_text(properties.api_version);
        unmet.push(format!("it supports Vulkan {version}, and 1.1 is needed"));
    }
    if properties.limits.max_compute_work_group_invocations < WORKGROUP {
        let offered = properties.limits.max_compute_work_group_invocations;
        unmet.push(format!("workgroups hold {offered} invocations, and {WORKGROUP} are needed"));
    }
    let images = properties.limits.max_per_stage_descriptor_storage_images;
    if images < binding::IMAGES {
        let needed = binding::IMAGES;
        unmet.push(format!("shaders see {images} storage images, and {needed} are needed"));
    }
    if compute_queue_family(instance, physical_device).is_none() {
        unmet.push("it has no queue for compute".into());
    }
    if largest_side(instance, physical_device).is_none() {
        unmet.push("it has no storage images of four 32-bit floats".into());
    }
    unmet
}

/// A queue family for compute, rather without graphics: on large GPUs that is the async one.
pub(crate) fn compute_queue_family(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
) -> Option<u32> {
    // SAFETY: the physical device is from this instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical_device) };
    let with = |wanted: vk::QueueFlags, unwanted: vk::QueueFlags| {
        families.iter().position(|family| {
            family.queue_flags.contains(wanted) && !family.queue_flags.intersects(unwanted)
        })
    };
    with(vk::QueueFlags::COMPUTE, vk::QueueFlags::GRAPHICS)
        .or_else(|| with(vk::QueueFlags::COMPUTE, vk::QueueFlags::empty()))
        .map(|index| index as u32)
}

/// The largest image side and the largest image size in bytes.
pub(crate) fn largest_side(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
) -> Option<(u32, u64)> {
    // SAFETY: the physical device is from this instance.
    let properties = unsafe {
        instance.get_physical_device_image_format_properties(
            physical_device,
            FORMAT,
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
