//! Stores the progress of a batch's maps. The twin of `glsl/passes/pairwise_progress.glsl`.

use std::mem::offset_of;

use bytemuck::{Zeroable, bytes_of};

use crate::surface::{Chart, relative_change};
use crate::vulkan::device::shaders::pairwise_count::{Map, Progress};
use crate::{Convergence, Stop};

/// Offsets of parts of the progress, in bytes.
pub(super) mod offset {
    use super::*;

    pub(crate) const ROW_GROUPS: u64 = offset_of!(Progress, row_groups) as u64;
    pub(crate) const COL_GROUPS: u64 = offset_of!(Progress, col_groups) as u64;
}

/// Returns the bytes of the progress of `maps` maps.
pub(super) const fn bytes(maps: u32) -> u64 {
    (size_of::<Progress>() + maps as usize * size_of::<Map>()) as u64
}

/// Writes the progress before the first iteration. `sources` are points of the chart. A row of texels takes
/// `row` workgroups, and a column `col`. A map without a source is done.
pub(super) fn start(
    chart: Chart,
    sources: &[Option<usize>],
    stop: Stop,
    [row, col]: [u32; 2],
    into: &mut [u8],
) {
    let maps = sources.len() as u32;
    let batch = Progress {
        pending: sources.iter().flatten().count() as u32,
        tolerance: (stop.tolerance / f64::from(f32::EPSILON)) as u32,
        most: stop.iterations,
        row_groups: [row, 1, maps],
        col_groups: [col, 1, maps],
    };
    let (first, rest) = into.split_at_mut(size_of::<Progress>());
    first.copy_from_slice(bytes_of(&batch));
    for (bytes, source) in rest.chunks_exact_mut(size_of::<Map>()).zip(sources) {
        let map = match source {
            Some(point) => {
                let (row, col) = chart.position(*point);
                let [source_col, source_row] = [col, row].map(|place| place as i32);
                Map { source_col, source_row, renews: 1, ..Map::zeroed() }
            }
            None => Map { done: 1, ..Map::zeroed() },
        };
        bytes.copy_from_slice(bytes_of(&map));
    }
}

/// Outcome of a batch, as the host reads it.
pub(super) struct BatchOutcome {
    /// Whether all maps are done.
    pub(super) is_done: bool,
    /// Largest number of iterations, and largest change.
    pub(super) convergence: Convergence,
}

impl BatchOutcome {
    pub(super) fn read(count: usize, from: &[u8]) -> Self {
        let batch: Progress = bytemuck::pod_read_unaligned(&from[..size_of::<Progress>()]);
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
    let maps = from[size_of::<Progress>()..].chunks_exact(size_of::<Map>()).take(count);
    maps.map(bytemuck::pod_read_unaligned)
}

/// Progress of one map of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct MapProgress {
    pub(super) iterations: u32,
    /// Whether the map is done. Maps without a source are done from the start.
    pub(super) is_done: bool,
}

impl MapProgress {
    pub(super) fn read(count: usize, from: &[u8]) -> Vec<Self> {
        let of = |map: Map| Self { iterations: map.iterations, is_done: map.done != 0 };
        maps(count, from).map(of).collect()
    }
}
