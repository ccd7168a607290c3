//! Rotated raster scans in lanes: whole rows, then whole columns.

use std::ops::Range;

use rayon::prelude::*;

use super::anchored_scan::{Lines, Plan};
use super::due::Before;
use super::field::Field;
use super::line_update::{How, Updated};
use super::panel::{Grid, Panel};
use super::state::{SEED, Solution, accept, accept_anchored, first, first_anchored, is_from};
use super::tiles::{Scan, TILE, Tiles, points};
use super::turned::Turned;
use super::{Instructions, Progress};
use crate::lanes::Work;
use crate::surface::{Chart, EdgeLengths, Real, Seed, min};
use crate::update::{Floor, Front, Wavefront};
use crate::{Convergence, Stop};

/// Solves by the scans rotated by 45 degrees (figure 3, second row): down and up, then right and
/// left. All points of a row or column are updated at once, in lanes; see [`RotatedScan`].
pub fn rotated_scan<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    let mut solver = RotatedScan::new(edges, wavefront);
    let Convergence { iterations, residual } = solver.solve(seeds, stop);
    let [fronts, _] = solver.fronts;
    Solution::new(edges.chart(), fronts.times, iterations, residual)
}

/// Solves one map after another of one surface by rotated scans, without allocating anew. The second
/// map of straight fronts on grids of 256 x 256 points and more fills 12 bytes a point in single
/// precision that make it and all others faster.
///
/// Opposite scans run side by side on two copies of the fronts, which are then merged: a front
/// that turns back has to pass through the other pair of scans anyhow. So the map is the same to
/// the bit for any number of threads.
#[derive(Clone, Debug)]
pub struct RotatedScan<'a, R> {
    edges: &'a EdgeLengths<R>,
    /// Of the surface; empty unless the wavefront is curved.
    gaussian: &'a [R],
    /// If fronts have anchors.
    plan: Option<Plan<R>>,
    wavefront: Wavefront,
    instructions: Instructions,
    tiles: Tiles,
    fronts: [Fronts<R>; 2],
    /// For straight fronts on large grids, filled by the second map; with curved ones there is more to
    /// keep beside.
    turned: Option<Turned<R>>,
    /// Whether there has been a map.
    solved: bool,
    /// How many points scans have looked at before they started.
    looked: u64,
}

/// Points from which on edges are turned for good. On smaller grids these and the panels would be more
/// than 40 bytes a point, and what is turned lies in near caches.
const TURNED_FROM: usize = 256 * 256;

/// The fronts at all points as one scan sees them, and its work space.
#[derive(Clone, Debug)]
struct Fronts<R> {
    times: Vec<R>,
    /// Tagged with the scan that has brought them, or in their place numbers of anchors; empty if the front
    /// has neither.
    curvatures: Vec<R>,
    /// The tiles that the scan has changed.
    changed: Vec<bool>,
    panel: Panel<R>,
    /// The stretches of a band to visit, and the tiles of one of them that have changed.
    runs: Vec<Range<usize>>,
    marks: Vec<bool>,
    /// Visits and updates of a point since the start.
    visits: u64,
    updates: u64,
}

impl<'a, R: Real> RotatedScan<'a, R> {
    /// Makes room for the maps of a surface, on the best instructions there are.
    pub fn new(edges: &'a EdgeLengths<R>, wavefront: Wavefront) -> Self {
        let (chart, wavefront) = (edges.chart(), wavefront.over(edges));
        let (curved, two_layers) = (wavefront.is_curved(), wavefront.has_two_layers());
        let points = chart.bordered_points();
        let tiles = Tiles::new(chart);
        let longest_band = tiles.in_band(Scan::DOWN).max(tiles.in_band(Scan::RIGHT));
        let fronts = || Fronts {
            times: vec![R::FAR; points],
            curvatures: vec![R::zero(); if two_layers { points } else { 0 }],
            changed: vec![false; tiles.len()],
            panel: Panel::new(chart, wavefront),
            runs: Vec::with_capacity(longest_band),
            marks: Vec::with_capacity(longest_band),
            visits: 0,
            updates: 0,
        };
        Self {
            edges,
            gaussian: if curved { edges.gaussian_curvature() } else { &[] },
            plan: (wavefront == Wavefront::Anchored)
                .then(|| Floor::of(edges).map(|floor| Plan::new(chart, floor)))
                .flatten(),
            wavefront,
            instructions: Instructions::best(),
            // Each by the thread that will use it.
            fronts: rayon::join(fronts, fronts).into(),
            tiles,
            turned: (!two_layers && chart.points() >= TURNED_FROM).then(|| Turned::new(chart)),
            solved: false,
            looked: 0,
        }
    }

