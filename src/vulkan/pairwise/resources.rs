//! Allocates the images and buffers of a batch on the device.

use crate::vulkan::device::device_memory::DeviceMemory;
use ash::vk;
use gpu_allocator::MemoryLocation;

use super::layout::BatchLayout;
use super::progress;
use crate::vulkan::VulkanError;
use crate::vulkan::copies::Copies;
use crate::vulkan::device::descriptors::{Contents, GridContents, GridSets};
use crate::vulkan::device::memory::{Buffer, BufferInfo, FORMAT, Image, ImageInfo};
use crate::vulkan::device::pipelines::Pipelines;
use crate::vulkan::device::staging::Staging;
use crate::vulkan::grid_images::GridImages;

/// Images and buffers of a batch, including the buffers that the host writes and reads.
#[derive(Debug, Default)]
pub(super) struct Resources {
    /// Two images of fronts; none if maps lie in shared memory.
    pub(super) fronts: Vec<Image>,
    buffers: Vec<Buffer>,
    /// Buffer in the host's memory for the distances of two batches, if the device has memory of its own.
    staging: Option<Staging>,
    pub(super) sets: GridSets,
    /// Copies of the points of a glued surface.
    pub(super) copies: Option<Copies>,
}

/// Buffers, in their order in [`Resources`].
enum Kind {
    Staging,
    Progress,
    Outcome,
    Distances,
    /// `Fans` and `Kept` exist only for maps in shared memory.
    Fans,
    Kept,
}

impl Resources {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        pipelines: &Pipelines,
        grid: &GridImages,
        layout: &BatchLayout,
    ) -> Result<Self, VulkanError> {
        let mut new = Self::default();
        match new.create(device, allocator, pipelines, grid, layout) {
            Ok(()) => Ok(new),
            Err(error) => {
                new.destroy(device, allocator);
                Err(error)
            }
        }
    }

    fn create(
        &mut self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        pipelines: &Pipelines,
        grid: &GridImages,
        layout: &BatchLayout,
    ) -> Result<(), VulkanError> {
        if layout.workgroup.is_none() {
            for name in ["batch of fronts 0", "batch of fronts 1"] {
                let extent = grid.texels.fronts_extent();
                let layers = layout.layers();
                let info = ImageInfo { name, format: FORMAT, extent, layers, families: &[] };
                self.fronts.push(Image::new(device, allocator, info)?);
                pipelines.name_image(name, &self.fronts[self.fronts.len() - 1]);
            }
        }
        let progress = progress::bytes(layout.maps);
        let is_staged = pipelines.tuning.staged;
        let distances = if is_staged { MemoryLocation::GpuOnly } else { MemoryLocation::GpuToCpu };
        let all = [
            ("sources of a batch", progress, MemoryLocation::CpuToGpu),
            ("progress of a batch", progress, MemoryLocation::GpuOnly),
            ("outcome of a batch", progress, MemoryLocation::GpuToCpu),
            ("distances of a batch", layout.distances(), distances),
            ("fans", layout.fans(), MemoryLocation::GpuOnly),
            ("maps of a batch", layout.kept(), MemoryLocation::GpuOnly),
        ];
        for (name, size, location) in all.into_iter().filter(|(_, size, _)| *size > 0) {
            self.buffers.push(Buffer::new(device, allocator, BufferInfo { name, size, location })?);
            pipelines.name(name, self.buffers[self.buffers.len() - 1].buffer);
        }
        if is_staged {
            let sizes = (layout.distances() as usize, 0);
            let name = "staging of a batch";
            self.staging = Some(Staging::new(device, allocator, pipelines, name, sizes)?);
        }
        let in_shared_memory = layout.workgroup.is_some();
        let of_workgroups = |kind| in_shared_memory.then(|| self.buffer(kind));
        let contents = Contents {
            edges: &grid.edges,
            gaussian: &grid.gaussian,
            fronts: self.fronts.first_chunk().map(<[Image; 2]>::each_ref),
            points: of_workgroups(Kind::Fans),
            progress: self.progress(),
            tiles: of_workgroups(Kind::Kept),
            blocks: self.distances(),
            distances: self.distances(),
            owner: &grid.owner,
        };
        self.sets = GridSets::new(device, pipelines, contents)?;
        if let (Some(of_grid), Some(fronts)) = (&grid.copies, self.fronts.first_chunk::<2>()) {
            let of_batch = GridContents {
                sets: &self.sets,
                edges: &grid.edges,
                gaussian: &grid.gaussian,
                fronts: fronts.each_ref(),
                progress: self.progress(),
                owner: &grid.owner,
            };
            let list = of_grid.list().of_batch(layout.maps);
            self.copies = Some(Copies::new(device, allocator, pipelines, list, of_batch)?);
        }
        Ok(())
    }

    fn buffer(&self, kind: Kind) -> &Buffer {
        &self.buffers[kind as usize]
    }

    /// Returns the buffer of the maps' progress on the device.
    pub(super) fn progress(&self) -> &Buffer {
        self.buffer(Kind::Progress)
    }

    pub(super) fn staging(&self) -> &Buffer {
        self.buffer(Kind::Staging)
    }

    pub(super) fn outcome(&self) -> &Buffer {
        self.buffer(Kind::Outcome)
    }

    /// Returns the memory to which the host writes the progress of a batch before the first iteration.
    pub(super) fn write_staging(&mut self) -> &mut [u8] {
        self.buffers[Kind::Staging as usize].mapped()
    }

    /// Returns the progress of a batch after its report.
    pub(super) fn read_outcome(&mut self) -> &[u8] {
        self.buffers[Kind::Outcome as usize].mapped()
    }

    /// Returns the buffer to which shaders write the distances of a batch.
    pub(super) fn distances(&self) -> &Buffer {
        self.buffer(Kind::Distances)
    }

    /// Returns whether distances are copied to the host's memory.
    pub(super) fn is_staged(&self) -> bool {
        self.staging.is_some()
    }

    /// Returns the buffer and the offset to which distances are copied, for a half of the staging buffer. The
    /// batch must have a staging buffer.
    pub(super) fn staged_at(&self, half: usize) -> (vk::Buffer, u64) {
        self.staging.as_ref().expect("distances are copied only to staging").at(half)
    }

    /// Returns the distances of a batch, map after map. If distances are copied to the staging buffer, `half`
    /// is the half that holds them.
    pub(super) fn read_distances(&self, half: usize) -> &[u8] {
        match &self.staging {
            Some(staging) => staging.read(half),
            None => self.distances().read(),
        }
    }

    /// Returns the bytes of device and staging memory held.
    pub(super) fn bytes(&self) -> u64 {
        self.fronts.iter().map(Image::bytes).sum::<u64>()
            + self.buffers.iter().map(Buffer::bytes).sum::<u64>()
            + self.staging.as_ref().map_or(0, Staging::bytes)
            + self.copies.as_ref().map_or(0, Copies::bytes)
    }

    /// Frees everything. No submitted work may still use it.
    pub(super) fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        self.copies.iter_mut().for_each(|copies| copies.destroy(device, allocator));
        self.sets.destroy(device);
        self.fronts.iter_mut().for_each(|image| image.destroy(device, allocator));
        self.buffers.iter_mut().for_each(|buffer| buffer.destroy(device, allocator));
        self.staging.iter_mut().for_each(|staging| staging.destroy(device, allocator));
    }
}
