//! Lists the copies of points of a glued surface for shaders: the twin of the buffers of
//! `glsl/passes/copies.glsl` and `glsl/shared/copies_by_row.glsl`.

use std::collections::BTreeMap;
use std::ops::Range;

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::device::descriptors::{CopySets, GridContents, Sets};
use super::device::device_memory::DeviceMemory;
use super::device::labels::NameOf;
use super::device::memory::{Buffer, BufferInfo};
use super::device::pipelines::Pipelines;
use super::device::shaders::exchange::Push;
use super::device::shaders::{pairwise_exchange, share_curvature};
use super::{TexelChart, VulkanError};
use crate::constants::{COPIES_TOGETHER, COPY_TEXEL_WORDS, LAYERS};
use crate::surface::{Chart, Glued, Groups, Ring};

/// Value of `next_round` if no round of tiles follows an exchange.
pub(crate) const NO_ROUND: i32 = -1;

/// Alignment of a list by rows, in words. It suits the offsets of storage buffers on every device.
const ALIGNMENT: usize = 64;

/// Number of words of the earliest front of a part: its time and the value that it carries.
const EARLIEST_WORDS: usize = 2;

/// List of the copies of points, in the layout in which shaders read it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CopyList {
    words: Vec<u32>,
    /// Number of further words after `words`. Shaders write them before they read them.
    room: usize,
    /// Numbers of parts, members, groups and texels.
    parts: usize,
    members: usize,
    groups: usize,
    texels: usize,
    /// Words of a list by rows, if there is one.
    by_rows: Option<Range<usize>>,
}

impl CopyList {
    /// Lists the groups of a surface that is measured on the host.
    pub(crate) fn of_groups(chart: Chart, groups: &Groups) -> Self {
        Self::new(chart, in_order(groups.iter().collect()).into_iter())
    }

    /// Lists the copies of a grid that is measured on a device, with the rings around them and a list by rows.
    pub(crate) fn with_rings(chart: Chart, glued: &Glued) -> Self {
        let rings = glued.rings(chart);
        let ring_of: BTreeMap<_, _> = rings.iter().map(|ring| (ring.members[0], ring)).collect();
        let groups = in_order(rings.iter().map(|ring| ring.members.as_slice()).collect());
        let mut list = Self::new(chart, groups.iter().copied());
        list.add_rings(groups.iter().map(|group| ring_of[&group[0]]));
        list.words.resize(list.words.len().next_multiple_of(ALIGNMENT), 0);
        let start = list.words.len();
        list.words.extend(words_by_rows(chart, glued.groups()));
        list.by_rows = Some(start..list.words.len());
        list
    }

    /// Lists groups of copies, given by their row-major indices.
    fn new<'g>(chart: Chart, groups: impl Iterator<Item = &'g [u32]>) -> Self {
        let (mut parts, mut members, mut of_groups) = (vec![0], Vec::new(), vec![0]);
        let mut texels = BTreeMap::<(u32, u32), [u32; 4]>::new();
        for (group, number) in groups.zip(1..) {
            for part in group.chunks(COPIES_TOGETHER as usize) {
                for &index in part {
                    let (row, col) = chart.position(index as usize);
                    members.push(word_of_point(row, col));
                    let (texel_row, texel_col, component) = TexelChart::texel_of(row, col);
                    texels.entry((texel_row, texel_col)).or_default()[component] = number;
                }
                parts.push(members.len() as u32);
            }
            of_groups.push(parts.len() as u32 - 1);
        }
        let counts = [parts.len() - 1, members.len(), of_groups.len() - 1, texels.len()];
        let mut words = [parts, members, of_groups].concat();
        for ((row, col), numbers) in texels {
            words.push(word(row, col));
            words.extend(numbers);
        }
        debug_assert_eq!(words.len(), counts[0] + counts[1] + counts[2] + 2 + 5 * counts[3]);
        words.resize(words.len() + EARLIEST_WORDS * counts[0], 0);
        let [parts, members, groups, texels] = counts;
        Self { words, room: 0, parts, members, groups, texels, by_rows: None }
    }

    /// Adds the cells around the members of each part, in the order of the groups, as
    /// `glsl/passes/share_curvature.comp` reads them, and room for the results of that pass.
    fn add_rings<'r>(&mut self, rings: impl Iterator<Item = &'r Ring>) {
        let (mut starts, mut cells) = (vec![0], Vec::new());
        for of_part in rings.flat_map(|ring| ring.cells.chunks(COPIES_TOGETHER as usize)) {
            for cell in of_part.iter().flatten() {
                let (row, col) = cell.first;
                cells.extend([word_of_point(row, col), cell.ends]);
            }
            starts.push(cells.len() as u32 / 2);
        }
        debug_assert_eq!(starts.len(), self.parts + 1);
        self.words.extend(starts);
        self.words.extend(cells);
        self.words.resize(self.words.len() + 4 * self.parts, 0);
    }

    /// Returns the list for a batch of maps. It has room for the earliest fronts of each map.
    pub(crate) fn of_batch(&self, maps: u32) -> Self {
        let Self { parts, members, groups, texels, .. } = *self;
        let before = parts + 1 + members + groups + 1 + COPY_TEXEL_WORDS as usize * texels;
        let room = EARLIEST_WORDS * parts * maps as usize;
        Self { words: self.words[..before].to_vec(), room, by_rows: None, ..*self }
    }

    /// Returns the number of bytes of the list and its room.
    pub(crate) fn bytes(&self) -> u64 {
        ((self.words.len() + self.room) * size_of::<u32>()) as u64
    }

    /// Returns the buffer that holds the list.
    pub(crate) fn buffer_info(&self) -> BufferInfo {
        BufferInfo { name: "copies", size: self.bytes(), location: MemoryLocation::GpuOnly }
    }
}