    /// Chooses the instructions; the map does not depend on them.
    ///
    /// # Panics
    /// If this machine does not have them; see [`Instructions::available`].
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        assert!(Instructions::available().contains(&instructions), "no {instructions} here");
        self.instructions = instructions;
        self
    }

    /// Computes the map of some sources.
    pub fn solve(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        // Into the pool of threads once, and not for each pair of scans.
        rayon::scope(|_| {
            if std::mem::replace(&mut self.solved, true) {
                self.turn();
            }
            self.forget();
            self.add(seeds, stop)
        })
    }

    /// Adds sources to the last map, as [`crate::vulkan::Solver::add`] does on a device. Only tiles
    /// that their fronts reach first are visited, so that a source among many costs what its own
    /// region does.
    ///
    /// If the last map has converged, so has this one, of all sources. With the planar wavefront it
    /// is the one that [`Self::solve`] finds from all of them, within the tolerance, whose updates
    /// have a single fixed point. The others' have not in theory; on smooth and on rough surfaces
    /// with holes both ways agree to rounding all the same (`tests/maps/sampling.rs`), but where curved
    /// fronts do not settle. Times fall, but a curved front that is renewed may come later by its
    /// error. Seeds that lie behind the map change nothing. On a new solver this is `solve`.
    ///
    /// ```
    /// use geosweep::cpu::RotatedScan;
    /// use geosweep::Stop;
    /// use geosweep::surface::{EdgeLengths, Seed, builtin::Builtin};
    /// use geosweep::Wavefront;
    ///
    /// let edges = EdgeLengths::<f32>::new(&Builtin::Plane.surface(101, 101)?)?;
    /// let stop = Stop { tolerance: 1e-6, iterations: 1000 };
    /// let mut solver = RotatedScan::new(&edges, Wavefront::PointSource);
    /// solver.solve(&[Seed::at_source(0, 0, 0.0)], stop);
    /// let before = solver.distances();
    /// solver.add(&[Seed::at_source(100, 100, 0.0)], stop);
    /// let after = solver.distances();
    /// assert!(after[0] == 0.0 && after[101 * 101 - 1] == 0.0);
    /// assert!(after.iter().zip(&before).all(|(after, before)| after <= before));
    /// # Ok::<(), geosweep::surface::SurfaceError>(())
    /// ```
    pub fn add(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        self.seed(seeds);
        // Into the pool of threads once, and not for each pair of scans.
        rayon::scope(|_| self.converge(stop))
    }

    fn converge(&mut self, stop: Stop) -> Convergence {
        let mut progress = Progress::new(stop);
        loop {
            let vertical = self.scan([Scan::DOWN, Scan::UP], progress.renews());
            let horizontal = self.scan([Scan::RIGHT, Scan::LEFT], progress.renews());
            if progress.is_done::<R>(vertical.max(horizontal)) {
                let Progress { iterations, residual, .. } = progress;
                return Convergence { iterations, residual };
            }
        }
    }

    /// The distances of the last map, row-major, +infinity where the sources do not reach.
    pub fn distances(&self) -> Vec<R> {
        let chart = self.edges.chart();
        super::state::distances(chart, &self.fronts[0].times)
    }

    /// How many times the scans of the last map have come to a point, and read what its update
    /// needs, or have looked before whether to come.
    pub fn visits(&self) -> u64 {
        self.looked + self.fronts.iter().map(|fronts| fronts.visits).sum::<u64>()
    }

    /// How many times they have updated one, each time from one triangle or two: less often, since
    /// of points that are settled a simpler test finds that no front comes earlier.
    pub fn updates(&self) -> u64 {
        self.fronts.iter().map(|fronts| fronts.updates).sum()
    }

    /// Bytes held, beside the edge lengths.
    pub fn bytes(&self) -> usize {
        let of = |fronts: &Fronts<R>| {
            std::mem::size_of_val(fronts.times.as_slice())
                + std::mem::size_of_val(fronts.curvatures.as_slice())
                + fronts.changed.len()
                + fronts.panel.bytes()
        };
        let turned = self.turned.as_ref().map_or(0, Turned::bytes);
        let plan = self.plan.as_ref().map_or(0, Plan::bytes);
        self.fronts.iter().map(of).sum::<usize>() + self.tiles.bytes() + turned + plan
    }

    /// Arrival time and curvature of the front at a point, [`Real::FAR`] or later where no source reaches.
    /// A front without a curvature of its own has that of a circle around its source.
    pub(crate) fn front(&self, row: usize, col: usize) -> [R; 2] {
        let (point, Fronts { times, curvatures, .. }) =
            (self.edges.chart().bordered(row, col), &self.fronts[0]);
        let time = times[point];
        [time, curvatures.get(point).copied().unwrap_or_else(|| time.recip())]
    }

    /// The arrival times along a row, [`Real::FAR`] or later where no source reaches.
    pub(crate) fn row(&self, row: usize) -> &[R] {
        let chart = self.edges.chart();
        &self.fronts[0].times[chart.bordered(row, 0)..][..chart.cols]
    }

    /// Keeps the edges between columns as scans to the right and left need them.
    fn turn(&mut self) {
        if let Some(turned) = &mut self.turned {
            turned.fill(self.edges, self.instructions);
            self.fronts.iter_mut().for_each(|fronts| fronts.panel.free_edges_back());
        }
    }

    /// No point reached.
    fn forget(&mut self) {
        self.looked = 0;
        if let Some(plan) = &mut self.plan {
            plan.floor.forget();
        }
        self.fronts.par_iter_mut().for_each(|fronts| {
            (fronts.visits, fronts.updates) = (0, 0);
            fronts.times.fill(R::FAR);
            fronts.curvatures.fill(R::zero());
        });
        self.tiles.reset();
    }

    /// Starts from seeds that arrive before the map.
    fn seed(&mut self, seeds: &[Seed]) {
        let chart = self.edges.chart();
        for seed in seeds {
            let point = chart.bordered(seed.row, seed.col);
            let curvature = match &mut self.plan {
                Some(plan) => plan.floor.anchor_of(seed),
                None => R::of(seed.curvature),
            };
            let anchored = self.plan.is_some();
            let front = Front { time: R::of(seed.time), curvature, whole: true };
            let mut changed = false;
            for Fronts { times, curvatures, .. } in &mut self.fronts {
                let time = &mut times[point];
                changed |= front.time < *time;
                match curvatures.get_mut(point) {
                    Some(anchor) if anchored => {
                        [*time, *anchor] = accept_anchored([*time, *anchor], front, SEED, false)
                    }
                    Some(curvature) => {
                        (*time, *curvature) = accept(*time, *curvature, front, SEED, false)
                    }
                    None => *time = time.min(front.time),
                }
            }
            if changed {
                self.tiles.touch(seed.row, seed.col);
            }
        }
    }

    /// Runs two opposite scans; returns the largest change.
    fn scan(&mut self, scans: [Scan; 2], renews: bool) -> R::Bits {
        let turned = self.turned.as_ref().and_then(Turned::filled);
        let (gaussian, plan) = match &self.plan {
            Some(plan) => (plan.holes.as_slice(), Some(plan)),
            None => (self.gaussian, None),
        };
        let grid = Grid { edges: self.edges, turned, gaussian };
        let (wavefront, instructions) = (self.wavefront, self.instructions);
        let how = |scan| How { wavefront, scan, renews, instructions };
        let Fronts { times, curvatures, .. } = &self.fronts[0];
        let before = Before { edges: self.edges, times, curvatures, plan };
        self.looked += before.find_due(&mut self.tiles, scans.map(how));
        let (tiles, [first, second]) = (&self.tiles, &mut self.fronts);
        let (a, b) = rayon::join(
            || first.scan(grid, plan, tiles, how(scans[0])),
            || second.scan(grid, plan, tiles, how(scans[1])),
        );
        merge(grid.edges.chart(), tiles, [first, second], scans, instructions, plan.is_some());
        self.tiles.passed(scans, [&self.fronts[0].changed, &self.fronts[1].changed]);
        self.fronts.iter_mut().for_each(|fronts| fronts.changed.fill(false));
        a.max(b)
    }
}

