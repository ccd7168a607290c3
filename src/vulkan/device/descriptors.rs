//! Creates the descriptor sets of a surface and of the resources in which its maps are solved.
//!
//! Every device can bind four storage images and four storage buffers to a pass. Each pass therefore uses two
//! sets. The surface's set contains the fronts that the pass reads and the progress of the map. The other set is either
//! the set of a map, with the fronts that the pass writes, or a set of the host.

use ash::vk;

use super::memory::{Buffer, Image};
use super::pipelines::Pipelines;
use super::shaders::{count_of, set_0, set_1, set_2};
use crate::vulkan::VulkanError;

/// Index at which the host's sets are bound. `MAP` is the index of the sets of maps.
const HOST: u32 = 1;
const MAP: u32 = 2;

/// Number of sets in the layout of a pass, including the sets that the pass does not use.
pub(crate) const SETS: u32 = MAP + 1;

/// Returns the largest number of storage images, or of storage buffers, that a pass uses.
pub(crate) const fn most_seen(kind: vk::DescriptorType) -> u32 {
    let (host, map) = (count_of(kind, &set_1::KINDS), count_of(kind, &set_2::KINDS));
    count_of(kind, &set_0::KINDS) + if host > map { host } else { map }
}

const _: () = assert!(
    most_seen(vk::DescriptorType::STORAGE_IMAGE) <= 4
        && most_seen(vk::DescriptorType::STORAGE_BUFFER) <= 4,
    "devices need offer no more than four of each"
);

/// Descriptor sets bound to a pass.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sets {
    surface: vk::DescriptorSet,
    /// Index of the other set, and the set itself.
    other: (u32, vk::DescriptorSet),
}

impl Sets {
    /// Returns the sets of the same surface and fronts, with a set of the host.
    pub(crate) fn with_host(self, set: vk::DescriptorSet) -> Self {
        Self { other: (HOST, set), ..self }
    }

    /// Binds the sets for pipelines with this layout.
    ///
    /// # Safety
    /// The command buffer is being recorded on the device, and the layout is that of passes which use such
    /// sets.
    pub(crate) unsafe fn bind(
        self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        layout: vk::PipelineLayout,
    ) {
        for (number, set) in [(0, self.surface), self.other] {
            let compute = vk::PipelineBindPoint::COMPUTE;
            // SAFETY: as the caller has promised.
            unsafe {
                device.cmd_bind_descriptor_sets(commands, compute, layout, number, &[set], &[]);
            }
        }
    }
}

/// Resources of the sets of a grid, or of a batch. Resources that no pass uses are `None`.
#[derive(Clone, Copy)]
pub(crate) struct Contents<'a> {
    pub(crate) edges: &'a Image,
    pub(crate) gaussian: &'a Image,
    pub(crate) fronts: Option<[&'a Image; 2]>,
    /// Points, seeds and anchors, or fans.
    pub(crate) points: Option<&'a Buffer>,
    pub(crate) progress: &'a Buffer,
    /// Tiles, or maps that are kept.
    pub(crate) tiles: Option<&'a Buffer>,
    /// Blocks of lines, or distances of maps in shared memory.
    pub(crate) blocks: &'a Buffer,
    /// Buffer to which [`UNPACK`](super::passes::UNPACK) writes distances.
    pub(crate) distances: &'a Buffer,
}

/// Descriptor sets of a grid, or of a batch.
#[derive(Debug, Default)]
pub(crate) struct GridSets {
    /// Sets of passes that write one image of fronts and read the other, for each of the two images.
    pub(crate) writing: [Sets; 2],
    /// Set of the pass that unpacks distances, in the place of a set of the host.
    pub(crate) read_back: vk::DescriptorSet,
    pool: vk::DescriptorPool,
}

