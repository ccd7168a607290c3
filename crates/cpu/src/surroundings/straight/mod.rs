//! Finds shortest paths as straight lines of the chart, over surfaces whose cells are all alike.
//!
//! Even grids in the plane, on cylinders, cones and flat tori, and constant metrics have one metric everywhere. Where no
//! hole is in between, the arrival time of a front is then the length of a line. Maps of several sources, maps over
//! seams, and regions take their times from there: no front need be told apart from others. A lone source on an open
//! surface is solved by scans, unless its cells are sheared.

mod fronts;
mod holes;
mod images;
mod lines;

use std::collections::BTreeMap;

use glam::DVec2;

pub use fronts::{FirstArrival, StraightFronts};
pub(super) use holes::Holes;

use super::NEAR;
use super::skewed::is_sheared;
use geosweep_surface::{Origin, Seed, Source, Surface};

/// Returns the points and segments of a source.
#[doc(hidden)]
pub fn straight_parts(surface: &Surface, source: &Source) -> Vec<Origin> {
    match source {
        Source::Point { at, initial } => vec![Origin::point(*at, *initial)],
        Source::Curve { vertices, initial } => {
            let alone = vertices.iter().take(1).map(|at| Origin::point(*at, *initial));
            // The curve jumps over a seam between two copies of a place.
            let segments = vertices
                .windows(2)
                .filter(|ends| !surface.are_copies(ends[0], ends[1]))
                .map(|ends| Origin { ends: [ends[0], ends[1]], start: *initial });
            alone.chain(segments).collect()
        }
    }
}

/// Returns the fronts of sources along straight lines, if maps need these fronts and cells are all alike.
#[doc(hidden)]
pub fn needed_straight_fronts(
    surface: &Surface,
    sources: &[Vec<Origin>],
) -> Option<StraightFronts> {
    are_needed(surface, sources).then(|| StraightFronts::new(surface, sources)).flatten()
}

/// Returns the fronts of the sources of seeds as [`needed_straight_fronts`] does, if these are known for all seeds.
pub(super) fn fronts_of_seeds(surface: &Surface, seeds: &[Seed]) -> Option<StraightFronts> {
    let are_known = seeds.iter().all(|seed| seed.origin.is_some());
    let sources: Vec<_> = origins(seeds).into_iter().map(|origin| vec![origin]).collect();
    are_known.then(|| needed_straight_fronts(surface, &sources)).flatten()
}

/// Returns the origins that seeds come from.
pub(super) fn origins(seeds: &[Seed]) -> Vec<Origin> {
    let all = seeds.iter().filter_map(|seed| seed.origin).map(|origin| (origin.key(), origin));
    all.collect::<BTreeMap<_, _>>().into_values().collect()
}

/// Returns whether fronts meet that updates would have to tell apart, or a lone source lies in a sheared cell. In skewed
/// cells only straight lines lead to points whose triangles are split by points beyond the border, and from inside a
/// sheared cell only they lead between points that no ray has reached yet.
fn are_needed(surface: &Surface, sources: &[Vec<Origin>]) -> bool {
    let mut all = sources.iter().flatten();
    let (Some(first), None) = (all.next(), all.next()) else { return true };
    let at = first.ends[0];
    let is_inside = at.fract() != DVec2::ZERO;
    !first.is_point()
        || surface.is_glued()
        || surface.skew_around(at) > if is_inside { 1 } else { NEAR }
        || is_inside && is_sheared(surface, at)
}
