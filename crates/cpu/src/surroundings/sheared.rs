//! Adds seeds around sources inside sheared cells, for fronts that carry their ray.
//!
//! Between the corners of a sheared cell, rays of a source inside the cell cross bases whose ends no ray has reached
//! yet. The points one step around the cell are close enough to the source for straight lines.

use std::collections::BTreeMap;

use glam::DVec2;

use geosweep_surface::{Heading, Seed, Surface};

/// Largest cosine of the angle between the sides of a cell that is not sheared.
const SHEARED: f64 = 0.1;

/// Returns the seeds with those at the points around sheared cells with a source. Each point has its earliest seed.
pub(super) fn around_sheared_cells(surface: &Surface, seeds: Vec<Seed>) -> Vec<Seed> {
    let mut sources = BTreeMap::new();
    for seed in &seeds {
        if let Some(from) = seed.from {
            sources.entry(from.to_array().map(f64::to_bits)).or_insert((from, *seed));
        }
    }
    let further: Vec<_> = sources
        .into_values()
        .flat_map(|(from, seed)| around(surface, from, seed).unwrap_or_default())
        .collect();
    if further.is_empty() { seeds } else { Seed::earliest(seeds.into_iter().chain(further)) }
}

/// Returns the seeds around the cell of a source, of which one seed is known. Returns `None` if the cell is not sheared,
/// or if one of the points is missing.
fn around(surface: &Surface, from: DVec2, known: Seed) -> Option<Vec<Seed>> {
    let start = known.origin?.start;
    let [rows, cols] = from.to_array().map(|at| [at.floor() as usize, at.ceil() as usize]);
    let place = |row: usize, col: usize| surface.place(DVec2::new(row as f64, col as f64));
    let length =
        |a: [usize; 2], b: [usize; 2]| Some(place(a[0], a[1])?.length_to(place(b[0], b[1])?));
    let [below, right] = [rows[0] + 1, cols[0] + 1];
    let falling = length([rows[0], cols[0]], [below, right])?;
    let rising = length([rows[0], right], [below, cols[0]])?;
    let across = length([rows[0], cols[0]], [rows[0], right])?;
    let along = length([rows[0], cols[0]], [below, cols[0]])?;
    let cosine = (falling * falling - rising * rising) / (4.0 * across * along);
    if cosine.is_nan() || cosine.abs() <= SHEARED {
        return None;
    }
    let source = surface.place(from)?;
    // The edges may be measured along the surface, and weighted by a slowness.
    let scale = (known.time - start) / place(known.row, known.col)?.length_to(source);
    let block = surface.chart().around_span(rows, cols, [1, 1]);
    let is_whole =
        block.rows.len() == rows[1] - rows[0] + 3 && block.cols.len() == cols[1] - cols[0] + 3;
    let seed = |(row, col): (usize, usize)| {
        let away = place(row, col)?.length_to(source) * scale;
        let step = DVec2::new(row as f64, col as f64) - from;
        let is_there = surface.has(row, col) && away > 0.0;
        is_there.then_some(Seed {
            row,
            col,
            time: start + away,
            curvature: 1.0 / away,
            heading: Heading::Along(step),
            from: Some(from),
            ..known
        })
    };
    if is_whole { block.places().map(seed).collect() } else { None }
}
