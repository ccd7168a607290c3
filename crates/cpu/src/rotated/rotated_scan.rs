//! Solves by rotated raster scans in SIMD lanes, in the order that suits the grid.

use std::any::Any;

use super::buckets::in_order_of_time;
use super::order::Order;
use super::patches::PatchScanner;
use super::scanner::Scanner;
use super::scans::{PatchCounts, Scans};
use crate::Instructions;
use crate::fronts::{FrontOver, for_kind};
use crate::limit::Limit;
use crate::solution::{Solution, distances};
use crate::target_estimate::estimate_targets;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Chart, EdgeLengths, FAR, Real, Seed};
use geosweep_surface::{Convergence, Monitor, Stop, Targets};

/// Returns the scanner for a kind of front, compiled in this crate.
///
/// If a generic function made the scanners, the compiler would generate the code of all kinds of fronts anew in each
/// crate that calls it. That takes one to two minutes.
fn compiled_scanner<R: Real>(
    edges: &EdgeLengths<R>,
    wavefront: Wavefront,
    order: Order,
) -> Box<dyn Scans<R>> {
    let edges: &dyn Any = edges;
    let scanner: Box<dyn Any> = match (edges.downcast_ref(), edges.downcast_ref()) {
        (Some(edges), _) => Box::new(scanner_in_single(edges, wavefront, order)),
        (_, Some(edges)) => Box::new(scanner_in_double(edges, wavefront, order)),
        _ => unreachable!("the precisions are f32 and f64"),
    };
    *scanner.downcast().expect("a scanner has the precision of its edges")
}

#[inline(never)]
fn scanner_in_single(
    edges: &EdgeLengths<f32>,
    wavefront: Wavefront,
    order: Order,
) -> Box<dyn Scans<f32>> {
    scanner(edges, wavefront, order)
}

#[inline(never)]
fn scanner_in_double(
    edges: &EdgeLengths<f64>,
    wavefront: Wavefront,
    order: Order,
) -> Box<dyn Scans<f64>> {
    scanner(edges, wavefront, order)
}

fn scanner<R: Real>(
    edges: &EdgeLengths<R>,
    wavefront: Wavefront,
    order: Order,
) -> Box<dyn Scans<R>> {
    if let Some(side) = order.in_time() {
        match FrontOver::new(edges, wavefront) {
            FrontOver::Planar(kind) => return in_order_of_time(edges, kind, side),
            FrontOver::Circular(kind) => return in_order_of_time(edges, kind, side),
            FrontOver::Curved(kind) => return in_order_of_time(edges, kind, side),
            FrontOver::Rays(kind) => return in_order_of_time(edges, kind, side),
            FrontOver::SlowedPlanar(kind) => return in_order_of_time(edges, kind, side),
            FrontOver::SlowedCurved(kind) => return in_order_of_time(edges, kind, side),
            FrontOver::Anchored(_) => {}
        }
    }
    for_kind!(edges, wavefront, kind => match order.plan() {
        Some(plan) => Box::new(PatchScanner::new(edges, kind, plan)),
        None => Box::new(Scanner::new(edges, kind)),
    })
}

/// Solves by the scans rotated by 45 degrees (figure 3, second row): down and up, then right and left. All
/// points of a row or column are updated at once, in SIMD lanes; see [`RotatedScan`].
pub fn rotated_scan<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    let mut solver = RotatedScan::new(edges, wavefront);
    let convergence = solver.solve(seeds, stop);
    solver.into_solution(convergence)
}

/// Margins of a map that ends at targets, as fractions of a time limit. At first the limit is the estimated time of
/// the targets plus the first margin. As long as the map has not reached the targets, the limit is raised by the next
/// margin. After the last margin there is no limit.
const FURTHER: [f64; 6] = [0.02, 0.06, 0.15, 0.3, 0.6, 1.0];

