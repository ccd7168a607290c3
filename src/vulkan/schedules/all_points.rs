//! Plans and records the schedule that updates all points at once, repeatedly.

use super::order::{Order, Steps};
use super::plan::{Portions, Reached, Step};
use super::progress::offset;
use crate::constants::{ALL_POINTS_FOLLOW, WORKGROUP};
use crate::vulkan::TexelChart;
use crate::vulkan::device::passes::ALL_POINTS;
use crate::vulkan::device::shaders::all_points::Push;
use crate::vulkan::profile::{PassKind, PassRecord, Presence, StepCounter, Work};
use crate::vulkan::record::Groups;

pub(super) struct AllPoints;

/// Largest number of iterations in a recording. An iteration is two updates of all points. Recordings on
/// large grids have fewer iterations.
const ITERATIONS: u32 = 32;

/// Points of a texel times the triangles of a point.
const TRIANGLES: u64 = 4 * 8;

impl Order for AllPoints {
    fn passes(&self) -> &'static [usize] {
        const PASSES: [usize; 1] = [ALL_POINTS.number()];
        &PASSES
    }

    fn follows(&self) -> u32 {
        ALL_POINTS_FOLLOW
    }

    fn has_rounds(&self) -> bool {
        false
    }

    fn plan(
        &self,
        texels: TexelChart,
        portions: Portions,
        _: Option<Reached>,
        most: u32,
    ) -> Vec<Step> {
        let iteration = [Step::AllPoints { writes: 1 }, Step::AllPoints { writes: 0 }, Step::Count];
        (0..most.min(portions.iterations_of(2, texels, ITERATIONS)))
            .flat_map(|_| iteration.clone())
            .collect()
    }

    fn record(&self, recording: &mut Steps, step: &Step) {
        let &Step::AllPoints { writes } = step else { return };
        let grid = recording.recorder.grid;
        let texels = grid.texels.inner().map(|texels| texels as i32);
        let groups = Groups::From(grid.progress.buffer, offset::GRID_GROUPS);
        recording.dispatch(ALL_POINTS, writes, &Push { texels }, groups);
    }

    fn account(&self, counter: &mut StepCounter, _: &Step) -> (PassRecord, Presence) {
        let [cols, rows] = counter.texels.inner();
        let all = u64::from(cols) * u64::from(rows);
        let record = PassRecord {
            area: Some(counter.everywhere()),
            groups: Some([cols.div_ceil(WORKGROUP), rows, 1]),
            work: Work::of_updates(all, 0, counter.curved, Some(TRIANGLES)),
            ..counter.inside(PassKind::AllPoints)
        };
        (record, Presence::Iteration)
    }
}
