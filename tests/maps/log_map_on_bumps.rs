//! Log maps on a surface of bumps, compared with geodesics that are shot from the source.

use geosweep::geometry::LogMap;
use geosweep::glam::{DMat2, DVec2};
use geosweep::{Sources, Spacing, Surface};

const SIDE: usize = 129;
const STEP: f64 = 1.0 / (SIDE - 1) as f64;

/// Place (x, y), height and width of each bump over the unit square.
const BUMPS: [([f64; 2], f64, f64); 5] = [
    ([0.30, 0.35], 0.05, 0.12),
    ([0.72, 0.28], -0.06, 0.15),
    ([0.65, 0.75], 0.07, 0.18),
    ([0.22, 0.80], -0.04, 0.12),
    ([0.48, 0.55], 0.03, 0.15),
];

/// Returns the height, the slope and the second derivatives of the bumps at a place.
fn bumps(at: DVec2) -> (f64, DVec2, DMat2) {
    BUMPS.iter().fold(
        (0.0, DVec2::ZERO, DMat2::ZERO),
        |(height, slope, bend), &(middle, rise, width)| {
            let away = (at - DVec2::from(middle)) / width;
            let value = rise * (-0.5 * away.length_squared()).exp();
            let outer = DMat2::from_cols(away.x * away, away.y * away);
            (
                height + value,
                slope - value / width * away,
                bend + (outer - DMat2::IDENTITY) * (value / (width * width)),
            )
        },
    )
}

/// Returns the place that a geodesic from `from`, with this velocity in the chart, reaches at time 1. It is computed by
/// the classical Runge-Kutta method.
fn shot(from: DVec2, velocity: DVec2) -> DVec2 {
    const STEPS: usize = 256;
    // The geodesic equation of a height field: the acceleration in the chart is parallel to the slope.
    let change = |[at, by]: [DVec2; 2]| {
        let (_, slope, bend) = bumps(at);
        [by, -slope * (by.dot(bend * by) / (1.0 + slope.length_squared()))]
    };
    let plus = |a: [DVec2; 2], by: f64, b: [DVec2; 2]| [a[0] + by * b[0], a[1] + by * b[1]];
    let dt = 1.0 / STEPS as f64;
    let step = |state, _| {
        let first = change(state);
        let second = change(plus(state, 0.5 * dt, first));
        let third = change(plus(state, 0.5 * dt, second));
        let last = change(plus(state, dt, third));
        let middle = plus(second, 1.0, third);
        plus(plus(state, dt / 6.0, plus(first, 1.0, last)), dt / 3.0, middle)
    };
    (0..STEPS).fold([from, velocity], step)[0]
}

/// Returns the velocity of the geodesic from `from` to `to`, by Newton's method from a guess.
fn aimed(from: DVec2, to: DVec2, guess: DVec2) -> DVec2 {
    const SMALL: f64 = 1e-6;
    let mut velocity = guess;
    for _ in 0..8 {
        let ahead = |by| (shot(from, velocity + by) - shot(from, velocity - by)) / (2.0 * SMALL);
        let slopes = DMat2::from_cols(ahead(SMALL * DVec2::X), ahead(SMALL * DVec2::Y));
        velocity -= slopes.inverse() * (shot(from, velocity) - to);
    }
    assert!(shot(from, velocity).distance(to) < 1e-9, "no geodesic to {to} near {guess}");
    velocity
}

#[test]
fn log_maps_on_bumps_are_those_of_shot_geodesics() {
    let place = |index: usize| DVec2::new((index % SIDE) as f64, (index / SIDE) as f64) * STEP;
    let heights = (0..SIDE * SIDE).map(|index| bumps(place(index)).0).collect();
    let surface = Surface::from_heights(SIDE, SIDE, heights, Spacing::square(STEP)).unwrap();
    for source in [[64.0, 64.0], [30.3, 40.6]] {
        let log_map = LogMap::new(&surface, &Sources::point(source[0], source[1])).unwrap();
        let basis = log_map.bases[0];
        // The basis is in rows and columns, the velocity along x and y.
        let [u, v] = [basis.u, basis.v].map(|[row, col]| DVec2::new(col, row) * STEP);
        let axes = DMat2::from_cols(u, v);
        let from = DVec2::new(source[1], source[0]) * STEP;
        let (mut sum, mut largest, mut farthest, mut count) = (0.0, 0.0f64, 0.0f64, 0);
        for index in (0..SIDE * SIDE).step_by(41) {
            let found = DVec2::from(log_map.coordinates[index].map(f64::from));
            let exact = axes.inverse() * aimed(from, place(index), axes * found);
            let error = found.distance(exact);
            (sum, largest) = (sum + error, largest.max(error));
            (farthest, count) = (farthest.max(exact.length()), count + 1);
        }
        let mean = sum / f64::from(count) / farthest;
        println!("from {source:?}: mean {mean:.1e}, largest {:.1e}", largest / farthest);
        assert!(mean < 1e-4, "from {source:?}: {mean}");
    }
}