impl GridSets {
    /// Allocates and fills the sets. [`GridSets::destroy`] must be called before the device is destroyed.
    pub(crate) fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        contents: Contents,
    ) -> Result<Self, VulkanError> {
        let [surface, map] = [&set_0::KINDS[..], &set_2::KINDS];
        let all = [surface, surface, map, map, &set_1::KINDS];
        let mut new = Self { pool: pool(device, &all)?, ..Self::default() };
        let [surface, map] = [pipelines.surface_set_layout, pipelines.map_set_layout];
        let layouts = [surface, surface, map, map, pipelines.host_set_layout];
        let sets = match allocate(device, new.pool, &layouts) {
            Ok(sets) => sets,
            Err(error) => {
                new.destroy(device);
                return Err(error);
            }
        };
        for writes in 0..2 {
            let (surface, map) = (sets[writes], sets[2 + writes]);
            new.writing[writes] = Sets { surface, other: (MAP, map) };
            pipelines.name(["reads fronts 1", "reads fronts 0"][writes], surface);
            pipelines.name(["writes fronts 0", "writes fronts 1"][writes], map);
            fill(device, (surface, map), writes, contents);
        }
        new.read_back = sets[4];
        pipelines.name("distances", new.read_back);
        write_buffer(device, new.read_back, set_1::OUTPUT, contents.distances);
        Ok(new)
    }

    /// Frees the sets. No submitted work may still use them.
    pub(crate) fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: the caller has made sure that nothing uses the sets; a null handle is allowed.
        unsafe { device.destroy_descriptor_pool(std::mem::take(&mut self.pool), None) };
    }
}

/// Resources of a grid that passes over copies of points use.
#[derive(Clone, Copy)]
pub(crate) struct GridContents<'a> {
    /// Sets of the grid, whose sets of maps serve here too.
    pub(crate) sets: &'a GridSets,
    pub(crate) edges: &'a Image,
    pub(crate) gaussian: &'a Image,
    pub(crate) fronts: [&'a Image; 2],
    pub(crate) progress: &'a Buffer,
}

/// Descriptor sets of the passes that exchange fronts between the copies of a point and share its curvature. Their
/// list of copies takes the place of points and seeds, since devices need offer no more than four buffers.
#[derive(Debug, Default)]
pub(crate) struct CopySets {
    /// The sets of [`GridSets::writing`], with the list of copies. Their pass may also read and write the other image,
    /// where the fronts of some tiles lie after a round.
    pub(crate) writing: [Sets; 2],
    /// Surface's set of passes over a finished map, with the list by rows; null if there is none.
    by_rows: vk::DescriptorSet,
    pool: vk::DescriptorPool,
}

impl CopySets {
    /// Allocates and fills the sets. [`CopySets::destroy`] must be called before the device is destroyed.
    pub(crate) fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        contents: GridContents,
        copies: &Buffer,
        by_rows: Option<(u64, u64)>,
    ) -> Result<Self, VulkanError> {
        let GridContents { sets: grid, edges, gaussian, fronts, progress } = contents;
        let mut new = Self { pool: pool(device, &[&set_0::KINDS[..]; 3])?, ..Self::default() };
        let sets = match allocate(device, new.pool, &[pipelines.surface_set_layout; 3]) {
            Ok(sets) => sets,
            Err(error) => {
                new.destroy(device);
                return Err(error);
            }
        };
        let fill = |surface, writes: usize| {
            write_image(device, surface, set_0::EDGES, edges);
            write_image(device, surface, set_0::GAUSSIANS, gaussian);
            write_image(device, surface, set_0::OLD_FRONTS, fronts[1 - writes]);
            write_buffer(device, surface, set_0::PROGRESS, progress);
        };
        for writes in 0..2 {
            let surface = sets[writes];
            pipelines.name(["exchanges in fronts 0", "exchanges in fronts 1"][writes], surface);
            fill(surface, writes);
            write_buffer(device, surface, set_0::COPIES, copies);
            new.writing[writes] = Sets { surface, ..grid.writing[writes] };
        }
        if let Some(part) = by_rows {
            pipelines.name("reads fronts 0 and copies", sets[2]);
            fill(sets[2], 1);
            write_part(device, sets[2], set_0::COPIES_BY_ROW, copies, part);
            new.by_rows = sets[2];
        }
        Ok(new)
    }

    /// Returns the sets of a pass over a finished map that finds copies of points in the list by rows, with a set of the
    /// host. Returns `None` if there is no such list.
    pub(crate) fn with_host(&self, set: vk::DescriptorSet) -> Option<Sets> {
        let surface = Some(self.by_rows).filter(|&surface| surface != vk::DescriptorSet::null())?;
        Some(Sets { surface, other: (HOST, set) })
    }

    /// Frees the sets. No submitted work may still use them.
    pub(crate) fn destroy(&mut self, device: &ash::Device) {
        // SAFETY: the caller has made sure that nothing uses the sets; a null handle is allowed.
        unsafe { device.destroy_descriptor_pool(std::mem::take(&mut self.pool), None) };
    }
}

