//! In which tiles two scans have anything to do, found before they start.
//!
//! A scan has to look at every tile beside a change, and in most of them confirms that nothing
//! follows from it: where all points are settled ([`stays`]) with the fronts that the scan starts
//! from, it changes nothing unless it brings a change there itself. That is found here for both
//! scans of a pair at once, row by row as points lie in memory and by any number of threads. So few
//! tiles are left of which columns have to be transposed.

use std::ops::Range;

use rayon::prelude::*;

use super::anchored_scan::Plan;
use super::line_update::How;
use super::settled::{Visited, stays};
use super::state::is_from;
use super::tiles::{Scan, TILE, Tiles, points};
use crate::lanes::{Work, prefetch};
use crate::surface::{Chart, Direction, EdgeLengths, EdgeSlot, Real, min};
use crate::update::{Triangle, Wavefront, is_shorter};

/// The fronts at all points that two scans start from.
#[derive(Clone, Copy)]
pub(super) struct Before<'a, R> {
    pub edges: &'a EdgeLengths<R>,
    pub times: &'a [R],
    /// Or numbers of anchors; empty if the front has neither.
    pub curvatures: &'a [R],
    /// If fronts have anchors.
    pub plan: Option<&'a Plan<R>>,
}

impl<R: Real> Before<'_, R> {
    /// Finds the tiles in which two scans have something to do; returns how many points were looked
    /// at, twice those that were for both.
    pub(super) fn find_due(self, tiles: &mut Tiles, scans: [How; 2]) -> u64 {
        let chart = self.edges.chart();
        let seen = scans.map(|how| (how, Behind::new(chart, how.scan)));
        let in_band = |(band, (beside, due)): (usize, (&[u8], &mut [u8]))| {
            let mut looked = 0;
            for row in points(band..band + 1, chart.rows) {
                for (how, behind) in &seen {
                    for run in runs(beside, how.scan) {
                        let due = &mut due[run.clone()];
                        let cols = points(run, chart.cols);
                        looked += cols.len() as u64;
                        let first = chart.bordered(row, cols.start);
                        let around = self.around(behind, first, cols.len());
                        let (before, stride) = (self, chart.stride() as isize);
                        how.instructions.run(Look {
                            before,
                            first,
                            around,
                            stride,
                            how: *how,
                            due,
                        });
                    }
                }
            }
            looked
        };
        tiles.rows_beside_changes(scans.map(|how| how.scan)).enumerate().map(in_band).sum()
    }

    /// What updates of so many points in a row see.
    fn around(&self, behind: &Behind, first: usize, points: usize) -> Around<'_, R> {
        let at = |offset: isize| first.wrapping_add_signed(offset);
        let curved = if self.curvatures.is_empty() { 0 } else { points };
        let first_bent = |at: usize| if curved > 0 { at } else { 0 };
        Around {
            times: &self.times[first..][..points],
            behind: behind.points.map(|offset| &self.times[at(offset)..][..points]),
            edges: behind.edges.map(|slot| self.edges.row(first, slot, points)),
            bases: behind.bases.map(|slot| self.edges.row(first, slot, points)),
            curvatures: &self.curvatures[first_bent(first)..][..curved],
            curvatures_behind: behind
                .points
                .map(|offset| &self.curvatures[first_bent(at(offset))..][..curved]),
        }
    }
}

/// The tiles of a row of them that a scan has to look at, which stand side by side.
fn runs(beside: &[u8], scan: Scan) -> impl Iterator<Item = Range<usize>> {
    let mut end = 0;
    std::iter::from_fn(move || {
        let start = end + beside[end..].iter().position(|scans| scans & scan.bit() != 0)?;
        let count = beside[start..].iter().take_while(|&scans| scans & scan.bit() != 0).count();
        end = start + count;
        Some(start..end)
    })
}

/// Where the points behind a point and the edges to and between them lie, as a scan sees them.
struct Behind {
    points: [isize; 3],
    edges: [EdgeSlot; 3],
    bases: [EdgeSlot; 2],
}