/// A solver by rotated scans for many maps of one surface, one after another. It allocates memory once; for patches
/// part of that happens during the first map. It holds a clone of the edge lengths, which shares their arrays.
///
/// For straight fronts on grids of at least 256 x 256 points, the second map fills another 12 bytes per point (in
/// single precision). On surfaces with many obtuse triangles, the second map stores the parts of these triangles with
/// the edges. Both make the second map and all later ones faster.
///
/// Large grids are solved patch by patch, by all threads of the pool that makes the solver ([`Order`]). On smaller
/// grids, opposite scans run in parallel on two copies of the fronts, which are then merged. This takes no more
/// iterations: a front that turns back has to pass through the other pair of scans anyway. In either order the map is
/// bit-identical for any number of threads. [`RotatedScan::new`] chooses the order by that number.
///
/// Where a slowness changes much from point to point, points are updated in the order in which fronts reach them
/// ([`Order::Times`], with several threads [`Order::TimesInPatches`]). Such a map takes one iteration, whatever [`Stop`]
/// says, and ends at its targets or its radius.
///
/// With patches, the number of iterations of a map is that of the patch with the most iterations, and
/// [`Stop::iterations`] limits the iterations of each patch. The residual is the largest change in the last iteration
/// of any patch, or a larger change beside a patch that had no iterations left to process it.
#[derive(Debug)]
pub struct RotatedScan<R> {
    edges: EdgeLengths<R>,
    chart: Chart,
    /// Largest arrival time of the maps; see [`Self::set_radius`].
    radius: f64,
    /// Largest arrival time of the last map. The map has no distances beyond this time.
    end: f64,
    /// Number of visited points for the estimate of the targets' times.
    foreseen: u64,
    /// The scanner for one kind of front.
    scanner: Box<dyn Scans<R>>,
}

impl<R: Real> RotatedScan<R> {
    /// Allocates the memory for maps of a surface. Uses the best instructions that are available.
    pub fn new(edges: &EdgeLengths<R>, wavefront: Wavefront) -> Self {
        let order = Order::best_on(edges, wavefront, rayon::current_num_threads());
        Self::in_order(edges, wavefront, order)
    }

    /// Allocates the memory as [`Self::new`] does, for maps in a given order instead of the best one.
    ///
    /// ```
    /// use geosweep::cpu::{Order, RotatedScan};
    /// use geosweep::surface::{EdgeLengths, Seed, builtin::Builtin};
    /// use geosweep::{Stop, Wavefront};
    ///
    /// let edges = EdgeLengths::<f32>::new(&Builtin::Plane.surface(200, 200)?)?;
    /// let order = Order::Patches { side: 64 };
    /// let mut solver = RotatedScan::in_order(&edges, Wavefront::Planar, order);
    /// let stop = Stop::within(1e-6).or_after(1000);
    /// assert!(solver.solve(&[Seed::at_source(0, 0, 0.0)], stop).residual <= 1e-6);
    /// // Sixteen patches were visited.
    /// let counts = solver.patches().unwrap();
    /// assert!(counts.patches == 16 && counts.visits >= 16);
    /// # Ok::<(), geosweep::surface::SurfaceError>(())
    /// ```
    pub fn in_order(edges: &EdgeLengths<R>, wavefront: Wavefront, order: Order) -> Self {
        let scanner = compiled_scanner(edges, wavefront, order);
        let (edges, chart) = (edges.clone(), edges.chart());
        let end = f64::INFINITY;
        Self { edges, chart, radius: end, end, foreseen: 0, scanner }
    }

