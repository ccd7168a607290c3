//! What sources inside cells reach first, solved before the whole grid. The twin of
//! `glsl/surroundings.comp`.

use glam::DVec2;

use super::behind;
use crate::constants::{SURROUNDINGS_STEPS, SURROUNDINGS_TEXELS};
use crate::cpu::Solution;
use crate::cpu::fronts::{FrontKind, for_kind};
use crate::cpu::point_fronts::PointFronts;
use crate::surface::{EdgeLengths, Real, Seed};
use crate::update::Wavefront;

/// The seeds of sources at these rows and columns and what their surroundings make of them; where these
/// meet, a texel's fronts are those of the first source that has it. The solution has no iterations and is
/// no map yet, but on a grid that is not larger.
pub fn surroundings<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    sources: &[DVec2],
    wavefront: Wavefront,
) -> Solution<R> {
    for_kind!(edges, wavefront, kind => solve(edges, kind, seeds, sources))
}

fn solve<'a, R: Real, K: FrontKind<'a, R>>(
    edges: &'a EdgeLengths<R>,
    kind: K,
    seeds: &[Seed],
    sources: &[DVec2],
) -> Solution<R> {
    let unreached = PointFronts::start(edges, kind.clone(), &[]);
    let start = PointFronts::start(edges, kind, seeds);
    let chart = start.edges.chart();
    let scans = behind(chart);
    let mut fronts = start.clone();
    let mut taken = vec![false; chart.bordered_points()];
    for source in sources.iter().filter(|source| source.fract() != DVec2::ZERO) {
        // Texels, of which the cell has one or two: so many lie before.
        let side = SURROUNDINGS_TEXELS as usize;
        let span = |at: f64, points: usize| {
            let end = 2 * (at as usize / 2 + side / 2 + 1);
            end.saturating_sub(2 * side)..end.min(points)
        };
        let (rows, cols) = (span(source.x, chart.rows), span(source.y, chart.cols));
        let all = || rows.clone().flat_map(|row| cols.clone().map(move |col| (row, col)));
        let points = || all().map(|(row, col)| chart.bordered(row, col));
        // What lies around stays unreached: ways outside are for the scans to find.
        let mut old = unreached.clone();
        points().for_each(|point| old.copy_point(&start, point));
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
        for point in points() {
            if !std::mem::replace(&mut taken[point], true) && old.time(point) < start.time(point) {
                fronts.copy_point(&old, point);
            }
        }
    }
    fronts.finish(0, 0.0)
}