impl Behind {
    fn new(chart: Chart, scan: Scan) -> Self {
        use Direction::*;
        let (behind, along) = (directions(scan), if scan.by_rows() { East } else { South });
        Self {
            points: behind.map(|to| chart.offset(to)),
            edges: behind.map(|to| EdgeSlot::new(chart, 0, to)),
            bases: [behind[0], behind[1]]
                .map(|from| EdgeSlot::new(chart, chart.offset(from), along)),
        }
    }
}

fn directions(scan: Scan) -> [Direction; 3] {
    use Direction::*;
    match scan {
        Scan::DOWN => [NorthWest, North, NorthEast],
        Scan::UP => [SouthWest, South, SouthEast],
        Scan::RIGHT => [NorthWest, West, SouthWest],
        _ => [NorthEast, East, SouthEast],
    }
}

/// A stretch of points in a row, what lies behind each of them and the triangles between.
struct Around<'a, R> {
    times: &'a [R],
    behind: [&'a [R]; 3],
    edges: [&'a [R]; 3],
    bases: [&'a [R]; 2],
    curvatures: &'a [R],
    curvatures_behind: [&'a [R]; 3],
}

impl<R: Real> Around<'_, R> {
    /// Part of it, cut so that the compiler sees that all indices are within bounds.
    #[inline(always)]
    fn stretch(&self, start: usize, points: usize, bent: usize) -> Self {
        let start_bent = if bent > 0 { start } else { 0 };
        let Self { behind, edges, bases, curvatures_behind, .. } = self;
        Self {
            times: cut(self.times, start, points),
            behind: [
                cut(behind[0], start, points),
                cut(behind[1], start, points),
                cut(behind[2], start, points),
            ],
            edges: [
                cut(edges[0], start, points),
                cut(edges[1], start, points),
                cut(edges[2], start, points),
            ],
            bases: [cut(bases[0], start, points), cut(bases[1], start, points)],
            curvatures: cut(self.curvatures, start_bent, bent),
            curvatures_behind: [
                cut(curvatures_behind[0], start_bent, bent),
                cut(curvatures_behind[1], start_bent, bent),
                cut(curvatures_behind[2], start_bent, bent),
            ],
        }
    }

    /// Asks for what a look at the next row needs from some point on: the times of the row after that,
    /// since those before it have been needed here.
    #[inline(always)]
    fn prefetch_next(&self, stride: isize, start: usize) {
        let place = stride + start as isize;
        prefetch(self.times, place + stride);
        self.edges.iter().for_each(|edges| prefetch(edges, place));
        prefetch(self.bases[1], place);
        if !self.curvatures.is_empty() {
            prefetch(self.curvatures, place + stride);
        }
    }

    /// The same where edges are not looked at.
    #[inline(always)]
    fn prefetch_next_anchored(&self, plan: &Plan<R>, point: usize, stride: isize, start: usize) {
        let place = stride + start as isize;
        prefetch(self.times, place + stride);
        prefetch(self.curvatures, place + stride);
        prefetch(&plan.holes, stride + point as isize);
    }

    /// Whether nothing behind is earlier than any point.
    #[inline(always)]
    fn leads(&self, points: usize) -> bool {
        let [before, beside, after] = self.behind;
        let mut leads = true;
        for i in 0..points {
            leads &= min(before[i], min(beside[i], after[i])) >= self.times[i];
        }
        leads
    }

    /// Point i, with the curvatures of the fronts behind it.
    #[inline(always)]
    fn visited(&self, i: usize, [before, beside, after]: [R; 3]) -> Visited<R> {
        let Self { behind, edges, bases, .. } = self;
        let (t2, l2) = (behind[1][i], edges[1][i]);
        Visited {
            now: self.times[i],
            triangles: [
                Triangle { t1: behind[0][i], t2, l1: edges[0][i], l2, c: bases[0][i] },
                Triangle { t1: behind[2][i], t2, l1: edges[2][i], l2, c: bases[1][i] },
            ],
            curvatures: [[before, beside], [after, beside]],
        }
    }
}

#[inline(always)]
fn cut<R>(array: &[R], start: usize, points: usize) -> &[R] {
    &array[start..][..points]
}

/// Whether a scan has something to do in the tiles of a row of points: adds it to those that are
/// due there.
struct Look<'a, R> {
    before: Before<'a, R>,
    /// The first point.
    first: usize,
    around: Around<'a, R>,
    /// From here to the next row.
    stride: isize,
    how: How,
    due: &'a mut [u8],
}

impl<R: Real> Work for Look<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { before, first, around, stride, how, due } = self;
        let points = around.times.len();
        for (tile, due) in due.iter_mut().enumerate() {
            match before.plan {
                Some(plan) => {
                    around.prefetch_next_anchored(plan, first + tile * TILE, stride, tile * TILE)
                }
                None => around.prefetch_next(stride, tile * TILE),
            }
            if *due & how.scan.bit() != 0 {
                continue;
            }
            // As updates stretch: the last one overlaps the one before.
            let settled = match points.checked_sub(TILE) {
                Some(last) => {
                    let start = (tile * TILE).min(last);
                    settled(before, first + start, &around, start, TILE, how)
                }
                None => settled(before, first, &around, 0, points, how),
            };
            if !settled {
                *due |= how.scan.bit();
            }
        }
    }
}

