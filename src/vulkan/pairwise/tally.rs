//! Counts the work of the passes over a batch, once the progress of its maps is known.

use super::layout::{self, BatchLayout};
use super::progress::MapProgress;
use crate::surface::Chart;
use crate::vulkan::profile::{PassKind, PassRecord, Work};

/// Triangles of a point that a scan uses.
const TRIANGLES: u64 = 2;

/// Batch whose work is counted.
#[derive(Clone, Copy)]
pub(super) struct Tally<'a> {
    pub(super) layout: &'a BatchLayout,
    pub(super) sources: &'a [Option<usize>],
}

impl Tally<'_> {
    /// Completes the records of a recording. Records of maps in images are given for one map each. `before`
    /// and `after` are the progress of each map before and after the recording.
    pub(super) fn settle(
        self,
        passes: &mut [PassRecord],
        before: &[MapProgress],
        after: &[MapProgress],
    ) {
        // All maps that are not done have taken the same number of iterations.
        let iterations = before.iter().map(|map| map.iterations).max().unwrap_or(0);
        let maps = self.sources.len() as u64;
        for pass in passes {
            pass.iteration = pass.iteration.map(|number| iterations + number);
            match (pass.kind, pass.iteration) {
                (PassKind::Seed, _) => {
                    let present = self.sources.iter().flatten().count();
                    pass.work = pass.work.of_maps(present as u64, maps);
                }
                (PassKind::Workgroups, _) => {
                    pass.iteration = Some(iterations);
                    pass.work = self.in_shared_memory(before, after);
                }
                (
                    PassKind::Scan(_) | PassKind::Exchange | PassKind::Count | PassKind::Iteration,
                    Some(number),
                ) => {
                    let goes_on = |map: &&MapProgress| map.iterations > number;
                    let count = after.iter().filter(goes_on).count() as u64;
                    pass.work = pass.work.of_maps(count, maps);
                    let is_indirect = matches!(pass.kind, PassKind::Scan(_) | PassKind::Iteration);
                    if count == 0 && is_indirect {
                        pass.groups = Some([0, 1, 1]);
                    }
                    if matches!(pass.kind, PassKind::Count | PassKind::Iteration) {
                        pass.work = pass.work.and_bytes(of_ends(number, after));
                    }
                }
                _ => {}
            }
        }
    }

    /// Returns the work of iterations in shared memory. They process lines of points pair by pair, and read
    /// the fan of each pair.
    fn in_shared_memory(self, before: &[MapProgress], after: &[MapProgress]) -> Work {
        let BatchLayout { chart, wavefront, .. } = *self.layout;
        let Chart { rows, cols } = chart;
        // The first line has no line behind it. Two scans process rows, and two columns.
        let [of_rows, of_cols] = [(rows, cols), (cols, rows)].map(|(lines, points)| {
            let (lines, points) = (lines as u64 - 1, points as u64);
            [lines * points, lines * points.div_ceil(2)]
        });
        let [points_once, pairs_once] = [0, 1].map(|k| of_rows[k] + of_cols[k]);
        let kept = self.layout.kept() / u64::from(self.layout.maps);
        let fan = 4 * layout::fan_numbers(wavefront);
        let (mut points, mut read, mut written) = (0, 0, 0);
        // Maps without a source are done from the start.
        for (before, after) in before.iter().zip(after).filter(|(before, _)| !before.is_done) {
            let iterations = u64::from(after.iterations - before.iterations);
            let mut passed = 2 * iterations;
            if before.iterations == 0 {
                // In the first iteration opposite scans lead away from the source. Together they pass each
                // line but the source's own once.
                passed -= 1;
            } else {
                read += kept;
            }
            points += passed * points_once;
            read += passed * pairs_once * fan;
            written += if after.is_done { 4 * chart.points() as u64 } else { kept };
        }
        Work { triangles: Some(TRIANGLES * points), ..Work::of_bytes(read, written) }
    }
}

/// Returns the data that the count of an iteration (`glsl/passes/pairwise_count.comp`) moves in addition to
/// the data of each map that was not done before. For a map that was done before, the count reads `done`. For
/// a map that is done now, it writes `done`, and reads and writes the number of pending maps. If no map is
/// pending any more, it also writes that rows and columns have no workgroups.
fn of_ends(number: u32, after: &[MapProgress]) -> Work {
    let count = |is: fn(u32, u32) -> bool| {
        let maps = after.iter().filter(|map| map.is_done && is(map.iterations, number + 1));
        maps.count() as u64
    };
    let (before, now) = (count(|last, this| last < this), count(|last, this| last == this));
    let groups = if now > 0 && before + now == after.len() as u64 { 2 } else { 0 };
    Work::of_bytes(4 * (before + now), 4 * (2 * now + groups))
}
