//! Estimates the fraction of a surface that a limited map reaches, before its edges are measured.
//!
//! The estimate only serves the choice of the engine ([`crate::auto`]). It measures a typical edge at sample points of
//! the grid, and assumes that fronts are ellipses of grid points around the sources. It ignores holes and seams.

use std::f64::consts::PI;

use crate::Targets;
use crate::surface::{Direction, Seed, Surface};

/// Number of sample points along rows and along columns at which edges are measured.
const PLACES: usize = 32;
/// Largest number of seeds that are compared with targets.
const SEEDS: usize = 256;

/// Returns the share of the surface's points that fronts of `seeds` reach within `time`, or before the targets are
/// reached. It is 1 without a limit, and where no edge was found.
pub(crate) fn share(
    surface: &Surface,
    seeds: &[Seed],
    time: f64,
    targets: Option<&Targets>,
) -> f64 {
    if targets.is_none() && !time.is_finite() {
        return 1.0;
    }
    let (Some(of_row), Some(of_col)) =
        (typical(surface, Direction::South), typical(surface, Direction::East))
    else {
        return 1.0;
    };
    let some = || seeds.iter().step_by(seeds.len().div_ceil(SEEDS).max(1));
    let to_target = |[row, col]: [usize; 2]| {
        let from = |seed: &Seed| {
            let (rows, cols) = (seed.row.abs_diff(row) as f64, seed.col.abs_diff(col) as f64);
            seed.time + (of_row * rows).hypot(of_col * cols)
        };
        some().map(from).fold(f64::INFINITY, f64::min)
    };
    let time = targets.map_or(time, |targets| time.min(targets.last(to_target)));
    if !time.is_finite() {
        return 1.0;
    }
    let (rows, cols) = (time.max(0.0) / of_row, time.max(0.0) / of_col);
    let discs = seeds.len() as f64 * PI * rows * cols;
    let lines = |place: fn(&Seed) -> usize, reach: f64, points: usize| {
        let places = || seeds.iter().map(place);
        let [first, last] = [places().min(), places().max()].map(|at| at.unwrap_or(0) as f64);
        let (from, to) = ((first - reach).max(0.0), (last + reach).min(points as f64 - 1.0));
        to - from + 1.0
    };
    let around =
        lines(|seed| seed.row, rows, surface.rows()) * lines(|seed| seed.col, cols, surface.cols());
    (discs.max(1.0).min(around) / surface.chart().points() as f64).min(1.0)
}

/// Returns the mean time along edges in a direction, if there are any.
fn typical(surface: &Surface, to: Direction) -> Option<f64> {
    let chart = surface.chart();
    let place = |k: usize, points: usize| points * (2 * k + 1) / (2 * PLACES);
    let slowness = |(row, col)| surface.slowness().map_or(1.0, |all| all[chart.index(row, col)]);
    let edge = |k: usize| {
        let from = (place(k / PLACES, chart.rows), place(k % PLACES, chart.cols));
        let next = chart.neighbour(from.0, from.1, to)?;
        let is_there = surface.has_edge(from.0, from.1, to);
        let mean = 0.5 * (slowness(from) + slowness(next));
        is_there.then(|| mean * surface.length_on_surface(from, next))
    };
    let (sum, count) = (0..PLACES * PLACES)
        .filter_map(edge)
        .filter(|time| time.is_finite() && *time > 0.0)
        .fold((0.0, 0), |(sum, count), time| (sum + time, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Sources, Spacing};

    /// Returns the estimate on a plane of 200 x 300 points, with rows 2 apart and columns 1 apart.
    fn of(sources: &Sources, time: f64, targets: Option<Targets>, slowness: f64) -> f64 {
        let spacing = Spacing { dx: 1.0, dy: 2.0 };
        let plane = Surface::from_heights(200, 300, vec![0.0; 60_000], spacing).unwrap();
        let plane = plane.with_slowness(vec![slowness; 60_000]).unwrap();
        let seeds = sources.seeds(&plane).unwrap();
        share(&plane, &seeds, time, targets.as_ref())
    }

    #[test]
    fn a_disc_has_the_share_of_its_area() {
        let point = Sources::point(100.0, 150.0);
        for (radius, slowness) in [(20.0, 1.0), (50.0, 2.5)] {
            let found = of(&point, radius, None, slowness);
            let exact = PI * (radius / slowness).powi(2) / 2.0 / 60_000.0;
            assert!((found / exact - 1.0).abs() < 1e-9, "{found} {exact}");
        }
        assert_eq!(of(&point, f64::INFINITY, None, 1.0), 1.0);
        assert_eq!(of(&point, 1e4, None, 1.0), 1.0);
    }

    #[test]
    fn targets_count_as_the_radius_that_they_need() {
        let point = Sources::point(100.0, 150.0);
        let targets = Targets::all([[110, 150], [100, 140]]);
        let found = of(&point, f64::INFINITY, Some(targets.clone()), 1.0);
        assert_eq!(found, of(&point, 20.0, None, 1.0));
        assert_eq!(of(&point, 5.0, Some(targets), 1.0), of(&point, 5.0, None, 1.0));
        let nearest = Targets::any([[110, 150], [100, 140]]);
        let found = of(&point, f64::INFINITY, Some(nearest), 1.0);
        assert_eq!(found, of(&point, 10.0, None, 1.0));
    }

    #[test]
    fn many_seeds_side_by_side_count_once() {
        let curve = Sources::curve([[100.0, 0.0], [100.0, 299.0]]);
        let found = of(&curve, 20.0, None, 1.0);
        // The front reaches ten rows on each side of the curve, whose seeds lie in two rows of points at
        // most.
        assert!((0.1..0.12).contains(&found), "{found}");
    }
}
