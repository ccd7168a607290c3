//! Solves the surroundings of sources inside cells, and of sources that have others near them, before the
//! whole grid. The twin of `glsl/passes/surroundings.comp` and `glsl/passes/merge_surroundings.comp`.

use std::ops::Range;

use glam::DVec2;

use super::behind;
use super::chart_lines::along_lines;
use crate::Solution;
use crate::fronts::{PointKind, for_kind};
use crate::points::PointFronts;
use geosweep_surface::constants::{SURROUNDINGS_STEPS, SURROUNDINGS_TEXELS};
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Block, Chart, EdgeLengths, Real, Seed};

/// A point source, as a renderer gives it.
#[derive(Clone, Debug)]
pub struct CentralSource {
    /// Row and column.
    pub at: DVec2,
    /// Arrival time at the source.
    pub start: f64,
    /// The grid points at which its front begins.
    pub seeds: Vec<Seed>,
}

/// Returns the seeds of point sources and the fronts in their surroundings. Where surroundings meet, the
/// earliest fronts are taken. The solution has no iterations. It is not a complete map, except on a grid that
/// is no larger than the surroundings.
pub fn surroundings<R: Real>(
    edges: &EdgeLengths<R>,
    sources: &[CentralSource],
    wavefront: Wavefront,
) -> Solution<R> {
    for_kind!(edges, wavefront, kind => solve(edges, kind, sources, wavefront.is_curved()))
}

fn solve<R: Real, K: PointKind<R>>(
    edges: &EdgeLengths<R>,
    kind: K,
    sources: &[CentralSource],
    is_curved: bool,
) -> Solution<R> {
    let unreached = PointFronts::start(edges, kind.clone(), &[]);
    let seeds: Vec<_> = sources.iter().flat_map(|source| &source.seeds).copied().collect();
    let start = PointFronts::start(edges, kind.clone(), &seeds);
    let chart = edges.chart();
    let scans = behind(chart);
    let first = sources.iter().map(|source| source.start).fold(f64::INFINITY, f64::min);
    let mut fronts = start.clone();
    let mut merged = unreached.clone();
    let mut is_exact = vec![false; chart.bordered_points()];
    for source in sources {
        let is_near = |other: &CentralSource| {
            let apart = (other.at - source.at).abs().max_element();
            apart > 0.0 && apart <= f64::from(SURROUNDINGS_TEXELS)
        };
        let is_crowded = is_curved && sources.iter().any(is_near);
        if !is_crowded && source.at.fract() == DVec2::ZERO {
            continue;
        }
        let window = Window::around(source.at, chart);
        let points = || window.places().map(|(row, col)| chart.bordered(row, col));
        // Points around the window stay unreached: scans of the whole grid find the paths outside the window later.
        let mut old = unreached.clone();
        let begin = match is_crowded {
            true => PointFronts::start(edges, kind.clone(), &source.seeds),
            false => start.clone(),
        };
        points().for_each(|point| old.copy_point(&begin, point));
        let block = Block { rows: window.rows.clone(), cols: window.cols.clone() };
        let lines = PointFronts::start(edges, kind.clone(), &along_lines(edges, source, &block));
        for point in points().filter(|&point| lines.time(point) < begin.time(point)) {
            old.copy_point(&lines, point);
        }
        for _ in 0..SURROUNDINGS_STEPS {
            let mut new = old.clone();
            let mut change = R::Bits::default();
            for point in points() {
                for (behind, scan) in scans.iter().zip(1..) {
                    new.accept(point, old.reach(point, behind), scan, true);
                }
                change = change.max(new.change_from(&old, point));
            }
            old = new;
            if change == R::Bits::default() {
                break;
            }
        }
        let until = if is_crowded { window.exact_until(&old, source.start, first) } else { R::FAR };
        for point in points() {
            if old.time(point) < merged.time(point) {
                merged.copy_point(&old, point);
                is_exact[point] = old.time(point) <= until;
            }
        }
    }
    // If the earliest front is not exact, a later front of another source is not exact either.
    for (point, _) in is_exact.iter().enumerate().filter(|(_, is)| **is) {
        if merged.time(point) < fronts.time(point) {
            fronts.copy_point(&merged, point);
        }
    }
    fronts.finish(0, 0.0)
}

/// The points of the texels around a source's cell. The window extends equally far to both sides of the cell,
/// which lies in one or two texels.
struct Window {
    rows: Range<usize>,
    cols: Range<usize>,
    chart: Chart,
}

impl Window {
    fn around(source: DVec2, chart: Chart) -> Self {
        let side = SURROUNDINGS_TEXELS as usize;
        let span = |at: f64, points: usize| {
            let end = 2 * (at as usize / 2 + side / 2 + 1);
            end.saturating_sub(2 * side)..end.min(points)
        };
        Self { rows: span(source.x, chart.rows), cols: span(source.y, chart.cols), chart }
    }

    fn places(&self) -> impl Iterator<Item = (usize, usize)> {
        self.rows.clone().flat_map(|row| self.cols.clone().map(move |col| (row, col)))
    }

    /// Returns the time up to which no other source's front can be first. `first` is the start time of the earliest
    /// source.
    fn exact_until<R: Real, K: PointKind<R>>(
        &self,
        alone: &PointFronts<R, K>,
        start: f64,
        first: f64,
    ) -> R {
        let is_glued = alone.edges.copies().is_some();
        // Returns whether the grid continues beyond a texel at the side of the window, or fronts may leave through a
        // side of the grid there.
        let leaves = |span: &Range<usize>, at: usize, all: usize| {
            let is_at_side = [0, (all - 1) / 2].contains(&(at / 2));
            at < span.start + 2 && span.start > 0
                || at + 2 >= span.end && span.end < all
                || is_glued && is_at_side
        };
        let is_at_way_out = |&(row, col): &(usize, usize)| {
            leaves(&self.rows, row, self.chart.rows) || leaves(&self.cols, col, self.chart.cols)
        };
        let times = self.places().filter(is_at_way_out);
        let times = times.map(|(row, col)| alone.time(self.chart.bordered(row, col)).wide());
        let leaves = times.fold(f64::INFINITY, f64::min);
        let until = leaves.max(start);
        if until < R::FAR.wide() { R::of(0.5 * (until + first)) } else { R::FAR }
    }
}
