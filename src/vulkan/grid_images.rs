//! What a surface and its map occupy on the device.

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocator;

use super::memory::{Buffer, Image};
use super::pipelines::{Pipelines, binding, descriptor_type};
use super::progress::{DeviceProgress, Outcome};
use super::record::HALO;
use super::{TexelChart, VulkanError};
use crate::constants::LAYERS;
use crate::surface::Chart;

/// Points are uploaded, and distances read back, in bands of rows of at most this many bytes.
pub(crate) const BAND_BYTES: usize = 16 << 20;
/// The smallest upload buffer: room for the sources on a small grid.
const LEAST_UPLOAD_BYTES: usize = 64 << 10;
/// Bytes of a point to upload, at most: position and slowness.
pub(crate) const POINT_BYTES: usize = 16;

/// The images of one surface: edge lengths (16 bytes a point), Gaussian curvature (4) and two of
/// fronts (8 each: arrival time and curvature), with the lists of tiles and the buffers for upload
/// and read-back (up to 16 MiB each).
#[derive(Debug)]
pub struct GridImages {
    pub(crate) chart: Chart,
    pub(crate) texels: TexelChart,
    pub(crate) edges: Image,
    pub(crate) gaussian: Image,
    pub(crate) fronts: [Image; 2],
    pub(crate) progress: Buffer,
    pub(crate) outcome: Buffer,
    pub(crate) tiles: Buffer,
    pub(crate) upload: Buffer,
    pub(crate) download: Buffer,
    /// For each of the two images of fronts the descriptors of a pass that writes it and
    /// reads the other.
    pub(crate) sets: [vk::DescriptorSet; 2],
    pool: vk::DescriptorPool,
}

impl GridImages {
    /// Allocates them. The caller has checked the size against the device's limits.
    ///
    /// [`GridImages::destroy`] must be called before device or allocator go.
    pub fn new(
        device: &ash::Device,
        allocator: &mut Allocator,
        pipelines: &Pipelines,
        chart: Chart,
        texels: TexelChart,
    ) -> Result<Self, VulkanError> {
        let mut images = Vec::new();
        let mut buffers = Vec::new();
        let created = (|| {
            for (name, extent, layers) in [
                ("edge lengths", texels.edges_extent(), 1),
                ("Gaussian curvature", texels.fronts_extent(), 1),
                ("fronts 0", texels.fronts_extent(), LAYERS),
                ("fronts 1", texels.fronts_extent(), LAYERS),
            ] {
                images.push(Image::new(device, allocator, name, extent, layers)?);
            }
            let upload = band_rows(chart, POINT_BYTES) + HALO;
            let upload = (upload * chart.cols * POINT_BYTES).max(LEAST_UPLOAD_BYTES);
            let download = band_rows(chart, size_of::<f32>()) * chart.cols * size_of::<f32>();
            for (name, size, location) in [
                ("progress", size_of::<DeviceProgress>(), MemoryLocation::GpuOnly),
                ("outcome", size_of::<Outcome>(), MemoryLocation::GpuToCpu),
                ("tiles", tiles_bytes(texels, pipelines.tuning.tile), MemoryLocation::GpuOnly),
                ("upload", upload, MemoryLocation::CpuToGpu),
                ("read-back", download, MemoryLocation::GpuToCpu),
            ] {
                buffers.push(Buffer::new(device, allocator, name, size as u64, location)?);
            }
            descriptor_pool(device)
        })();
        let pool = match created {
            Ok(pool) => pool,
            Err(error) => {
                images.iter_mut().for_each(|image| image.destroy(device, allocator));
                buffers.iter_mut().for_each(|buffer| buffer.destroy(device, allocator));
                return Err(error);
            }
        };
        let [edges, gaussian, fronts0, fronts1] =
            images.try_into().expect("four images were created");
        let [progress, outcome, tiles, upload, download] =
            buffers.try_into().expect("five buffers were created");
        let mut new = Self {
            chart,
            texels,
            edges,
            gaussian,
            fronts: [fronts0, fronts1],
            progress,
            outcome,
            tiles,
            upload,
            download,
            sets: [vk::DescriptorSet::null(); 2],
            pool,
        };
        match new.describe(device, pipelines) {
            Ok(()) => Ok(new),
            Err(error) => {
                new.destroy(device, allocator);
                Err(error)
            }
        }
    }