/// Whether a scan leaves a stretch of points as they are, of which this is the first.
#[inline(always)]
fn settled<R: Real>(
    before: Before<R>,
    first: usize,
    around: &Around<R>,
    start: usize,
    points: usize,
    how: How,
) -> bool {
    match how.wavefront {
        Wavefront::Curved => settled_curved(around.stretch(start, points, points), points, how),
        Wavefront::Anchored => {
            settled_anchored(before, first, around.stretch(start, points, points), points, how)
        }
        Wavefront::PointSource => {
            settled_straight(around.stretch(start, points, 0), points, Wavefront::PointSource)
        }
        Wavefront::Planar => {
            settled_straight(around.stretch(start, points, 0), points, Wavefront::Planar)
        }
    }
}

#[inline(always)]
fn settled_straight<R: Real>(around: Around<R>, points: usize, wavefront: Wavefront) -> bool {
    if around.leads(points) {
        return true;
    }
    let mut settled = true;
    for i in 0..points {
        settled &= stays(wavefront, around.visited(i, [R::zero(); 3]));
    }
    settled
}

#[inline(always)]
fn settled_curved<R: Real>(around: Around<R>, points: usize, how: How) -> bool {
    let mut renewed = false;
    for i in 0..points {
        renewed |= how.renews & is_from(around.curvatures[i], how.scan.0);
    }
    if renewed | around.leads(points) {
        return !renewed;
    }
    let [before, beside, after] = around.curvatures_behind;
    let mut settled = true;
    for i in 0..points {
        let visited = around.visited(i, [before[i], beside[i], after[i]]);
        settled &= stays(Wavefront::Curved, visited);
    }
    settled
}

