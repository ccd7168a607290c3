//! Descriptor sets: for each of two images of fronts the one of passes that write it.

use ash::vk;

use super::VulkanError;
use super::memory::{Buffer, Image};
use super::pipelines::Pipelines;
use super::shaders::{count_of, set_0};

/// A pool with room for two sets.
pub(crate) fn pool(device: &ash::Device) -> Result<vk::DescriptorPool, VulkanError> {
    let size = |kind| {
        let count = 2 * count_of(kind, &set_0::KINDS);
        vk::DescriptorPoolSize::default().ty(kind).descriptor_count(count)
    };
    let kinds = [vk::DescriptorType::STORAGE_IMAGE, vk::DescriptorType::STORAGE_BUFFER];
    let sizes = kinds.map(size);
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(2).pool_sizes(&sizes);
    // SAFETY: nothing is borrowed beyond the call.
    unsafe { device.create_descriptor_pool(&info, None) }
        .map_err(VulkanError::from_call("vkCreateDescriptorPool"))
}

/// The sets of such a pool.
pub(crate) fn sets(
    device: &ash::Device,
    pool: vk::DescriptorPool,
    pipelines: &Pipelines,
) -> Result<[vk::DescriptorSet; 2], VulkanError> {
    let layouts = [pipelines.set_layout; 2];
    let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
    // SAFETY: the pool has room for two such sets.
    let sets = unsafe { device.allocate_descriptor_sets(&info) }
        .map_err(VulkanError::from_call("vkAllocateDescriptorSets"))?;
    Ok([sets[0], sets[1]])
}

/// Binds an image in a set, which no submitted work may use.
pub(crate) fn write_image(device: &ash::Device, set: vk::DescriptorSet, index: u32, image: &Image) {
    let info = [vk::DescriptorImageInfo::default()
        .image_view(image.view)
        .image_layout(vk::ImageLayout::GENERAL)];
    write(device, blank(set, index).image_info(&info));
}

/// Binds a buffer in a set, which no submitted work may use.
pub(crate) fn write_buffer(
    device: &ash::Device,
    set: vk::DescriptorSet,
    index: u32,
    buffer: &Buffer,
) {
    let info = [vk::DescriptorBufferInfo::default().buffer(buffer.buffer).range(vk::WHOLE_SIZE)];
    write(device, blank(set, index).buffer_info(&info));
}

fn blank<'a>(set: vk::DescriptorSet, index: u32) -> vk::WriteDescriptorSet<'a> {
    vk::WriteDescriptorSet::default()
        .dst_set(set)
        .dst_binding(index)
        .descriptor_type(set_0::KINDS[index as usize])
}

fn write(device: &ash::Device, write: vk::WriteDescriptorSet) {
    // SAFETY: set and resource are alive, and the caller has made sure that nothing uses the set.
    unsafe { device.update_descriptor_sets(&[write], &[]) };
}