    fn describe(&mut self, device: &ash::Device, pipelines: &Pipelines) -> Result<(), VulkanError> {
        let layouts = [pipelines.set_layout; 2];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(self.pool)
            .set_layouts(&layouts);
        // SAFETY: the pool has room for two such sets.
        let sets = unsafe { device.allocate_descriptor_sets(&info) }
            .map_err(VulkanError::from_call("vkAllocateDescriptorSets"))?;
        self.sets = [sets[0], sets[1]];
        for writes in 0..2 {
            let (old, new) = (&self.fronts[1 - writes], &self.fronts[writes]);
            for (index, image) in [
                (binding::EDGES, &self.edges),
                (binding::GAUSSIAN, &self.gaussian),
                (binding::OLD_FRONTS, old),
                (binding::FRONTS_BEHIND, new),
                (binding::NEW_FRONTS, new),
                (binding::OTHER_FRONTS, old),
            ] {
                let info = [vk::DescriptorImageInfo::default()
                    .image_view(image.view)
                    .image_layout(vk::ImageLayout::GENERAL)];
                self.write(device, writes, index, |write| write.image_info(&info));
            }
            for (index, buffer) in [
                (binding::PROGRESS, &self.progress),
                (binding::UPLOAD, &self.upload),
                (binding::DOWNLOAD, &self.download),
                (binding::TILES, &self.tiles),
            ] {
                let info = [vk::DescriptorBufferInfo::default()
                    .buffer(buffer.buffer)
                    .range(vk::WHOLE_SIZE)];
                self.write(device, writes, index, |write| write.buffer_info(&info));
            }
        }
        Ok(())
    }

    fn write<'a>(
        &self,
        device: &ash::Device,
        set: usize,
        index: u32,
        fill: impl FnOnce(vk::WriteDescriptorSet<'a>) -> vk::WriteDescriptorSet<'a>,
    ) {
        let write = vk::WriteDescriptorSet::default()
            .dst_set(self.sets[set])
            .dst_binding(index)
            .descriptor_type(descriptor_type(index < binding::IMAGES));
        // SAFETY: set, image views and buffers are alive, and no submitted work uses the set.
        unsafe { device.update_descriptor_sets(&[fill(write)], &[]) };
    }

    /// How the iterations of the last recording have gone.
    pub(crate) fn outcome(&mut self) -> Outcome {
        *bytemuck::from_bytes(&self.outcome.mapped()[..size_of::<Outcome>()])
    }

    /// Bytes of device and staging memory held.
    pub fn bytes(&self) -> u64 {
        let images = [&self.edges, &self.gaussian, &self.fronts[0], &self.fronts[1]];
        let buffers = [&self.progress, &self.outcome, &self.tiles, &self.upload, &self.download];
        images.iter().map(|image| image.bytes()).sum::<u64>()
            + buffers.iter().map(|buffer| buffer.bytes()).sum::<u64>()
    }

    /// Frees everything. No submitted work may still use it.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut Allocator) {
        // SAFETY: the caller has made sure that nothing uses the sets.
        unsafe { device.destroy_descriptor_pool(self.pool, None) };
        let [fronts0, fronts1] = &mut self.fronts;
        for image in [&mut self.edges, &mut self.gaussian, fronts0, fronts1] {
            image.destroy(device, allocator);
        }
        let Self { progress, outcome, tiles, upload, download, .. } = self;
        for buffer in [progress, outcome, tiles, upload, download] {
            buffer.destroy(device, allocator);
        }
    }
}

/// For each tile its state, the round it waits for, and a place on two lists.
fn tiles_bytes(texels: TexelChart, tile: u32) -> usize {
    let [cols, rows] = texels.tiles(tile);
    4 * size_of::<u32>() * cols as usize * rows as usize
}

/// Rows of a band: even, so that a texel lies in one band.
pub(crate) fn band_rows(chart: Chart, point_bytes: usize) -> usize {
    let rows = BAND_BYTES / (chart.cols * point_bytes);
    (rows / 2 * 2).clamp(2, chart.rows.next_multiple_of(2))
}

fn descriptor_pool(device: &ash::Device) -> Result<vk::DescriptorPool, VulkanError> {
    let size = |is_image, count| {
        vk::DescriptorPoolSize::default().ty(descriptor_type(is_image)).descriptor_count(2 * count)
    };
    let sizes = [size(true, binding::IMAGES), size(false, binding::ALL - binding::IMAGES)];
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(2).pool_sizes(&sizes);
    // SAFETY: nothing is borrowed beyond the call.
    unsafe { device.create_descriptor_pool(&info, None) }
        .map_err(VulkanError::from_call("vkCreateDescriptorPool"))
}