/// Allocates sets from a pool that has room for them.
fn allocate(
    device: &ash::Device,
    pool: vk::DescriptorPool,
    layouts: &[vk::DescriptorSetLayout],
) -> Result<Vec<vk::DescriptorSet>, VulkanError> {
    let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(layouts);
    // SAFETY: the caller has made sure that the pool has room for these sets.
    unsafe { device.allocate_descriptor_sets(&info) }
        .map_err(VulkanError::from_call("vkAllocateDescriptorSets"))
}

/// Creates a pool with room for sets, given by the kinds of their descriptors.
fn pool(
    device: &ash::Device,
    sets: &[&[vk::DescriptorType]],
) -> Result<vk::DescriptorPool, VulkanError> {
    let kinds = [
        vk::DescriptorType::STORAGE_IMAGE,
        vk::DescriptorType::STORAGE_BUFFER,
        vk::DescriptorType::SAMPLED_IMAGE,
    ];
    let size = |kind| {
        let count = sets.iter().map(|set| count_of(kind, set)).sum();
        vk::DescriptorPoolSize::default().ty(kind).descriptor_count(count)
    };
    let sizes: Vec<_> =
        kinds.map(size).into_iter().filter(|size| size.descriptor_count > 0).collect();
    let info =
        vk::DescriptorPoolCreateInfo::default().max_sets(sets.len() as u32).pool_sizes(&sizes);
    // SAFETY: nothing is borrowed beyond the call.
    unsafe { device.create_descriptor_pool(&info, None) }
        .map_err(VulkanError::from_call("vkCreateDescriptorPool"))
}

/// Fills the sets of passes that write one of the images of fronts.
fn fill(
    device: &ash::Device,
    (surface, map): (vk::DescriptorSet, vk::DescriptorSet),
    writes: usize,
    contents: Contents,
) {
    let Contents { edges, gaussian, fronts, points, progress, tiles, blocks, .. } = contents;
    write_image(device, surface, set_0::EDGES, edges);
    write_image(device, surface, set_0::GAUSSIANS, gaussian);
    write_buffer(device, surface, set_0::PROGRESS, progress);
    write_buffer(device, map, set_2::BLOCKS, blocks);
    if let Some(fronts) = fronts {
        write_image(device, surface, set_0::OLD_FRONTS, fronts[1 - writes]);
        write_image(device, map, set_2::NEW_FRONTS, fronts[writes]);
    }
    if let Some(points) = points {
        write_buffer(device, surface, set_0::POINTS, points);
    }
    if let Some(tiles) = tiles {
        write_buffer(device, map, set_2::TILES, tiles);
    }
}

fn write_image(device: &ash::Device, set: vk::DescriptorSet, index: u32, image: &Image) {
    let info = [vk::DescriptorImageInfo::default()
        .image_view(image.view)
        .image_layout(vk::ImageLayout::GENERAL)];
    let write = blank(set, index, vk::DescriptorType::STORAGE_IMAGE).image_info(&info);
    // SAFETY: set and image are alive, and no submitted work uses the set, which is new.
    unsafe { device.update_descriptor_sets(&[write], &[]) };
}

fn write_buffer(device: &ash::Device, set: vk::DescriptorSet, index: u32, buffer: &Buffer) {
    write_part(device, set, index, buffer, (0, vk::WHOLE_SIZE));
}

/// Writes the part of a buffer with this offset and size.
fn write_part(
    device: &ash::Device,
    set: vk::DescriptorSet,
    index: u32,
    buffer: &Buffer,
    (offset, range): (u64, u64),
) {
    let info = vk::DescriptorBufferInfo { buffer: buffer.buffer, offset, range };
    let info = [info];
    let write = blank(set, index, vk::DescriptorType::STORAGE_BUFFER).buffer_info(&info);
    // SAFETY: set and buffer are alive, and no submitted work uses the set, which is new.
    unsafe { device.update_descriptor_sets(&[write], &[]) };
}

fn blank<'a>(
    set: vk::DescriptorSet,
    index: u32,
    kind: vk::DescriptorType,
) -> vk::WriteDescriptorSet<'a> {
    vk::WriteDescriptorSet::default().dst_set(set).dst_binding(index).descriptor_type(kind)
}
