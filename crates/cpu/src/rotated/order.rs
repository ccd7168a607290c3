//! Orders in which a grid is updated, and the choice of the best one.

use super::patches::Plan;
use crate::lines::span::TILE;
use geosweep_surface::Chart;

/// The order in which [`crate::RotatedScan`] updates a grid. All orders converge to the same map, within the
/// tolerance and rounding. For each of them the map is bit-identical for any number of threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Scans of the whole grid, two opposite ones in parallel. They occupy two threads.
    Lines,
    /// Patches of the grid, in the order in which fronts reach them. They occupy all threads of the pool.
    Patches {
        /// Number of points on a side of a patch. It is rounded up to a multiple of 16.
        side: usize,
    },
}

/// Conditions under which patches are best: the least number of grid points, the least number of threads, and the
/// side of the patches. The first entry that applies is used. If none applies, scans of the whole grid are best. With
/// patches a single thread takes up to twice as long, but about ten visits of a round can run in parallel
/// (`docs/speed.md`).
const PATCHES: [(usize, usize, usize); 1] = [(1 << 22, 8, 128)];

/// Largest side of a patch, larger than any grid.
const LARGEST_SIDE: usize = 1 << 30;

impl Order {
    /// Returns the best order for a grid and a number of threads.
    pub fn best_for(chart: Chart, threads: usize) -> Self {
        let applies = |&&(points, least, _): &&(usize, usize, usize)| {
            chart.points() >= points && threads >= least
        };
        PATCHES.iter().find(applies).map_or(Self::Lines, |&(.., side)| Self::Patches { side })
    }

    /// Returns the plan of patches, or `None` if whole lines are scanned.
    pub(crate) fn plan(self) -> Option<Plan> {
        match self {
            Self::Lines => None,
            Self::Patches { side } => {
                Some(Plan::new(side.clamp(1, LARGEST_SIDE).next_multiple_of(TILE)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_grids_have_patches_of_whole_tiles() {
        let side = |points| Chart { rows: points, cols: points };
        assert_eq!(Order::best_for(side(100), 16), Order::Lines);
        assert_eq!(Order::best_for(side(2048), 2), Order::Lines);
        let large = Order::best_for(side(2048), 16);
        assert!(large.plan().is_some_and(|plan| plan.side.is_multiple_of(TILE)), "{large:?}");
        assert_eq!(Order::Lines.plan(), None);
        assert_eq!(Order::Patches { side: 17 }.plan().map(|plan| plan.side), Some(32));
        assert_eq!(Order::Patches { side: 0 }.plan().map(|plan| plan.side), Some(16));
        assert!(Order::Patches { side: usize::MAX }.plan().is_some());
    }
}
