//! Adds seeds along straight lines from their origins, on surfaces whose cells are all alike.
//!
//! A grid point has one seed, that of the first front. Where several sources lie within a few cells, the region in
//! which one of them is first may be too narrow near that source to contain a grid point. Its front would be lost,
//! though its region widens further away. Cells that are alike have one metric. If no hole is in between, a front's
//! time is the distance along a straight line of the chart. So all points within a few cells of crowded sources become
//! seeds.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use glam::DVec2;

use super::around::Surroundings;
use geosweep_surface::{Direction, EdgeLengths, Origin, Real, Seed, Surface};

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
    let is_whole = surface.present().iter().all(|&is| is);
    let mut found = Vec::new();
    for origin in &origins {
        for at in origin.ends {
            let near: Vec<_> =
                origins.iter().filter(|other| nearest(other, at).1 <= REACH as f64).collect();
            let Some(surface_data) = SurfaceData::around(surface, at).filter(|_| near.len() > 1)
            else {
                continue;
            };
            for place in surface_data.places(surface) {
                let first = near.iter().filter_map(|origin| {
                    let (foot, seed) = surface_data.seed(origin, place);
                    let is_free = is_whole || has_no_hole(surface, place, foot);
                    is_free.then_some(seed)
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

/// Returns whether all grid points around the straight line between two points exist.
pub(super) fn has_no_hole(surface: &Surface, (row, col): (usize, usize), to: DVec2) -> bool {
    let span = |at: usize, to: f64| -> RangeInclusive<usize> {
        at.min(to.floor() as usize)..=at.max(to.ceil() as usize)
    };
    span(row, to.x).all(|row| span(col, to.y).all(|col| surface.has(row, col)))
}

/// The surface around a place.
struct SurfaceData {
    at: DVec2,
    /// The first fundamental form, including slowness: the entries for rows, for both, and for columns.
    metric: [f64; 3],
}

impl SurfaceData {
    fn around(surface: &Surface, at: DVec2) -> Option<Self> {
        let around = Surroundings::new(surface, at, [1, 1]);
        let metric = metric(around.edges()?);
        Some(Self { at, metric })
    }

    fn places(&self, surface: &Surface) -> Vec<(usize, usize)> {
        let [rows, cols] = self.at.to_array().map(|at| [at as usize, at.ceil() as usize]);
        let block = surface.chart().around_span(rows, cols, [REACH; 2]);
        block.places().filter(|&(row, col)| surface.has(row, col)).collect()
    }

    fn dot(&self, a: DVec2, b: DVec2) -> f64 {
        let [rr, rc, cc] = self.metric;
        a.x * (rr * b.x + rc * b.y) + a.y * (rc * b.x + cc * b.y)
    }

    /// Returns the point of an origin from which a front reaches a grid point along a straight line, and the seed at
    /// the grid point.
    fn seed(&self, origin: &Origin, (row, col): (usize, usize)) -> (DVec2, Seed) {
        let at = DVec2::new(row as f64, col as f64);
        let [a, b] = origin.ends;
        let along = b - a;
        let square = self.dot(along, along);
        let share = if square > 0.0 { self.dot(at - a, along) / square } else { 0.0 };
        let foot = a + share.clamp(0.0, 1.0) * along;
        let distance = self.dot(at - foot, at - foot).max(0.0).sqrt();
        let is_beside = square > 0.0 && (0.0..=1.0).contains(&share) && distance > 0.0;
        let curvature = match (is_beside, distance > 0.0) {
            (true, _) => 0.0,
            (false, true) => (1.0 / distance).min(Seed::AT_SOURCE),
            (false, false) => Seed::AT_SOURCE,
        };
        let from = (origin.is_point() && distance > 0.0).then_some(a);
        let time = origin.start + distance;
        let origin = Some(*origin);
        (
            foot,
            Seed {
                row,
                col,
                time,
                curvature,
                from,
                origin,
                exact: false,
                heading: geosweep_surface::Heading::Everywhere,
                source: 0,
            },
        )
    }
}

/// Returns the metric of cells that are all alike, from the lengths of edges in the middle of a part of the
/// surface. It is 1 in directions that have no edges. The middle is used since arcs at the sides of the part differ
/// from those of the whole surface.
fn metric<R: Real>(edges: &EdgeLengths<R>) -> [f64; 3] {
    let chart = edges.chart();
    let from_middle = |&(row, col): &(usize, usize)| {
        (2 * row).abs_diff(chart.rows - 1).max((2 * col).abs_diff(chart.cols - 1))
    };
    let mut places: Vec<_> = chart.places().collect();
    places.sort_by_key(from_middle);
    let length = |to: Direction| {
        let mut all = places.iter().map(|&(row, col)| edges.length(row, col, to));
        all.find(|length| *length < R::FAR).map(R::wide)
    };
    let square = |to| length(to).map(|length| length * length);
    let (rr, cc) =
        (square(Direction::South).unwrap_or(1.0), square(Direction::East).unwrap_or(1.0));
    let falling = square(Direction::SouthEast).map(|square| 0.5 * (square - rr - cc));
    let rising = square(Direction::SouthWest).map(|square| 0.5 * (rr + cc - square));
    [rr, falling.or(rising).unwrap_or(0.0), cc]
}
