//! How the maps of a batch go. The twin of `glsl/pairwise_progress.glsl`.

use bytemuck::{AnyBitPattern, NoUninit, bytes_of};

use crate::surface::relative_change;
use crate::{Convergence, Stop};

/// Of a whole batch.
#[derive(Clone, Copy, Debug, AnyBitPattern, NoUninit)]
#[repr(C)]
struct Batch {
    pending: u32,
    tolerance: u32,
    most: u32,
    row_groups: [u32; 3],
    col_groups: [u32; 3],
}

/// Of one map.
#[derive(Clone, Copy, Debug, Default, AnyBitPattern, NoUninit)]
#[repr(C)]
struct Map {
    source: u32,
    residual: u32,
    next_residual: u32,
    renews: u32,
    iterations: u32,
    last_residual: u32,
    since_reached: u32,
    done: u32,
}

/// Where the parts lie, in bytes.
pub(super) mod offset {
    pub(crate) const ROW_GROUPS: u64 = 3 * size_of::<u32>() as u64;
    pub(crate) const COL_GROUPS: u64 = ROW_GROUPS + 3 * size_of::<u32>() as u64;
}

/// Bytes of the progress of so many maps.
pub(super) const fn bytes(maps: u32) -> u64 {
    (size_of::<Batch>() + maps as usize * size_of::<Map>()) as u64
}

/// Writes the progress before the first iteration; a row and a column of texels take so many groups.
/// A map without source is done.
pub(super) fn start(sources: &[Option<usize>], stop: Stop, [row, col]: [u32; 2], into: &mut [u8]) {
    let maps = sources.len() as u32;
    let batch = Batch {
        pending: sources.iter().flatten().count() as u32,
        tolerance: (stop.tolerance / f64::from(f32::EPSILON)) as u32,
        most: stop.iterations,
        row_groups: [row, 1, maps],
        col_groups: [col, 1, maps],
    };
    let (first, rest) = into.split_at_mut(size_of::<Batch>());
    first.copy_from_slice(bytes_of(&batch));
    for (bytes, source) in rest.chunks_exact_mut(size_of::<Map>()).zip(sources) {
        let map = match source {
            Some(point) => Map { source: *point as u32, renews: 1, ..Map::default() },
            None => Map { done: 1, ..Map::default() },
        };
        bytes.copy_from_slice(bytes_of(&map));
    }
}

/// What the host reads of a batch.
pub(super) struct BatchOutcome {
    /// Whether all maps are.
    pub(super) is_done: bool,
    /// Most iterations and largest change.
    pub(super) convergence: Convergence,
}

impl BatchOutcome {
    pub(super) fn read(count: usize, from: &[u8]) -> Self {
        let batch: Batch = bytemuck::pod_read_unaligned(&from[..size_of::<Batch>()]);
        let mut outcome = Self { is_done: batch.pending == 0, convergence: Convergence::NONE };
        for map in maps(count, from) {
            let residual = relative_change::<f32>(map.last_residual);
            let of_map = Convergence { iterations: map.iterations, residual };
            outcome.convergence = outcome.convergence.worse(of_map);
        }
        outcome
    }
}

fn maps(count: usize, from: &[u8]) -> impl Iterator<Item = Map> {
    let maps = from[size_of::<Batch>()..].chunks_exact(size_of::<Map>()).take(count);
    maps.map(bytemuck::pod_read_unaligned)
}

/// How one map of a batch has gone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct MapProgress {
    pub(super) iterations: u32,
    /// Maps without source are from the start.
    pub(super) is_done: bool,
}

impl MapProgress {
    pub(super) fn read(count: usize, from: &[u8]) -> Vec<Self> {
        let of = |map: Map| Self { iterations: map.iterations, is_done: map.done != 0 };
        maps(count, from).map(of).collect()
    }
}
