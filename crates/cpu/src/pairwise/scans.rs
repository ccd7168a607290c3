//! Runs raster scans over the maps of a batch.

use std::sync::{Arc, Mutex};

use super::farther::Farther;
use super::kernel::{Fan, Kernel, LANES, Lanes, merged};
use super::maps::{Known, Maps};
use super::marks::WORD;
use super::outward::Passing;
use super::parts::{LaneParts, VisitParts};
use crate::behind::Behind;
use crate::scan::Scan;
use crate::{Instructions, Progress};
use geosweep_surface::lanes::Loop;
use geosweep_surface::{Chart, EdgeLengths, Offset};
use geosweep_surface::{Convergence, Stop};

/// Coefficients of a surface for one kind of front, and working memory for as many batches as have been computed at
/// once.
pub(super) struct Scans<K: Kernel> {
    chart: Chart,
    /// Coefficients of all points for each scan, in the order in which the scan passes them.
    coefficients: [Vec<K::Coefficients>; 4],
    /// Parts of obtuse triangles, for each scan.
    parts: [LaneParts<K>; 4],
    farther: Arc<Farther>,
    spare: Mutex<Vec<Maps>>,
}

/// Scans of any kind of front.
pub(super) trait BatchSolver: Send + Sync {
    /// Returns the bytes of the coefficients, and of the working memory of one batch.
    fn bytes(&self) -> (usize, usize);

    /// Computes the maps of at most [`LANES`] sources, and writes those that have a row in `into`.
    fn solve(
        &self,
        sources: &[Option<usize>],
        known: Known,
        stop: Stop,
        instructions: Instructions,
        into: &mut [Option<&mut [f32]>],
    ) -> Convergence;
}

impl<K: Kernel> Scans<K> {
    pub(super) fn new(edges: &EdgeLengths<f32>) -> Self {
        let chart = edges.chart();
        let coefficients = Scan::ALL.map(|scan| {
            let behind = Behind::of(chart, scan);
            let at = |row, col| K::coefficients(Fan::of(&behind, edges, chart.bordered(row, col)));
            let lines = chart.by(scan.lines());
            let places = lines.places().map(|(line, point)| scan.lines().place(line, point));
            places.map(|(row, col)| at(row, col)).collect()
        });
        let parts = Scan::ALL.map(|scan| LaneParts::new(edges, scan));
        let farther = Arc::new(Farther::new(edges));
        Self { chart, coefficients, parts, farther, spare: Mutex::default() }
    }

    fn iterate<const TRACKS: bool>(
        &self,
        maps: &mut Maps,
        stop: Stop,
        instructions: Instructions,
    ) -> Convergence {
        let mut progress = Progress::new(stop);
        // Changes below the tolerance are stored but wake no points.
        let wakes = (stop.tolerance / f64::from(f32::EPSILON)) as u32;
        loop {
            let mut largest = 0;
            for scan in Scan::ALL {
                largest = largest.max(self.scan::<TRACKS>(maps, scan, wakes, instructions));
            }
            maps.outward = None;
            if !TRACKS {
                largest = u32::MAX;
            }
            if progress.is_done::<f32>(largest) {
                return progress.convergence();
            }
        }
    }

    /// Runs one scan over the pending points. Returns the largest change.
    fn scan<const TRACKS: bool>(
        &self,
        maps: &mut Maps,
        scan: Scan,
        wakes: u32,
        instructions: Instructions,
    ) -> u32 {
        let Maps { points, pending, outward, changed, .. } = maps;
        let (chart, lines) = (self.chart, self.chart.by(scan.lines()));
        let step = chart.stride_along(scan.lines());
        let behind = chart.offset(scan.back());
        let index = usize::from(scan.0) - 1;
        let (coefficients, parts) = (&self.coefficients[index], &self.parts[index]);
        let changed = changed[scan.lines() as usize].line_mut(0);
        let mut largest = 0;
        for line in scan.in_order(0..lines.rows) {
            let passing = match outward {
                Some(outward) => outward.passing(scan, line),
                None => Passing::All,
            };
            if passing == Passing::None {
                continue;
            }
            let Some(marks) = pending.take(scan, line, passing == Passing::All) else { continue };
            let maps = match passing {
                Passing::Some(maps) => maps,
                _ => [u32::MAX; LANES],
            };
            let (row, col) = scan.lines().place(line, 0);
            let first = chart.bordered(row, col);
            let parts = parts.of_line(line);
            if !parts.is_empty() {
                changed.fill(0);
                let changed = &mut *changed;
                let visit: VisitParts<K, TRACKS> =
                    VisitParts { points, first, step, parts, marks, changed, wakes, maps };
                largest = largest.max(instructions.run(visit));
            }
            let work = MarkedLine::<K> {
                points,
                first,
                step,
                behind,
                coefficients: &coefficients[lines.row(line)],
                marks,
                maps,
                wakes,
            };
            let change = match passing {
                Passing::All => instructions.run(Visit::<K, TRACKS, true>(work)),
                _ => instructions.run(Visit::<K, TRACKS, false>(work)),
            };
            largest = largest.max(change);
            if !parts.is_empty() {
                pending.changed_too(scan, line, changed);
            }
            pending.tell(scan, line);
        }
        pending.end(scan);
        largest
    }
}