/// Returns the words of `glsl/shared/copies_by_row.glsl`.
fn words_by_rows(chart: Chart, groups: &Groups) -> Vec<u32> {
    let mut copies: Vec<_> = (groups.iter().zip(0u32..))
        .flat_map(|(group, number)| group.iter().map(move |&index| (index, number)))
        .collect();
    copies.sort_unstable();
    let before = |row: usize| {
        copies.partition_point(|&(index, _)| (index as usize) < chart.index(row, 0)) as u32
    };
    let mut words = vec![groups.starts().len() as u32 - 1];
    words.extend((0..=chart.rows).map(before));
    words.extend(copies.iter().map(|&(index, _)| chart.position(index as usize).1 as u32));
    words.extend(copies.iter().map(|&(_, number)| number));
    words.extend_from_slice(groups.starts());
    words.extend_from_slice(groups.members());
    words
}

/// Returns the offset and size of a list in bytes.
fn bytes_of(words: &Range<usize>) -> (u64, u64) {
    let [at, bytes] = [words.start, words.len()].map(|words| (words * size_of::<u32>()) as u64);
    (at, bytes)
}

const _: () = assert!(COPY_TEXEL_WORDS == 5);

/// Returns the position of a grid point in the images as one word.
fn word_of_point(row: usize, col: usize) -> u32 {
    let before = TexelChart::POINTS_BEFORE;
    word(row as u32 + before, col as u32 + before)
}

/// Returns a row and a column of an image, which have at most 16 bits, as one word.
fn word(row: u32, col: u32) -> u32 {
    col | row << 16
}

/// Copies of points of a glued surface on a device.
#[derive(Debug)]
pub(crate) struct Copies {
    list: CopyList,
    buffer: Buffer,
    sets: CopySets,
}

