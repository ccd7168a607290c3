//! Orders in which a grid is updated, and the choice of the best one.

use super::patches::Plan;
use crate::lines::span::TILE;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Chart, EdgeLengths, Real};

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
    /// Points one after another, in the order in which fronts reach them: fast marching with a queue of buckets. It
    /// occupies one thread. It is best where a slowness changes much from point to point. For anchored fronts it stands
    /// for [`Self::Lines`].
    Times,
    /// Points in the order of [`Self::Times`], in patches of the grid with a queue each. All patches solve up to the same
    /// time in a round, and occupy all threads of the pool. On glued surfaces, and where updates read points that are
    /// farther away than an eighth of a side, it stands for [`Self::Times`].
    TimesInPatches {
        /// Number of points on a side of a patch.
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

/// Changes of the slowness along lines across the grid above which the order of time is best ([`changes_across`]): for
/// planar fronts, whose scans are faster, and for all others. From 300 x 300 to 1200 x 1200 points and on one or two
/// threads, both orders take the same time over blocks of classes at sums of about 14 and 9, and over noise at 14 and 4.
/// Over waves they do so at sums from 25 to 50 and from 7 to 15: small steps turn rays slowly. With these limits, the order
/// that is chosen takes at most 1.7 times as long as the other one.
const TURNING: [Changes; 2] =
    [Changes { sum: 14.0, squares: 2.0 }, Changes { sum: 9.0, squares: 0.0 }];

/// Number of grid points up to which the order of time is best over any uneven slowness: for planar fronts, and for all
/// others. At 32 x 32 points it takes 0.6 to 0.9 times as long as scans (planar) and 0.3 to 0.5 times (curved), at 64 x 64
/// points 0.7 to 1.3 and 0.3 to 0.6 times.
const SMALL: [usize; 2] = [1 << 10, 1 << 12];

/// Conditions under which the order of time is best in patches: the least number of grid points and of threads. With two
/// threads, patches take 0.65 to 0.85 of the time of one queue at 1200 x 1200 points, and the same time at 400 x 400; a
/// single thread takes 1.1 to 1.5 times as long. More threads have not been measured.
const TIMES_IN_PATCHES: [(usize, usize); 2] = [(600 * 600, 2), (192 * 192, 4)];

/// Number of points on a side of these patches. Smaller patches have longer borders, on which points are computed again.
/// At 1200 x 1200 points a round visits 23 patches (38 of 64 points a side, 17 of 128), and 1.03 to 1.15 points are computed
/// for each point of the surface (1.00 to 1.09 with a single queue).
const SIDE_IN_TIME: usize = 96;

/// Number of rows and of columns along which the change of the slowness is measured.
const SAMPLES: usize = 64;

impl Order {
    /// Returns the best order for maps of a surface with a wavefront, and a number of threads.
    pub fn best_on<R: Real>(edges: &EdgeLengths<R>, wavefront: Wavefront, threads: usize) -> Self {
        let kind = usize::from(wavefront != Wavefront::Planar);
        match edges.slowness() {
            Some(_) if edges.chart().points() <= SMALL[kind] => Self::Times,
            Some(slowness) if changes_across(edges, slowness).exceed(&TURNING[kind]) => {
                Self::of_time(edges.chart(), threads)
            }
            _ => Self::best_for(edges.chart(), threads),
        }
    }

    /// Returns the order of time for a grid and a number of threads.
    fn of_time(chart: Chart, threads: usize) -> Self {
        let applies =
            |&(points, least): &(usize, usize)| chart.points() >= points && threads >= least;
        if TIMES_IN_PATCHES.iter().any(applies) {
            Self::TimesInPatches { side: SIDE_IN_TIME }
        } else {
            Self::Times
        }
    }

    /// Returns the best order for a grid without an uneven slowness, and a number of threads.
    pub fn best_for(chart: Chart, threads: usize) -> Self {
        let applies = |&&(points, least, _): &&(usize, usize, usize)| {
            chart.points() >= points && threads >= least
        };
        PATCHES.iter().find(applies).map_or(Self::Lines, |&(.., side)| Self::Patches { side })
    }

    /// Returns the plan of patches, or `None` if whole lines are scanned.
    pub(crate) fn plan(self) -> Option<Plan> {
        match self {
            Self::Lines | Self::Times | Self::TimesInPatches { .. } => None,
            Self::Patches { side } => {
                Some(Plan::new(side.clamp(1, LARGEST_SIDE).next_multiple_of(TILE)))
            }
        }
    }

    /// Returns the side of the patches in the order of time, `Some(None)` for one queue, or `None` for scans.
    pub(crate) fn in_time(self) -> Option<Option<usize>> {
        match self {
            Self::Lines | Self::Patches { .. } => None,
            Self::Times => Some(None),
            Self::TimesInPatches { side } => Some(Some(side.clamp(1, LARGEST_SIDE))),
        }
    }
}

/// Relative changes of the slowness from point to point along a line: their sum, and that of their squares.
#[derive(Clone, Copy, Debug)]
struct Changes {
    sum: f64,
    squares: f64,
}

impl Changes {
    fn exceed(&self, limits: &Self) -> bool {
        self.sum > limits.sum && self.squares > limits.squares
    }
}

/// Returns the mean changes of the slowness along a row or column. Where their sum is large, rays turn many times on their
/// ways, and scans have to be repeated as often. `slowness` is a bordered array.
fn changes_across<R: Real>(edges: &EdgeLengths<R>, slowness: &[R]) -> Changes {
    let chart = edges.chart();
    let step = |points: usize| points.div_ceil(SAMPLES).max(1);
    let [east, north, ..] = edges.planes();
    let (mut sum, mut squares, mut pairs) = (0.0, 0.0, 0usize);
    let mut visit = |edge: R, [own, other]: [R; 2]| {
        // Pairs with a hole or the border have no edge.
        if edge < R::FAR {
            let (own, other) = (own.wide(), other.wide());
            let change = 2.0 * (own - other).abs() / (own + other);
            sum += change;
            squares += change * change;
            pairs += 1;
        }
    };
    // Lines are followed from end to end: every second pair could miss all borders of patches.
    for row in (0..chart.rows).step_by(step(chart.rows)) {
        let (east, slowness) = (chart.row_of(east, row), chart.row_of(slowness, row));
        east.iter()
            .zip(slowness.windows(2))
            .for_each(|(&edge, ends)| visit(edge, [ends[0], ends[1]]));
    }
    for col in (0..chart.cols).step_by(step(chart.cols)) {
        let points = (1..chart.rows).map(|row| chart.bordered(row, col));
        points.for_each(|at| visit(north[at], [slowness[at], slowness[at - chart.stride()]]));
    }
    let a_line = 0.5 * (chart.rows + chart.cols) as f64 / pairs.max(1) as f64;
    Changes { sum: sum * a_line, squares: squares * a_line }
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

    #[test]
    fn patches_in_the_order_of_time_need_threads() {
        let of = |points, threads| Order::of_time(Chart { rows: points, cols: points }, threads);
        assert_eq!([of(2000, 1), of(500, 2), of(150, 16)], [Order::Times; 3]);
        for order in [of(600, 2), of(200, 4)] {
            assert!(matches!(order.in_time(), Some(Some(1..))), "{order:?}");
        }
        assert_eq!((Order::Times.in_time(), Order::Lines.in_time()), (Some(None), None));
    }
}