impl<R: Real> Fronts<R> {
    fn scan(&mut self, grid: Grid<R>, plan: Option<&Plan<R>>, tiles: &Tiles, how: How) -> R::Bits {
        let mut updated = Updated::<R::Bits>::default();
        let mut runs = std::mem::take(&mut self.runs);
        for band in tiles.bands(how.scan) {
            tiles.runs(how.scan, band, &self.changed, &mut runs);
            for run in &runs {
                updated = updated.and(if how.scan.by_rows() {
                    self.scan_rows(grid, plan, tiles, how, band, run)
                } else {
                    self.scan_cols(grid, plan, tiles, how, band, run)
                });
            }
        }
        self.runs = runs;
        self.updates += updated.points;
        updated.largest
    }

    /// Scans a stretch of the rows of a band.
    fn scan_rows(
        &mut self,
        grid: Grid<R>,
        plan: Option<&Plan<R>>,
        tiles: &Tiles,
        how: How,
        band: usize,
        run: &Range<usize>,
    ) -> Updated<R::Bits> {
        let chart = grid.edges.chart();
        let first = tiles.index(how.scan, band, run.start);
        let changed = &mut self.changed[first..first + run.len()];
        let (rows, cols) = (points(band..band + 1, chart.rows), points(run.clone(), chart.cols));
        self.visits += (rows.len() * cols.len()) as u64;
        if let Some(plan) = plan {
            let mut lines = Lines {
                plan,
                chart,
                times: &mut self.times,
                anchors: &mut self.curvatures,
                holes: &plan.holes,
                stride: chart.stride(),
                first: 0,
                beyond: None,
            };
            return in_order(rows, how.scan, |row| {
                lines.update(row + 1, cols.clone(), how, changed)
            });
        }
        let mut field = Field {
            stride: chart.stride(),
            times: &mut self.times,
            curvatures: &mut self.curvatures,
            gaussian: grid.gaussian,
            edges: grid.edges.planes(),
        };
        in_order(rows, how.scan, |row| field.update(row + 1, cols.clone(), how, changed))
    }

