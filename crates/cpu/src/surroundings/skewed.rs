//! Adds seeds around sources inside sheared and skewed cells, and around all sources inside cells over a slowness.
//!
//! Between the corners of such a cell, rays of a source inside it cross bases whose ends no ray has reached yet. Over a
//! slowness, fronts do not know a source that lies close to the base which its rays cross. The points around the cell,
//! as far away as those that split obtuse triangles, are close enough to the source for straight lines of the chart. The
//! length of any line is an upper bound of the distance, so no seed is early.

use std::cell::LazyCell;
use std::collections::BTreeMap;

use glam::DVec2;

use super::straight::Holes;
use geosweep_surface::{Heading, Seed, Surface, grid_crossings};

/// Largest cosine of the angle between the sides of a cell that is not sheared.
const SHEARED: f64 = 0.1;
/// Number of pieces of a line per row or column, whose lengths are added up.
const PIECES: f64 = 4.0;

/// Returns the seeds with those around sources inside such cells. Each point has its earliest seed.
pub(super) fn around_skewed_cells(surface: &Surface, seeds: Vec<Seed>) -> Vec<Seed> {
    let is_slowed = surface.is_slowed_unevenly();
    let mut sources = BTreeMap::new();
    for seed in seeds.iter().filter(|seed| seed.origin.is_some_and(|origin| origin.is_point())) {
        if let Some(from) = seed.from {
            sources.entry(from.to_array().map(f64::to_bits)).or_insert((from, *seed));
        }
    }
    // Most sources lie in cells that need no lines.
    let holes = LazyCell::new(|| Holes::of(surface));
    let around = |(from, seed)| {
        let skew = if surface.is_glued() { 1 } else { surface.skew_around(from) };
        if skew == 1 && !is_slowed && !is_sheared(surface, from) {
            return Vec::new();
        }
        on_lines(surface, holes.as_ref(), from, seed, skew)
    };
    let further: Vec<_> = sources.into_values().flat_map(around).collect();
    if further.is_empty() { seeds } else { Seed::earliest(seeds.into_iter().chain(further)) }
}

/// Returns whether the sides of a place's cell are not at a right angle.
pub(super) fn is_sheared(surface: &Surface, from: DVec2) -> bool {
    let [row, col] = from.floor().to_array();
    let corner = |down: f64, right: f64| surface.place(DVec2::new(row + down, col + right));
    let corners = [corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 0.0), corner(1.0, 1.0)];
    let [Some(a), Some(b), Some(c), Some(d)] = corners else { return false };
    let (falling, rising) = (a.length_to(d), b.length_to(c));
    let cosine = (falling * falling - rising * rising) / (4.0 * a.length_to(b) * a.length_to(c));
    cosine.abs() > SHEARED
}

/// Returns seeds at the points at most `reach` rows and columns away from the cell of a source, of which one seed is
/// known. They hold the distances along straight lines of the chart on which no point is missing.
fn on_lines(
    surface: &Surface,
    holes: Option<&Holes>,
    from: DVec2,
    known: Seed,
    reach: usize,
) -> Vec<Seed> {
    let Some(start) = known.origin.map(|origin| origin.start) else { return Vec::new() };
    let length = |to: DVec2| {
        let part = |ends: &[f64]| {
            let [from, to] = [ends[0], ends[1]].map(|share| from.lerp(to, share));
            let pieces = ((to - from).abs().max_element() * PIECES).ceil() as usize;
            surface.cost_in_cell(from, to, pieces)
        };
        grid_crossings(from, to).windows(2).map(part).sum()
    };
    // The edges may be measured along the surface.
    let Some(known_length): Option<f64> = length(known.place()) else { return Vec::new() };
    let scale = if surface.is_scaled() { 1.0 } else { (known.time - start) / known_length };
    let seed = |(row, col): (usize, usize)| {
        let step = DVec2::new(row as f64, col as f64) - from;
        let is_free = surface.has(row, col)
            && holes.is_none_or(|holes| !holes.are_between(from + step, from));
        let away = if is_free { length(from + step)? * scale } else { return None };
        (away > 0.0).then_some(Seed {
            row,
            col,
            time: start + away,
            curvature: 1.0 / away,
            heading: Heading::Along(step),
            from: Some(from),
            ..known
        })
    };
    surface.chart().around_place(from, reach).places().filter_map(seed).collect()
}
