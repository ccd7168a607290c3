//! Adds seeds along straight lines from their origins, on surfaces whose cells are all alike.
//!
//! A grid point has one seed, that of the first front. Where several sources lie within a few cells, the region in
//! which one of them is first may be too narrow near that source to contain a grid point. Its front would be lost,
//! though its region widens further away. Cells that are alike have one metric. If no hole is in between, a front's
//! time is the distance along a straight line of the chart. So all points within a few cells of crowded sources become
//! seeds.

use std::cell::LazyCell;
use std::collections::BTreeMap;

use glam::DVec2;

use super::holes::Holes;
use super::straight_lines::StraightLines;
use geosweep_surface::{Heading, Origin, Seed, Surface};

/// Reach of such seeds around crowded sources, in rows and columns.
const REACH: usize = 6;
/// Maximum number of sources. With more sources, no such seeds are added.
const MOST_ORIGINS: usize = 1000;

/// Returns seeds around those ends of straight sources that have another source near.
pub(crate) fn along_sight_lines(surface: &Surface, seeds: &[Seed]) -> Vec<Seed> {
    let origins = origins(seeds);
    if !(2..=MOST_ORIGINS).contains(&origins.len()) {
        return Vec::new();
    }
    let holes = LazyCell::new(|| Holes::of(surface));
    let mut found = Vec::new();
    for origin in &origins {
        for at in origin.ends {
            let near: Vec<_> =
                origins.iter().filter(|other| nearest(other, at).1 <= REACH as f64).collect();
            let Some(lines) = StraightLines::around(surface, at).filter(|_| near.len() > 1) else {
                continue;
            };
            for place in places(surface, at) {
                let first = near.iter().filter_map(|origin| {
                    let (foot, seed) = seed(&lines, origin, place);
                    let is_free = |holes: &Holes| !holes.are_between(seed.place(), foot);
                    holes.as_ref().is_none_or(is_free).then_some(seed)
                });
                found.extend(first.min_by(|a, b| a.time.total_cmp(&b.time)));
            }
        }
    }
    Seed::earliest(found)
}

/// Returns the origins that seeds come from.
pub(super) fn origins(seeds: &[Seed]) -> Vec<Origin> {
    let all = seeds.iter().filter_map(|seed| seed.origin).map(|origin| (origin.key(), origin));
    all.collect::<BTreeMap<_, _>>().into_values().collect()
}

/// Returns the point of a source that is nearest to `at`, measured in rows and columns, and the larger of the distances
/// in rows and in columns.
fn nearest(origin: &Origin, at: DVec2) -> (DVec2, f64) {
    let [a, b] = origin.ends;
    let along = b - a;
    let square = along.length_squared();
    let foot = if square > 0.0 { ((at - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    let place = a + foot * along;
    (place, (at - place).abs().max_element())
}

/// Returns the points around a place.
fn places(surface: &Surface, at: DVec2) -> Vec<(usize, usize)> {
    let [rows, cols] = at.to_array().map(|at| [at as usize, at.ceil() as usize]);
    let block = surface.chart().around_span(rows, cols, [REACH; 2]);
    block.places().filter(|&(row, col)| surface.has(row, col)).collect()
}

/// Returns the point of an origin from which a front reaches a grid point along a straight line, and the seed at the grid
/// point.
fn seed(lines: &StraightLines, origin: &Origin, (row, col): (usize, usize)) -> (DVec2, Seed) {
    let line = lines.from(origin, DVec2::new(row as f64, col as f64));
    let distance = line.length;
    let curvature = match (line.is_beside && distance > 0.0, distance > 0.0) {
        (true, _) => 0.0,
        (false, true) => (1.0 / distance).min(Seed::AT_SOURCE),
        (false, false) => Seed::AT_SOURCE,
    };
    let seed = Seed {
        row,
        col,
        time: origin.start + distance,
        curvature,
        from: (origin.is_point() && distance > 0.0).then_some(origin.ends[0]),
        origin: Some(*origin),
        exact: false,
        heading: Heading::Everywhere,
        source: 0,
    };
    (line.foot, seed)
}
