//! Ridges compared with bisectors, lines half-way between curves, and the line behind a wall.

use geosweep::geometry::{Ridge, ridges};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Sources, Surface, Wavefront, distance_map};

use crate::common::closed::flat;
use crate::common::{cells_from_zero, cpu_map, curved, points};

fn of(surface: &Surface, sources: &Sources) -> Vec<Ridge> {
    let map = cpu_map(surface, sources);
    ridges(&EdgeLengths::new(surface).unwrap(), &map.distances, 30.0).unwrap()
}

/// The ridge consists of the part of the bisector where fronts meet at a large enough angle, and of nothing else.
#[test]
fn the_bisector_of_two_sources_is_a_ridge() {
    for builtin in [Builtin::Plane, Builtin::Cylinder, Builtin::Sphere] {
        let surface = builtin.surface(129, 129).unwrap();
        for pair in [[[30.0, 35.0], [95.0, 75.0]], [[60.5, 20.25], [70.0, 110.0]]] {
            let sources = points(&pair);
            let exact = |from, at| builtin.exact_distance(129, 129, from, at).unwrap();
            let later = |at| exact(pair[0], at) - exact(pair[1], at);
            let found = of(&surface, &sources);
            let (mut worst, mut vertices) = (0.0f64, 0);
            for at in found.iter().flat_map(|ridge| &ridge.curve.vertices) {
                worst = worst.max(cells_from_zero(129, later, *at));
                vertices += 1;
            }
            println!(
                "{builtin} {pair:?}: {} ridges, {vertices} vertices, {worst:.3} cells",
                found.len()
            );
            assert!(vertices > 150 && worst < 0.5);
        }
    }
}

#[test]
fn a_ridge_lies_half_way_between_curves_and_has_its_angle() {
    let surface = flat(61, 101);
    let sources =
        Sources::curve([[15.0, 0.0], [15.0, 100.0]]).and_curve([[40.0, 0.0], [40.0, 100.0]], 0.0);
    let found = of(&surface, &sources);
    let [ridge] = &found[..] else { panic!("{found:?}") };
    assert!(!ridge.curve.closed && ridge.angles.len() == ridge.curve.vertices.len());
    for (at, angle) in ridge.curve.vertices.iter().zip(&ridge.angles) {
        approx::assert_abs_diff_eq!(at[0], 27.5, epsilon = 0.05);
        // Rays are those of circular fronts. 12 cells beside a source curve, each ray is off by up to 0.5 / 12 radians.
        approx::assert_abs_diff_eq!(*angle, 180.0, epsilon = 8.0);
    }
    let cols: Vec<f64> = ridge.curve.vertices.iter().map(|at| at[1]).collect();
    assert_eq!(
        (cols[0].min(cols[cols.len() - 1]), cols[0].max(cols[cols.len() - 1])),
        (0.0, 100.0)
    );
}

/// A single source lies symmetrically before a wall. The ridge behind the wall is a single line, although it
/// runs along a column of the grid, where rounding decides from which side a point's front has come.
#[test]
fn fronts_meet_behind_a_wall() {
    for (side, wall, half, from) in [(101, 30, 20, 10.0), (61, 20, 15, 5.0), (91, 25, 12, 15.0)] {
        let middle = side / 2;
        let is_free = |i: usize| i / side != wall || (i % side).abs_diff(middle) > half;
        let mask: Vec<bool> = (0..side * side).map(is_free).collect();
        let surface = flat(side, side).with_mask(&mask).unwrap();
        for wavefront in Wavefront::ALL {
            let sources = Sources::point(from, middle as f64);
            let options = curved().with_wavefront(wavefront);
            let map = distance_map(&surface, &sources, &options).unwrap();
            let edges = EdgeLengths::new(&surface).unwrap();
            let found = ridges(&edges, &map.distances, 30.0).unwrap();
            let [ridge] = &found[..] else { panic!("{side}, {wavefront}: {found:?}") };
            let rows = ridge.curve.vertices.iter().map(|at| at[0]);
            let (low, high) =
                rows.fold((f64::MAX, f64::MIN), |(low, high), row| (low.min(row), high.max(row)));
            // The line runs up to the wall, and down to the border or to where the paths around the wall's
            // ends meet at 30 degrees.
            let (wall, middle, half) = (wall as f64, middle as f64, half as f64);
            let end = f64::min(wall + half / 15f64.to_radians().tan(), (side - 1) as f64);
            assert!(low < wall + 3.0 && high > end - 10.0, "{side}, {wavefront}: {low} {high}");
            for (at, angle) in ridge.curve.vertices.iter().zip(&ridge.angles) {
                assert!((at[1] - middle).abs() < 0.5, "{side}, {wavefront}: {at:?}");
                let exact = 2.0 * f64::atan2(half, at[0] - wall).to_degrees();
                // In the first cells behind the wall, fronts have passed few triangles.
                let most = if at[0] < wall + 5.0 { 20.0 } else { 15.0 };
                assert!((angle - exact).abs() < most, "{wavefront} {at:?}: {angle} {exact}");
            }
        }
    }
}

#[test]
fn no_fronts_meet_in_a_convex_patch() {
    for builtin in [Builtin::Plane, Builtin::Cylinder, Builtin::Sphere] {
        for source in [[40.0, 70.0], [40.3, 70.6], [0.0, 0.0]] {
            let found =
                of(&builtin.surface(129, 129).unwrap(), &Sources::point(source[0], source[1]));
            assert!(found.is_empty(), "{builtin} {source:?}: {found:?}");
        }
    }
    assert!(of(&flat(2, 9), &Sources::point(0.0, 0.0)).is_empty());
    assert!(of(&flat(1, 9), &Sources::point(0.0, 4.0)).is_empty());
    let error = ridges(&EdgeLengths::new(&flat(3, 3)).unwrap(), &[0.0; 4], 30.0).unwrap_err();
    assert_eq!(error.to_string(), "4 distances do not fill a grid of 3 x 3 points");
}

/// Along these ridges, angles vary around the least angle. If a ridge ended wherever its angle is smaller, it would
/// be cut into dashes.
#[test]
fn ridges_behind_hills_are_in_one_piece_each() {
    let surface = Builtin::Peaks.surface(257, 257).unwrap();
    let found: Vec<_> = of(&surface, &Sources::point(60.0, 60.0))
        .iter()
        .map(|ridge| ridge.curve.vertices.len())
        .collect();
    assert!((1..=6).contains(&found.len()) && found.iter().all(|&many| many > 30), "{found:?}");
}