    /// Sets the instructions. The map does not depend on them.
    ///
    /// # Panics
    /// If this machine does not have the instructions; see [`Instructions::available`].
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        assert!(
            Instructions::available().contains(&instructions),
            "this machine does not have {instructions}"
        );
        self.scanner.settings().instructions = instructions;
        self
    }

    /// Reports each iteration to `monitor`. If the monitor cancels a map, [`Self::solve`] and [`Self::add`]
    /// return at once, and the map is incomplete.
    pub fn with_monitor(mut self, monitor: Monitor) -> Self {
        self.scanner.settings().monitor = monitor;
        self
    }

    /// Sets a radius: points whose front would arrive later are unreached. Distances within the radius are
    /// those of the whole map. Only tiles that a front reaches within the radius are visited, so the work is
    /// proportional to the area of these tiles. With +infinity there is no limit.
    ///
    /// ```
    /// use geosweep::cpu::RotatedScan;
    /// use geosweep::surface::{EdgeLengths, Seed, builtin::Builtin};
    /// use geosweep::{Stop, Wavefront};
    ///
    /// let edges = EdgeLengths::<f32>::new(&Builtin::Plane.surface(401, 401)?)?;
    /// let (stop, seeds) = (Stop::within(1e-6).or_after(1000), [Seed::at_source(200, 200, 0.0)]);
    /// let mut whole = RotatedScan::new(&edges, Wavefront::Planar);
    /// whole.solve(&seeds, stop);
    /// let farthest = whole.distances()[0];
    /// let mut near = RotatedScan::new(&edges, Wavefront::Planar);
    /// near.set_radius(f64::from(0.2 * farthest));
    /// near.solve(&seeds, stop);
    /// assert!(near.distances()[0].is_infinite());
    /// assert!(near.visits() * 10 < whole.visits());
    /// # Ok::<(), geosweep::surface::SurfaceError>(())
    /// ```
    ///
    /// # Panics
    /// If the radius is NaN.
    pub fn set_radius(&mut self, radius: f64) {
        assert!(!radius.is_nan(), "the radius is a number");
        self.radius = radius;
    }

    /// Computes the distance map of `seeds`.
    pub fn solve(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        (self.end, self.foreseen) = (self.radius, 0);
        self.scanner.settings().limit = Limit::at(self.radius);
        self.scanner.solve(seeds, stop)
    }

    /// Computes the distance map of `seeds` up to the times of the targets ([`Targets`]). The map ends when no moving
    /// front can reach the targets earlier.
    ///
    /// At first the map is solved up to a coarse estimate of the targets' times. As long as it has not reached the
    /// targets, it is continued to later times. Then fronts later than the targets' times are not continued.
    ///
    /// # Panics
    /// If a target lies outside the grid.
    pub fn solve_to(&mut self, seeds: &[Seed], targets: &Targets, stop: Stop) -> Convergence {
        let (chart, radius) = (self.chart, self.radius);
        let inside = |&[row, col]: &[usize; 2]| row < chart.rows && col < chart.cols;
        assert!(targets.points().iter().all(inside), "a target lies outside the grid");
        let first = if self.scanner.is_in_order_of_time() {
            self.foreseen = 0;
            radius
        } else {
            let (estimate, foreseen) = estimate_targets(&self.edges, seeds, targets);
            self.foreseen = foreseen;
            radius.min(estimate * (1.0 + FURTHER[0]))
        };
        self.scanner.settings().limit = Limit::to(targets, first);
        let mut convergence = self.scanner.solve(seeds, stop);
        let mut further = FURTHER[1..].iter();
        loop {
            let limit = self.scanner.settings().limit.time();
            let times = self.scanner.times();
            let last = targets.last(|[row, col]| times[chart.bordered(row, col)].wide());
            let left = stop.iterations.saturating_sub(convergence.iterations);
            if last <= limit || limit >= radius || left == 0 {
                self.end = if last < FAR { radius.min(last) } else { radius };
                return convergence;
            }
            let next = match further.next() {
                // Times that are not final yet can only decrease, so this limit is late enough.
                _ if last < FAR => last * (1.0 + FURTHER[0]),
                Some(share) => limit * (1.0 + share),
                None => f64::INFINITY,
            };
            let limit = Limit::to(targets, radius.min(next));
            let stop = stop.or_after(left);
            if let Some(more) = self.scanner.go_on(seeds, stop, limit) {
                let iterations = convergence.iterations + more.iterations;
                convergence = Convergence { iterations, residual: more.residual };
            }
        }
    }

    /// Adds sources to the last map, as `geosweep::vulkan::HeadlessSolver::add` does on a device. Only tiles that the
    /// new fronts reach first are visited. So a source among many costs only as much as its own region.
    ///
    /// If the last map has converged, the result is the converged map of all sources. With the planar
    /// wavefront it equals the map that [`Self::solve`] finds from all of them, within the tolerance, since
    /// planar updates have a single fixed point. The updates of other wavefronts may have several. In practice
    /// the maps of both methods agree to rounding on smooth and on rough surfaces with holes
    /// (`tests/maps/sampling.rs`), except where curved fronts do not settle. Arrival times only decrease, with one
    /// exception: a curved front may be replaced by a more accurate one, which may be later by the error of the first.
    /// Seeds that start no earlier than the map at their points change nothing. On a new solver, `add` is equivalent to
    /// `solve`.
    ///
    /// ```
    /// use geosweep::cpu::RotatedScan;
    /// use geosweep::Stop;
    /// use geosweep::surface::{EdgeLengths, Seed, builtin::Builtin};
    /// use geosweep::Wavefront;
    ///
    /// let edges = EdgeLengths::<f32>::new(&Builtin::Plane.surface(101, 101)?)?;
    /// let stop = Stop::within(1e-6).or_after(1000);
    /// let mut solver = RotatedScan::new(&edges, Wavefront::Circular);
    /// solver.solve(&[Seed::at_source(0, 0, 0.0)], stop);
    /// let before = solver.distances();
    /// solver.add(&[Seed::at_source(100, 100, 0.0)], stop);
    /// let after = solver.distances();
    /// assert!(after[0] == 0.0 && after[101 * 101 - 1] == 0.0);
    /// assert!(after.iter().zip(&before).all(|(after, before)| after <= before));
    /// # Ok::<(), geosweep::surface::SurfaceError>(())
    /// ```
    pub fn add(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        let limit = Limit::at(self.radius);
        // The last map may have ended before the radius, at its targets.
        match self.scanner.settings().limit.time() < self.radius {
            true => drop(self.scanner.go_on(&[], stop, limit)),
            false => self.scanner.settings().limit = limit,
        }
        self.end = self.radius;
        self.scanner.add(seeds, stop)
    }

    /// Returns the distances of the last map, row-major. They are +infinity where the sources do not reach.
    pub fn distances(&self) -> Vec<R> {
        distances(self.chart, self.scanner.times(), self.end)
    }

    /// Returns the points that the last map has reached, as grid indices in ascending order, with their
    /// distances. The work is proportional to the area that the map has reached, except in the order of patches.
    pub fn reached(&self) -> Vec<(usize, R)> {
        let (chart, times) = (self.chart, self.scanner.times());
        let places = self.scanner.used().into_iter().flat_map(|block| block.places());
        let points = places
            .map(|(row, col)| (chart.index(row, col), times[chart.bordered(row, col)]))
            .filter(|(_, time)| *time < R::FAR && time.wide() <= self.end);
        let mut points: Vec<_> = points.collect();
        points.sort_unstable_by_key(|&(point, _)| point);
        points
    }

    /// Returns the last map.
    #[doc(hidden)]
    pub fn into_solution(self, convergence: Convergence) -> Solution<R> {
        let Convergence { iterations, residual } = convergence;
        let times = self.scanner.into_times();
        Solution::new(self.chart, times, iterations, residual).ending_at(self.end)
    }

    /// Returns whether maps are solved in the order of arrival times ([`Order::Times`]).
    #[doc(hidden)]
    pub fn is_in_order_of_time(&self) -> bool {
        self.scanner.is_in_order_of_time()
    }

    /// Returns the rounds and visits of the last map, if it was solved by patches.
    pub fn patches(&self) -> Option<PatchCounts> {
        self.scanner.patches()
    }

    /// Returns the number of point visits of the last map. A visit reads what the point's update needs.
    /// Points that are examined before a scan, to decide whether to visit them, count as well.
    pub fn visits(&self) -> u64 {
        self.foreseen + self.scanner.visits()
    }

    /// Returns the number of point updates of the last map. Each update uses one or two triangles. There are
    /// fewer updates than visits, since settled points are visited but not updated: a simpler test finds that no front
    /// reaches them earlier.
    pub fn updates(&self) -> u64 {
        self.scanner.updates()
    }

    /// Returns the memory in bytes, without the edge lengths.
    pub fn bytes(&self) -> usize {
        self.scanner.bytes()
    }

    /// Returns the arrival times along a row. They are [`Real::FAR`] or later where no source reaches.
    #[doc(hidden)]
    pub fn row(&self, row: usize) -> &[R] {
        self.chart.row_of(self.scanner.times(), row)
    }
}

impl<R: Real> Clone for RotatedScan<R> {
    fn clone(&self) -> Self {
        let (edges, scanner) = (self.edges.clone(), self.scanner.boxed());
        let Self { chart, radius, end, foreseen, .. } = *self;
        Self { edges, chart, radius, end, foreseen, scanner }
    }
}
