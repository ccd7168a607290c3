//! Lists the copies of points of a glued surface for shaders: the twin of the buffer of
//! `glsl/passes/exchange.comp`.

use std::collections::BTreeMap;

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::device::descriptors::{CopyContents, CopySets, GridSets, Sets};
use super::device::device_memory::DeviceMemory;
use super::device::memory::{Buffer, BufferInfo, Image};
use super::device::pipelines::Pipelines;
use super::device::shaders::exchange::Push;
use super::{TexelChart, VulkanError};
use crate::constants::{COPIES_TOGETHER, COPY_TEXEL_WORDS, LAYERS};
use crate::surface::{Chart, Groups};

/// In place of the number of the round of tiles that follows: none does.
pub(crate) const NO_ROUND: i32 = -1;

/// Copies of points in the order and the places in which shaders read them.
#[derive(Clone, Debug, PartialEq)]
struct CopyList {
    words: Vec<u32>,
    /// Numbers of parts, members, groups and texels.
    parts: usize,
    members: usize,
    groups: usize,
    texels: usize,
}

impl CopyList {
    /// Lists groups of copies, given by their row-major indices.
    fn new<'g>(chart: Chart, groups: impl Iterator<Item = &'g [u32]>) -> Self {
        let (mut parts, mut members, mut of_groups) = (vec![0], Vec::new(), vec![0]);
        let mut texels = BTreeMap::<(u32, u32), [u32; 4]>::new();
        for (group, number) in groups.zip(1..) {
            for part in group.chunks(COPIES_TOGETHER as usize) {
                for &index in part {
                    let (row, col) = chart.position(index as usize);
                    let before = TexelChart::POINTS_BEFORE;
                    members.push(word(row as u32 + before, col as u32 + before));
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
        words.resize(words.len() + 2 * counts[0], 0);
        let [parts, members, groups, texels] = counts;
        Self { words, parts, members, groups, texels }
    }
}

const _: () = assert!(COPY_TEXEL_WORDS == 5);

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
    /// Allocates the list of a surface's copies and the sets of the pass that exchanges fronts between them.
    /// [`Copies::destroy`] must be called before the device or the allocator is destroyed.
    pub(crate) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        pipelines: &Pipelines,
        (chart, groups): (Chart, &Groups),
        (grid, fronts, progress): (&GridSets, [&Image; 2], &Buffer),
    ) -> Result<Self, VulkanError> {
        let list = CopyList::new(chart, in_order(groups).into_iter());
        let size = size_of_val(list.words.as_slice()) as u64;
        let info = BufferInfo { name: "copies", size, location: MemoryLocation::GpuOnly };
        let mut buffer = Buffer::new(device, allocator, info)?;
        pipelines.name("copies", buffer.buffer);
        let contents = CopyContents { grid, fronts, progress, copies: &buffer };
        match CopySets::new(device, pipelines, contents) {
            Ok(sets) => Ok(Self { list, buffer, sets }),
            Err(error) => {
                buffer.destroy(device, allocator);
                Err(error)
            }
        }
    }

    /// Returns the buffer and what it has to hold before the first exchange.
    pub(crate) fn contents(&self) -> (vk::Buffer, &[u8]) {
        (self.buffer.buffer, bytemuck::cast_slice(&self.list.words))
    }

    /// Returns the sets of an exchange in one of the two images of fronts.
    pub(crate) fn sets(&self, image: usize) -> Sets {
        self.sets.writing[image]
    }

    /// Returns the push constants of an exchange.
    pub(crate) fn push(&self, texels: TexelChart, tile_texels: i32, next_round: i32) -> Push {
        let CopyList { parts, members, groups, texels: copy_texels, .. } = self.list;
        let [parts, members, groups, copy_texels] =
            [parts, members, groups, copy_texels].map(|count| count as i32);
        let texels = texels.inner().map(|texels| texels as i32);
        Push { texels, parts, members, groups, copy_texels, tile_texels, next_round }
    }

    /// Returns the bytes that an exchange reads and writes, without those of earliest fronts: each copy is read
    /// once by itself and once with its texel.
    pub(crate) fn bytes_moved(&self) -> [u64; 2] {
        let texel = 16 * u64::from(LAYERS);
        let [members, texels] = [self.list.members, self.list.texels].map(|count| count as u64);
        [(members + texels) * texel, texels * texel]
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

/// Returns the groups in the order in which they are listed. Tests change it.
fn in_order(groups: &Groups) -> Vec<&[u32]> {
    #[cfg(not(test))]
    let groups = groups.iter().collect();
    #[cfg(test)]
    let groups = tests::reordered(groups.iter().collect());
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
