//! Descriptor sets of a surface: one for each frame in flight and each slot of its map.

use geosweep::ash::vk;
use geosweep::vulkan::embed::ResultImage;

use crate::Result;
use crate::frames::IN_FLIGHT;
use crate::gpu::Gpu;
use crate::map::Map;
use crate::memory::Buffer;
use crate::shaders::{self, BINDINGS, Layout};

pub struct Sets {
    pool: vk::DescriptorPool,
    by_frame: Vec<[vk::DescriptorSet; IN_FLIGHT]>,
}

impl Sets {
    /// Creates sets with the views by frame, the map's images by slot, and no other resources.
    pub fn new(gpu: &Gpu, layout: &Layout, views: &[Buffer], map: &Map) -> Result<Self> {
        let count = (IN_FLIGHT * views.len()) as u32;
        let sizes = BINDINGS
            .map(|(kind, _)| vk::DescriptorPoolSize::default().ty(kind).descriptor_count(count));
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes);
        // SAFETY: everything that the infos point to is alive.
        let pool = unsafe { gpu.device.create_descriptor_pool(&info, None)? };
        let mut sets = Self { pool, by_frame: Vec::new() };
        for view in views {
            let layouts = [layout.set; IN_FLIGHT];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(pool)
                .set_layouts(&layouts);
            // SAFETY: as above.
            let by_slot: [_; IN_FLIGHT] = unsafe { gpu.device.allocate_descriptor_sets(&info)? }
                .try_into()
                .map_err(|_| "Vulkan gave another number of descriptor sets")?;
            for (slot, &set) in by_slot.iter().enumerate() {
                write_buffer(gpu, set, shaders::VIEW, view.handle);
                write_image(gpu, set, shaders::DISTANCES, map.image(slot)?);
            }
            sets.by_frame.push(by_slot);
        }
        Ok(sets)
    }

    pub fn get(&self, frame: usize, slot: usize) -> vk::DescriptorSet {
        self.by_frame[frame][slot]
    }

    /// Binds a buffer in all sets. No submitted work may be using the sets.
    pub fn bind_buffer(&self, gpu: &Gpu, binding: u32, buffer: vk::Buffer) {
        for &set in self.by_frame.iter().flatten() {
            write_buffer(gpu, set, binding, buffer);
        }
    }

    /// Binds an image in all sets. No submitted work may be using the sets.
    pub fn bind_image(&self, gpu: &Gpu, binding: u32, image: ResultImage) {
        for &set in self.by_frame.iter().flatten() {
            write_image(gpu, set, binding, image);
        }
    }

    pub fn destroy(&self, gpu: &Gpu) {
        // SAFETY: nothing is in flight.
        unsafe { gpu.device.destroy_descriptor_pool(self.pool, None) };
    }
}

fn write_buffer(gpu: &Gpu, set: vk::DescriptorSet, binding: u32, buffer: vk::Buffer) {
    let info = [vk::DescriptorBufferInfo::default().buffer(buffer).range(vk::WHOLE_SIZE)];
    write(gpu, vk::WriteDescriptorSet::default().buffer_info(&info), set, binding);
}

fn write_image(gpu: &Gpu, set: vk::DescriptorSet, binding: u32, image: ResultImage) {
    let info =
        [vk::DescriptorImageInfo::default().image_view(image.view).image_layout(image.layout)];
    write(gpu, vk::WriteDescriptorSet::default().image_info(&info), set, binding);
}

fn write(gpu: &Gpu, write: vk::WriteDescriptorSet, set: vk::DescriptorSet, binding: u32) {
    let (kind, _) = BINDINGS[binding as usize];
    let write = write.dst_set(set).dst_binding(binding).descriptor_type(kind);
    // SAFETY: the set and the resource are alive, and no submitted work uses the set.
    unsafe { gpu.device.update_descriptor_sets(&[write], &[]) };
}
