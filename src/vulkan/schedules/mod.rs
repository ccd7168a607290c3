//! Plans and records the schedules. Each schedule has a file, which states its passes, plans its steps,
//! starts a map and records the steps. This file contains everything that depends on the
//! choice of the schedule.

pub(in crate::vulkan) mod iteration;
pub(in crate::vulkan) mod method;
mod order;
pub mod plan;
pub(in crate::vulkan) mod progress;
pub(in crate::vulkan) mod raster;
mod recording;
pub(in crate::vulkan) mod schedule;
mod targets;
mod tiles;
pub(in crate::vulkan) mod tuning;

use super::{Schedule, TexelChart};
use crate::constants::{SCANS_FOLLOW, TILES_FOLLOW};
use order::ScheduleKind;
use plan::{Portions, Reached, Step};
pub(super) use raster::block_of;

impl Schedule {
    fn order(self) -> &'static dyn ScheduleKind {
        match self {
            Self::Raster => &raster::Raster,
            Self::Tiles => &tiles::Tiles,
        }
    }

    /// Returns the steps of a recording: `portions` decides the number of iterations (or rounds of tiles), which is at
    /// most `most`. Before and after these steps all fronts are in image 0.
    ///
    /// If the map has just been started, `reached` is the box around its sources. `portions` are
    /// [`crate::vulkan::Tuning::portions`].
    ///
    /// ```
    /// use geosweep::surface::Chart;
    /// use geosweep::vulkan::{Schedule, TexelChart, plan};
    /// let texels = TexelChart::new(Chart { rows: 64, cols: 64 }).unwrap();
    /// let source = plan::Reached { rows: 1..2, cols: 1..2 };
    /// let (lines, across, pairs, iterations) = (1, 0, false, 4);
    /// let (tile, rounds, visits) = (16, None, 1 << 22);
    /// let portions = plan::Portions { lines, across, pairs, iterations, tile, rounds, visits };
    /// let steps = Schedule::Raster.plan(texels, portions, Some(source), 100);
    /// // From a corner, the first scan visits about half of the texels.
    /// assert!(plan::texels_scanned(&steps[..32]) < 32 * 32 * 6 / 10);
    /// ```
    pub fn plan(
        self,
        texels: TexelChart,
        portions: Portions,
        reached: Option<Reached>,
        most: u32,
    ) -> Vec<Step> {
        self.order().plan(texels, portions, reached, most)
    }

    /// Returns the numbers of the schedule's passes in the table.
    pub(crate) fn passes(self) -> &'static [usize] {
        self.order().passes()
    }

    /// Returns which passes follow the seeds of a map. `glsl/passes/seed.comp` prepares for them.
    pub(crate) fn follows(self) -> u32 {
        if self.has_rounds() { TILES_FOLLOW } else { SCANS_FOLLOW }
    }

    /// Returns whether the schedule runs rounds over lists of tiles that the device makes. Otherwise it runs
    /// iterations over the whole grid.
    pub fn has_rounds(self) -> bool {
        self.order().has_rounds()
    }

    /// Returns [`ScheduleKind::together`].
    pub(crate) fn together(self, texels: TexelChart, portions: Portions) -> u32 {
        self.order().together(texels, portions)
    }

    /// Returns [`ScheduleKind::gains_by_surroundings`].
    pub(crate) fn gains_by_surroundings(self) -> bool {
        self.order().gains_by_surroundings()
    }
}

/// Returns the schedule to which a step belongs; `None` for a step that several schedules use.
fn order_of(step: &Step) -> Option<&'static dyn ScheduleKind> {
    match step {
        Step::Scan(_) => Some(&raster::Raster),
        Step::Tiles { .. } | Step::Settle { .. } => Some(&tiles::Tiles),
        Step::Exchange { .. } | Step::Count => None,
    }
}