impl<K: Kernel> BatchSolver for Scans<K> {
    fn bytes(&self) -> (usize, usize) {
        let coefficients = self.coefficients.iter().map(Vec::len).sum::<usize>();
        let parts = self.parts.iter().map(LaneParts::bytes).sum::<usize>() + self.farther.bytes();
        (coefficients * size_of::<K::Coefficients>() + parts, Maps::bytes(self.chart))
    }

    fn solve(
        &self,
        sources: &[Option<usize>],
        known: Known,
        stop: Stop,
        instructions: Instructions,
        into: &mut [Option<&mut [f32]>],
    ) -> Convergence {
        let spare = self.spare.lock().expect("nothing panics while it is held").pop();
        let mut maps = spare.unwrap_or_else(|| Maps::new(self.chart, self.farther.clone()));
        maps.start(self.chart, sources, known);
        let convergence = if stop.iterations == 1 {
            // The solver stops after a single iteration anyway, so changes need not be tracked.
            self.iterate::<false>(&mut maps, stop, instructions)
        } else {
            self.iterate::<true>(&mut maps, stop, instructions)
        };
        maps.stage.store(self.chart, &mut maps.points, instructions, into);
        self.spare.lock().expect("nothing panics while it is held").push(maps);
        convergence
    }
}

/// The marked points of a line, and the line behind.
struct MarkedLine<'a, K: Kernel> {
    points: &'a mut [Lanes],
    /// The line's first point in the bordered array, the offset to the next point, and the offset to the
    /// neighbour behind.
    first: usize,
    step: usize,
    behind: Offset,
    coefficients: &'a [K::Coefficients],
    marks: &'a mut [u64],
    /// A mask for each map, with all bits set if the scan passes the line in that map.
    maps: [u32; LANES],
    /// Changes above this limit wake the neighbouring points; see [`Lanes::lower`].
    wakes: u32,
}

/// The update of the marked points of a line, in `ALL` maps or in those in which the scan passes the line. Afterwards
/// the points that have changed are marked. Returns the largest change.
struct Visit<'a, K: Kernel, const TRACKS: bool, const ALL: bool>(MarkedLine<'a, K>);

impl<K: Kernel, const TRACKS: bool, const ALL: bool> Loop for Visit<'_, K, TRACKS, ALL> {
    type Output = u32;

    #[inline(always)]
    fn run(self) -> u32 {
        let MarkedLine { points, first, step, behind, coefficients, marks, maps, wakes } = self.0;
        let mut largest = [0; LANES];
        for (k, word) in marks.iter_mut().enumerate() {
            let (mut visits, mut changed) = (*word, 0);
            while visits != 0 {
                let bit = visits.trailing_zeros();
                visits &= visits - 1;
                let point = k * WORD + bit as usize;
                let here = first + point * step;
                let beside = behind.from(here);
                let behind = [&points[beside - step], &points[beside], &points[beside + step]];
                let (mut state, coefficients) = (points[here], &coefficients[point]);
                if K::may_change(&state, behind, coefficients) {
                    let arrivals = K::arrivals(behind, coefficients);
                    // There is no branch on whether a time falls, since it could not be predicted.
                    let wakes_others = state.lower::<TRACKS>(arrivals, wakes, &mut largest);
                    changed |= u64::from(wakes_others) << bit;
                    points[here] = if ALL { state } else { merged(state, points[here], maps) };
                }
            }
            *word = changed;
        }
        if TRACKS { largest.into_iter().max().unwrap_or_default() } else { u32::MAX }
    }
}