    /// Scans a stretch of the columns of a band.
    fn scan_cols(
        &mut self,
        grid: Grid<R>,
        plan: Option<&Plan<R>>,
        tiles: &Tiles,
        how: How,
        band: usize,
        run: &Range<usize>,
    ) -> Updated<R::Bits> {
        let chart = grid.edges.chart();
        let (rows, cols) = (points(run.clone(), chart.rows), points(band..band + 1, chart.cols));
        self.visits += (rows.len() * cols.len()) as u64;
        let panel = &mut self.panel;
        let arrays = [self.times.as_slice(), self.curvatures.as_slice()];
        panel.load(grid, arrays, &cols, rows.clone(), how.scan, how.instructions);
        let first = panel.line(cols.start + 1);
        self.marks.clear();
        self.marks.resize(run.len(), false);
        let line = |col: usize| col - cols.start + first;
        let updated = if let Some(plan) = plan {
            let mut lines = panel.lines(plan, chart, rows.clone(), arrays);
            in_order(cols.clone(), how.scan, |col| {
                lines.update(line(col), rows.clone(), how, &mut self.marks)
            })
        } else {
            let mut field = panel.field(grid);
            in_order(cols.clone(), how.scan, |col| {
                field.update(line(col), rows.clone(), how, &mut self.marks)
            })
        };
        for (place, _) in run.clone().zip(&self.marks).filter(|(_, marked)| **marked) {
            self.changed[tiles.index(how.scan, band, place)] = true;
            let arrays = [self.times.as_mut_slice(), self.curvatures.as_mut_slice()];
            let rows = points(place..place + 1, chart.rows);
            panel.store(arrays, chart.stride(), &cols, rows, how.instructions);
        }
        updated
    }
}

/// Updates lines in the order of a scan.
fn in_order<B: Ord + Default>(
    lines: Range<usize>,
    scan: Scan,
    update: impl FnMut(usize) -> Updated<B>,
) -> Updated<B> {
    let none = Updated::default();
    if scan.is_forward() {
        lines.map(update).fold(none, Updated::and)
    } else {
        lines.rev().map(update).fold(none, Updated::and)
    }
}