impl Copies {
    /// Allocates the list of a surface's copies and the sets of the passes over them.
    /// [`Copies::destroy`] must be called before the device or the allocator is destroyed.
    pub(crate) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        pipelines: &Pipelines,
        list: CopyList,
        grid: GridContents,
    ) -> Result<Self, VulkanError> {
        let mut buffer = Buffer::new(device, allocator, list.buffer_info())?;
        pipelines.name(NameOf("copies", grid.owner), buffer.buffer);
        let by_rows = list.by_rows.as_ref().map(bytes_of);
        match CopySets::new(device, pipelines, grid, &buffer, by_rows) {
            Ok(sets) => Ok(Self { list, buffer, sets }),
            Err(error) => {
                buffer.destroy(device, allocator);
                Err(error)
            }
        }
    }

    /// Returns the list.
    pub(crate) fn list(&self) -> &CopyList {
        &self.list
    }

    /// Returns the buffer and the bytes that it has to hold before the first exchange.
    pub(crate) fn contents(&self) -> (vk::Buffer, &[u8]) {
        (self.buffer.buffer, bytemuck::cast_slice(&self.list.words))
    }

    /// Returns the buffer, and the offset and size of the list by rows in bytes, if there is one.
    pub(crate) fn by_rows(&self) -> Option<(vk::Buffer, u64, u64)> {
        let (at, bytes) = bytes_of(self.list.by_rows.as_ref()?);
        Some((self.buffer.buffer, at, bytes))
    }

    /// Returns the number of groups in the list by rows.
    pub(crate) fn groups_by_rows(&self) -> u32 {
        self.list.by_rows.as_ref().map_or(0, |of| self.list.words[of.start])
    }

    /// Returns the sets of a pass that finds copies of points in the list by rows, with a set of the host; `None` if
    /// there is no such list.
    pub(crate) fn with_host(&self, set: vk::DescriptorSet) -> Option<Sets> {
        self.sets.with_host(set)
    }

    /// Returns the push constants of the pass that shares the curvature of copies. The list must have rings.
    pub(crate) fn push_to_share(&self) -> share_curvature::Push {
        let [parts, members, groups, copy_texels] = self.counts();
        share_curvature::Push { parts, members, groups, copy_texels }
    }

    /// Returns the push constants of an exchange on all maps of a batch.
    pub(crate) fn push_of_batch(&self) -> pairwise_exchange::Push {
        let [parts, members, groups, copy_texels] = self.counts();
        pairwise_exchange::Push { parts, members, groups, copy_texels }
    }

    fn counts(&self) -> [i32; 4] {
        let CopyList { parts, members, groups, texels, .. } = self.list;
        [parts, members, groups, texels].map(|count| count as i32)
    }

    /// Returns the sets of an exchange in one of the two images of fronts.
    pub(crate) fn sets(&self, image: usize) -> Sets {
        self.sets.writing[image]
    }

    /// Returns the push constants of an exchange.
    pub(crate) fn push(&self, texels: TexelChart, tile_texels: i32, next_round: i32) -> Push {
        let [parts, members, groups, copy_texels] = self.counts();
        let texels = texels.inner().map(|texels| texels as i32);
        Push { texels, parts, members, groups, copy_texels, tile_texels, next_round }
    }

    /// Returns the bytes that an exchange reads and writes, without the bytes of earliest fronts. The exchange reads
    /// the texel of each copy, and each texel with copies once more.
    pub(crate) fn bytes_moved(&self) -> [u64; 2] {
        let texel = 16 * u64::from(LAYERS);
        let [members, texels] = [self.list.members, self.list.texels].map(|count| count as u64);
        [(members + texels) * texel, texels * texel]
    }

    /// Returns the bytes that are read and written if copies share their curvature: the bytes of each copy, of the
    /// edges of its cells, and of each texel with copies.
    pub(crate) fn bytes_of_curvature(&self) -> [u64; 2] {
        let [members, texels] = [self.list.members, self.list.texels].map(|count| count as u64);
        [16 * (members * 13 + texels), 16 * texels]
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.buffer.bytes()
    }

    /// Frees everything. No submitted work may still use it.
    pub(crate) fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        self.sets.destroy(device);
        self.buffer.destroy(device, allocator);
    }
}

/// Returns the groups in the order in which they are listed. Tests change the order.
fn in_order(groups: Vec<&[u32]>) -> Vec<&[u32]> {
    #[cfg(test)]
    let groups = tests::reordered(groups);
    groups
}

#[cfg(test)]
pub(in crate::vulkan) mod tests {
    use super::*;
    use std::cell::Cell;

    /// Order in which groups of copies are listed.
    #[derive(Clone, Copy, PartialEq)]
    pub(in crate::vulkan) enum GroupOrder {
        AsFound,
        Reversed,
        /// Neighbours in the list are far apart on the surface.
        Scattered,
    }

    thread_local! {
        pub(in crate::vulkan) static ORDER: Cell<GroupOrder> = const { Cell::new(GroupOrder::AsFound) };
    }

    pub(super) fn reordered(mut groups: Vec<&[u32]>) -> Vec<&[u32]> {
        match ORDER.get() {
            GroupOrder::AsFound => {}
            GroupOrder::Reversed => groups.reverse(),
            GroupOrder::Scattered => {
                groups.sort_by_key(|group| group[0].wrapping_mul(2_654_435_761));
            }
        }
        groups
    }

    #[test]
    fn long_groups_have_parts_and_texels_have_all_their_groups() {
        let chart = Chart { rows: 3, cols: 40 };
        // The first row is one point. In the last row, the first two points are those of the row above.
        let pole: Vec<u32> = (0..40).collect();
        let groups: [&[u32]; 3] = [&pole, &[40, 80], &[41, 81]];
        let list = CopyList::new(chart, groups.into_iter());
        assert_eq!((list.parts, list.members, list.groups, list.texels), (4, 44, 3, 21));
        assert_eq!(list.words[..5], [0, 32, 40, 42, 44]);
        assert_eq!(list.words[5..][..2], [2 << 16 | 2, 2 << 16 | 3]);
        assert_eq!(list.words[5 + 44..][..4], [0, 2, 3, 4]);
        let texels = &list.words[5 + 44 + 4..];
        assert_eq!(texels[..5], [1 << 16 | 1, 1, 1, 2, 3]);
        assert_eq!(texels[5..10], [1 << 16 | 2, 1, 1, 0, 0]);
        assert_eq!(texels[20 * 5..][..5], [2 << 16 | 1, 2, 3, 0, 0]);
        assert_eq!(texels.len(), 21 * 5 + 2 * 4);
    }
}
