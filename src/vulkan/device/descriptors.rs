//! Creates the descriptor sets of a surface and of the resources in which its maps are solved.
//!
//! Every device can bind four storage images and four storage buffers to a pass. Each pass therefore uses two
//! sets. The surface's set contains the fronts that the pass reads and the progress of the map. The other set is either
//! the set of a map, with the fronts that the pass writes, or a set of the host.

use ash::vk;

use super::labels::NameOf;
use super::memory::{Buffer, Image};
use super::pipelines::Pipelines;
use super::shaders::{count_of, set_0, set_1, set_2};
use crate::vulkan::VulkanError;

/// Indices at which sets are bound: those of surfaces, of the host, and of maps.
const SURFACE: u32 = 0;
pub(crate) const HOST: u32 = 1;
const MAP: u32 = 2;

/// Number of sets in the layout of a pass, including the sets that the pass does not use.
pub(crate) const SETS: u32 = MAP + 1;

/// Kinds of the descriptors of each set.
pub(crate) const KINDS: [&[vk::DescriptorType]; SETS as usize] =
    [&set_0::KINDS, &set_1::KINDS, &set_2::KINDS];

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
    /// Tiles, or stored maps.
    pub(crate) tiles: Option<&'a Buffer>,
    /// Blocks of lines, or distances of maps in shared memory.
    pub(crate) blocks: &'a Buffer,
    /// Buffer to which [`UNPACK`](super::passes::UNPACK) writes distances.
    pub(crate) distances: &'a Buffer,
    /// Name of the surface.
    pub(crate) owner: &'a str,
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
        let (pool, sets) = allocate(device, pipelines, &[SURFACE, SURFACE, MAP, MAP, HOST])?;
        let mut new = Self { pool, read_back: sets[4], ..Self::default() };
        let name = |name, set| pipelines.name(NameOf(name, contents.owner), set);
        for writes in 0..2 {
            let (surface, map) = (sets[writes], sets[2 + writes]);
            new.writing[writes] = Sets { surface, other: (MAP, map) };
            name(["reads fronts 1", "reads fronts 0"][writes], surface);
            name(["writes fronts 0", "writes fronts 1"][writes], map);
            fill(device, (surface, map), writes, contents);
        }
        name("distances", new.read_back);
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
    /// Name of the surface.
    pub(crate) owner: &'a str,
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
        let GridContents { sets: grid, edges, gaussian, fronts, progress, owner } = contents;
        let (pool, sets) = allocate(device, pipelines, &[SURFACE; 3])?;
        let mut new = Self { pool, ..Self::default() };
        let name = |name, set| pipelines.name(NameOf(name, owner), set);
        let fill = |surface, writes: usize| {
            write_image(device, surface, set_0::EDGES, edges);
            write_image(device, surface, set_0::GAUSSIANS, gaussian);
            write_image(device, surface, set_0::OLD_FRONTS, fronts[1 - writes]);
            write_buffer(device, surface, set_0::PROGRESS, progress);
        };
        for writes in 0..2 {
            let surface = sets[writes];
            name(["exchanges in fronts 0", "exchanges in fronts 1"][writes], surface);
            fill(surface, writes);
            write_buffer(device, surface, set_0::COPIES, copies);
            new.writing[writes] = Sets { surface, ..grid.writing[writes] };
        }
        if let Some(part) = by_rows {
            name("reads fronts 0 and copies", sets[2]);
            fill(sets[2], 1);
            let part = (copies.buffer, part.0, part.1);
            write_part(device, sets[2], set_0::COPIES_BY_ROW, part);
            new.by_rows = sets[2];
        }
        Ok(new)
    }

    /// Returns the sets of a pass over a finished map that finds copies of points in the list by rows, with a set of
    /// the host; `None` if there is no such list.
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

/// Allocates sets, given by the indices at which they are bound, from a new pool.
pub(crate) fn allocate(
    device: &ash::Device,
    pipelines: &Pipelines,
    wanted: &[u32],
) -> Result<(vk::DescriptorPool, Vec<vk::DescriptorSet>), VulkanError> {
    let kinds = [
        vk::DescriptorType::STORAGE_IMAGE,
        vk::DescriptorType::STORAGE_BUFFER,
        vk::DescriptorType::SAMPLED_IMAGE,
    ];
    let size = |kind| {
        let count = wanted.iter().map(|&set| count_of(kind, KINDS[set as usize])).sum();
        vk::DescriptorPoolSize::default().ty(kind).descriptor_count(count)
    };
    let sizes: Vec<_> =
        kinds.map(size).into_iter().filter(|size| size.descriptor_count > 0).collect();
    let info =
        vk::DescriptorPoolCreateInfo::default().max_sets(wanted.len() as u32).pool_sizes(&sizes);
    // SAFETY: nothing is borrowed beyond the call.
    let pool = unsafe { device.create_descriptor_pool(&info, None) }
        .map_err(VulkanError::from_call("vkCreateDescriptorPool"))?;
    let layouts: Vec<_> = wanted.iter().map(|&set| pipelines.set_layouts[set as usize]).collect();
    let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
    // SAFETY: the pool has room for these sets.
    let sets = unsafe { device.allocate_descriptor_sets(&info) };
    let sets = sets.map_err(VulkanError::from_call("vkAllocateDescriptorSets"));
    // SAFETY: nothing uses the pool.
    let sets = sets.inspect_err(|_| unsafe { device.destroy_descriptor_pool(pool, None) })?;
    Ok((pool, sets))
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
    let kind = vk::DescriptorType::STORAGE_IMAGE;
    write_view(device, (set, index, kind), image.view, vk::ImageLayout::GENERAL);
}

fn write_buffer(device: &ash::Device, set: vk::DescriptorSet, index: u32, buffer: &Buffer) {
    write_part(device, set, index, (buffer.buffer, 0, vk::WHOLE_SIZE));
}

/// Writes a view of an image, in this layout, to the descriptor of this index and kind.
pub(crate) fn write_view(
    device: &ash::Device,
    (set, index, kind): (vk::DescriptorSet, u32, vk::DescriptorType),
    view: vk::ImageView,
    layout: vk::ImageLayout,
) {
    let info = [vk::DescriptorImageInfo::default().image_view(view).image_layout(layout)];
    let write = vk::WriteDescriptorSet::default().dst_set(set).dst_binding(index);
    let write = write.descriptor_type(kind).image_info(&info);
    // SAFETY: set and view are alive, and no submitted work uses the set.
    unsafe { device.update_descriptor_sets(&[write], &[]) };
}

/// Writes the part of a buffer with this offset and size.
pub(crate) fn write_part(
    device: &ash::Device,
    set: vk::DescriptorSet,
    index: u32,
    (buffer, offset, range): (vk::Buffer, u64, u64),
) {
    let info = [vk::DescriptorBufferInfo { buffer, offset, range }];
    let write = vk::WriteDescriptorSet::default().dst_set(set).dst_binding(index);
    let write = write.descriptor_type(vk::DescriptorType::STORAGE_BUFFER).buffer_info(&info);
    // SAFETY: set and buffer are alive, and no submitted work uses the set.
    unsafe { device.update_descriptor_sets(&[write], &[]) };
}
