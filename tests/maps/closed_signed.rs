//! Signs of distances from closed curves that pass seams of closed surfaces.

use std::f64::consts::TAU;

use geosweep::geometry::{SignError, signed_distances};
use geosweep::surface::Gluing;
use geosweep::{Options, Sources, Surface, distance_map};

use crate::common::closed::*;

fn signed(surface: &Surface, sources: &Sources) -> Result<Vec<f32>, SignError> {
    let map = distance_map(surface, sources, &Options::default()).unwrap();
    signed_distances(surface, sources, &map.distances)
}

/// Returns the vertices of a counter-clockwise circle on a tube of 64 columns, of which the last one repeats the first.
/// The circle passes the seam if its middle lies near it.
fn circle([row, col]: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let at = |k: usize| {
        let (sin, cos) = (TAU * (k % 48) as f64 / 48.0).sin_cos();
        [row + radius * sin, col - radius * cos]
    };
    let mut vertices: Vec<[f64; 2]> = Vec::new();
    let mut turn = 0.0;
    for [row, col] in (0..=48).map(at) {
        let next = (col / 64.0).floor();
        if let Some(&[before_row, before]) = vertices.last().filter(|_| next != turn) {
            // The column of the seam that is passed, as counted around the tube.
            let seam = 64.0 * f64::max(turn, next);
            let from = before + 64.0 * turn;
            let row = before_row + (seam - from) / (col - from) * (row - before_row);
            vertices.extend([[row, seam - 64.0 * turn], [row, seam - 64.0 * next]]);
        }
        turn = next;
        vertices.push([row, col - 64.0 * turn]);
    }
    vertices
}

/// The inside of a circle is the disk within it, wherever the tube is cut open. A clockwise circle has the rest of the
/// tube inside.
#[test]
fn circles_over_a_seam_surround_their_disk() {
    let surface = flat(41, 65).with_gluing(Gluing::columns()).unwrap();
    for col in [32.0, 0.3, 5.0, 58.5, 63.7] {
        let (row, radius) = (20.2, 9.4);
        let mut vertices = circle([row, col], radius);
        for sign in [1.0, -1.0] {
            let found = signed(&surface, &Sources::curve(vertices.clone())).unwrap();
            for (index, found) in found.into_iter().enumerate() {
                let (down, right) = ((index / 65) as f64 - row, (index % 65) as f64 - col);
                let right = right - 64.0 * (right / 64.0).round();
                let exact = sign * (down.hypot(right) - radius);
                // The circle is a polygon, and the middle of the other side of the tube is reached from both sides.
                assert!((f64::from(found) - exact).abs() < 0.1, "{col} {index}: {found} {exact}");
            }
            vertices.reverse();
        }
    }
}

/// A curve once around a tube divides it. Eastwards, with rows downwards, its left side is that of smaller rows.
#[test]
fn a_curve_around_a_tube_divides_it() {
    let surface = flat(41, 65).with_gluing(Gluing::columns()).unwrap();
    for ends in [[0.0, 64.0], [64.0, 0.0]] {
        let around = Sources::curve([ends[0], 30.0, ends[1]].map(|col| [12.5, col]));
        let found = signed(&surface, &around).unwrap();
        let sign = if ends[0] < ends[1] { 1.0 } else { -1.0 };
        for (index, found) in found.into_iter().enumerate() {
            let exact = sign * ((index / 65) as f64 - 12.5);
            assert!((f64::from(found) - exact).abs() < 1e-3, "{index}: {found} {exact}");
        }
    }
}

/// On a globe a circle of latitude surrounds a pole. Distances have the sign of the latitude's difference.
#[test]
fn a_circle_of_latitude_surrounds_a_pole() {
    let surface = globe(61, 121);
    for row in [1.5, 20.0, 47.3] {
        let circle = Sources::curve((0..=120).map(|k| [row, f64::from(k)]));
        let found = signed(&surface, &circle).unwrap();
        for (index, found) in found.into_iter().enumerate() {
            let exact = ((index / 121) as f64 - row) * TAU / 120.0;
            assert!((f64::from(found) - exact).abs() < 1e-3, "{row} {index}: {found} {exact}");
        }
    }
}

/// Initial values that differ from curve to curve change distances and no sign.
#[test]
fn curves_with_other_initial_values_have_the_same_inside() {
    let surface = flat(41, 65).with_gluing(Gluing::columns()).unwrap();
    let [upper, lower] = [[0.0, 30.0, 64.0], [64.0, 30.0, 0.0]];
    let line = |row: f64, cols: [f64; 3]| cols.map(|col| [row, col]);
    // The band between the curves lies to the left of neither of them.
    let sources = Sources::curve(line(10.5, upper)).and_curve(line(30.5, lower), 3.0);
    let found = signed(&surface, &sources).unwrap();
    for (index, found) in found.into_iter().enumerate() {
        let row = index / 65;
        let is_inside = row <= 10 || row > 30;
        assert_eq!(found < 0.0, is_inside, "{index}: {found}");
    }
}

#[test]
fn curves_that_do_not_divide_the_surface_are_refused() {
    let torus = torus(41, 61);
    let around = |row: f64, ends: [f64; 2]| [ends[0], 30.0, ends[1]].map(|col| [row, col]);
    let one = Sources::curve(around(12.5, [0.0, 60.0]));
    assert!(matches!(signed(&torus, &one), Err(SignError::Undivided { .. })));
    // Both have their left sides towards smaller rows.
    let both = one.clone().and_curve(around(30.5, [0.0, 60.0]), 0.0);
    assert!(matches!(signed(&torus, &both), Err(SignError::Undivided { .. })));
    // Between them lies the inside.
    let two = one.and_curve(around(30.5, [60.0, 0.0]), 0.0);
    let found = signed(&torus, &two).unwrap();
    for (index, found) in found.into_iter().enumerate() {
        let row = index / 61;
        assert_eq!(found > 0.0, (13..=30).contains(&row), "{index}: {found}");
    }
    // The middle line of a Moebius strip has one side.
    let strip = flat(41, 65).with_gluing(Gluing::flipped_columns()).unwrap();
    let middle = Sources::curve(around(20.0, [0.0, 64.0]));
    assert!(matches!(signed(&strip, &middle), Err(SignError::Undivided { .. })));
    // Its ends are copies, so that the curve is one place.
    let place = Sources::curve([[10.0, 0.0], [30.0, 64.0]]);
    let found = signed(&strip, &place);
    assert_eq!(found, Err(SignError::Point { source_index: 0 }));
    let open = Sources::curve([[10.0, 20.0], [10.0, 30.0]]);
    let found = signed(&strip, &open);
    assert!(matches!(found, Err(SignError::Open { source_index: 0, .. })));
}