/// Makes both copies of the fronts the same again, with the first to arrive at each point.
fn merge<R: Real>(
    chart: Chart,
    tiles: &Tiles,
    fronts: [&mut Fronts<R>; 2],
    scans: [Scan; 2],
    instructions: Instructions,
    anchored: bool,
) {
    let [a, b] = fronts;
    let changed = [a.changed.as_slice(), b.changed.as_slice()];
    let bands = |array| bands(chart, array);
    if a.curvatures.is_empty() {
        let times = bands(&mut a.times).zip(bands(&mut b.times));
        times.enumerate().for_each(|(band, (a, b))| {
            merge_band(chart, tiles, band, changed, |points, changed| {
                let (a, b) = (&mut a[points.clone()], &mut b[points]);
                match changed {
                    [true, true] => instructions.run(MergeTimes { a, b }),
                    [true, false] => b.copy_from_slice(a),
                    _ => a.copy_from_slice(b),
                }
            });
        });
    } else {
        let a = bands(&mut a.times).zip(bands(&mut a.curvatures));
        let b = bands(&mut b.times).zip(bands(&mut b.curvatures));
        a.zip(b).enumerate().for_each(|(band, ((a, a_bent), (b, b_bent)))| {
            merge_band(chart, tiles, band, changed, |points, changed| {
                let a = [&mut a[points.clone()], &mut a_bent[points.clone()]];
                let b = [&mut b[points.clone()], &mut b_bent[points]];
                // What one scan has left alone is as it was before, and the other's is what has come.
                match changed {
                    [true, true] => instructions.run(MergeCurved { a, b, scans, anchored }),
                    [true, false] => std::iter::zip(b, a).for_each(|(b, a)| b.copy_from_slice(a)),
                    _ => std::iter::zip(a, b).for_each(|(a, b)| a.copy_from_slice(b)),
                }
            });
        });
    }
}

/// The rows of a bordered array, as many at a time as a tile has.
fn bands<R: Real>(chart: Chart, array: &mut [R]) -> impl IndexedParallelIterator<Item = &mut [R]> {
    let rows = chart.rows * chart.stride();
    array[chart.stride()..][..rows].par_chunks_mut(TILE * chart.stride())
}

/// Calls `merge` with the points of each line of a band's tiles that one of two scans has changed,
/// and says which.
fn merge_band(
    chart: Chart,
    tiles: &Tiles,
    band: usize,
    changed: [&[bool]; 2],
    mut merge: impl FnMut(Range<usize>, [bool; 2]),
) {
    let places = tiles.in_band(Scan::DOWN);
    let changed = |place| changed.map(|changed| changed[tiles.index(Scan::DOWN, band, place)]);
    let mut place = 0;
    while place < places {
        let (start, of_run) = (place, changed(place));
        while place < places && changed(place) == of_run {
            place += 1;
        }
        if of_run == [false; 2] {
            continue;
        }
        let cols = points(start..place, chart.cols);
        for row in 0..points(band..band + 1, chart.rows).len() {
            let start = row * chart.stride() + 1;
            merge(start + cols.start..start + cols.end, of_run);
        }
    }
}

/// Takes the earlier of two arrival times.
struct MergeTimes<'a, R> {
    a: &'a mut [R],
    b: &'a mut [R],
}

impl<R: Real> Work for MergeTimes<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (a, b) in self.a.iter_mut().zip(self.b) {
            let first = min(*a, *b);
            (*a, *b) = (first, first);
        }
    }
}

/// Takes the first of two fronts, given as arrival times and tagged curvatures. A copy whose front
/// the other scan had brought before has not changed at this point.
struct MergeCurved<'a, R> {
    a: [&'a mut [R]; 2],
    b: [&'a mut [R]; 2],
    scans: [Scan; 2],
    anchored: bool,
}

impl<R: Real> Work for MergeCurved<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { a: [a_times, a_curvatures], b: [b_times, b_curvatures], scans, anchored } = self;
        let of_a = a_times.iter_mut().zip(a_curvatures);
        for ((a, a_bent), (b, b_bent)) in of_a.zip(b_times.iter_mut().zip(b_curvatures)) {
            let a_is_old = is_from(*a_bent, scans[1].0);
            let b_is_old = is_from(*b_bent, scans[0].0);
            let [time, bent] = if anchored {
                first_anchored([*a, *a_bent], [*b, *b_bent])
            } else {
                first([*a, *a_bent], [*b, *b_bent])
            };
            let (time, bent) =
                (if b_is_old { *a } else { time }, if b_is_old { *a_bent } else { bent });
            let (time, bent) =
                (if a_is_old { *b } else { time }, if a_is_old { *b_bent } else { bent });
            (*a, *a_bent) = (time, bent);
            (*b, *b_bent) = (time, bent);
        }
    }
}