/// As far as one anchor serves all that lies behind; where several do, there is something to do.
#[inline(always)]
fn settled_anchored<R: Real>(
    before: Before<R>,
    first: usize,
    around: Around<R>,
    points: usize,
    how: How,
) -> bool {
    let mut renewed = false;
    for i in 0..points {
        renewed |= how.renews & is_from(around.curvatures[i], how.scan.0);
    }
    if renewed | around.leads(points) {
        return !renewed;
    }
    let Some(plan) = before.plan else { return false };
    let (chart, holes) = (before.edges.chart(), &plan.holes[first..][..points]);
    let [behind, beside, after] = around.curvatures_behind;
    let anchor = beside[0];
    let mut is_one = around.behind[1][0] < R::FAR;
    for i in 0..points {
        is_one &= Plan::is_of_one(anchor, [behind[i], beside[i], after[i]], holes[i], how.scan);
    }
    if !is_one {
        return false;
    }
    let at = [first / chart.stride(), first % chart.stride()];
    let known = |x: usize| [before.times[x], before.curvatures[x]];
    let rays = plan.floor.rays(at, how.scan.ahead(), [0, 1], known);
    let mut settled = true;
    for (i, &time) in around.times[..points].iter().enumerate() {
        settled &= !is_shorter(rays.time(i, around.behind[1][i]), time);
    }
    settled
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::WHOLE;
    use crate::cpu::Instructions;

    const DOWN_UP: [Scan; 2] = [Scan::DOWN, Scan::UP];
    const RIGHT_LEFT: [Scan; 2] = [Scan::RIGHT, Scan::LEFT];

    /// The scans that have something to do around a point in the middle, if arrival times and tagged
    /// curvatures of fronts are these.
    fn due(
        wavefront: Wavefront,
        instructions: Instructions,
        times: impl Fn(usize, usize) -> f32,
        curvature: f32,
    ) -> Vec<Scan> {
        let (edges, chart) = plane();
        let mut array = vec![f32::FAR; chart.bordered_points()];
        for (row, col) in (0..chart.points()).map(|index| chart.position(index)) {
            array[chart.bordered(row, col)] = times(row, col);
        }
        let curved = if wavefront == Wavefront::Curved { array.len() } else { 0 };
        let curvatures = vec![curvature; curved];
        let (times, curvatures) = (&array, &curvatures);
        let before = Before { edges: &edges, times, curvatures, plan: None };
        let mut tiles = Tiles::new(chart);
        tiles.touch(MIDDLE[0], MIDDLE[1]);
        let mut found = Vec::new();
        for scans in [DOWN_UP, RIGHT_LEFT] {
            let how = |scan| How { wavefront, scan, renews: true, instructions };
            assert!(before.find_due(&mut tiles, scans.map(how)) > 0);
            let quiet = vec![false; tiles.len()];
            for scan in scans {
                let mut runs = Vec::new();
                let any = tiles.bands(scan).any(|band| {
                    tiles.runs(scan, band, &quiet, &mut runs);
                    !runs.is_empty()
                });
                found.extend(any.then_some(scan));
            }
        }
        found
    }

    /// So large that the tiles around the middle one have no border, along which nothing is settled.
    fn plane() -> (EdgeLengths<f32>, Chart) {
        let chart = Chart { rows: 89, cols: 103 };
        let heights = vec![0.0; chart.points()];
        let spacing = crate::Spacing::square(1.0);
        let surface = crate::Surface::from_heights(chart.rows, chart.cols, heights, spacing);
        (EdgeLengths::new(&surface.unwrap()).unwrap(), chart)
    }

    const MIDDLE: [usize; 2] = [40, 55];

    /// A straight front that runs along a scan.
    fn along(scan: Scan, row: usize, col: usize) -> f32 {
        100.0
            + match scan {
                Scan::DOWN => row as f32,
                Scan::UP => -(row as f32),
                Scan::RIGHT => col as f32,
                _ => -(col as f32),
            }
    }

    /// What a scan brings itself is not settled in it.
    #[test]
    fn scans_have_something_to_do_where_their_fronts_would_come_earlier() {
        for wavefront in Wavefront::ALL {
            for instructions in Instructions::available() {
                let found = |scan, late| {
                    let times = |row, col| {
                        along(scan, row, col) + if [row, col] == MIDDLE { late } else { 0.0 }
                    };
                    due(wavefront, instructions, times, 0.0)
                };
                let [vertical, horizontal] = [DOWN_UP, RIGHT_LEFT];
                for (scans, across) in [(vertical, horizontal), (horizontal, vertical)] {
                    for scan in scans {
                        assert_eq!(found(scan, 0.0), [scan], "{wavefront} {instructions}");
                        // Along a diagonal the front comes 0.4 after it should have.
                        assert_eq!(found(scan, 0.3), [scan], "{wavefront} {instructions}");
                        let mut three = found(scan, 0.6);
                        three.retain(|found| !across.contains(found));
                        assert_eq!(three, [scan], "{wavefront} {instructions}");
                        assert_eq!(found(scan, 0.6).len(), 3, "{wavefront} {instructions}");
                    }
                }
            }
        }
    }

    #[test]
    fn fronts_that_a_scan_has_brought_are_due_in_it_to_be_renewed() {
        for scan in [DOWN_UP, RIGHT_LEFT].concat() {
            let down = |row, col| along(Scan::DOWN, row, col);
            for tag in [scan.0, scan.0 | WHOLE as u8] {
                let brought = 0.0f32.with_tag(tag);
                let found = due(Wavefront::Curved, Instructions::best(), down, brought);
                let expected = 1 + usize::from(scan != Scan::DOWN);
                assert!(found.contains(&scan) && found.len() == expected, "{tag}");
            }
        }
    }
}
