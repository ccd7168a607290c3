//! Offset curves compared with straight lines, circles and prolongations.

use std::f64::consts::PI;

use geosweep::geometry::{Contour, OffsetError, Side, contours, offset_curves};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Sources, Surface};

use crate::common::closed::flat;
use crate::common::{circle, cpu_map};

fn offsets(surface: &Surface, sources: &Sources, levels: &[f64], side: Side) -> Vec<Contour> {
    let edges = EdgeLengths::new(surface).unwrap();
    offset_curves(surface, &edges, sources, &cpu_map(surface, sources), levels, side).unwrap()
}

fn length(surface: &Surface, contour: &Contour) -> f64 {
    contour.curves.iter().map(|curve| curve.length(surface).unwrap()).sum()
}

/// Cells are squares in the plane, and oblongs on the unrolled cylinder. An offset curve consists of a straight
/// piece and two quarters of a circle, and ends on the prolongations of the line. Measured: ends within 0.14
/// cells of the prolongations.
#[test]
fn an_open_curve_has_a_line_and_two_quarter_circles_on_each_side() {
    for builtin in [Builtin::Plane, Builtin::Cylinder] {
        let surface = builtin.surface(129, 129).unwrap();
        let across = if builtin == Builtin::Plane { 1.0 } else { 1.5 * PI };
        let down = if builtin == Builtin::Plane { 1.0 } else { 3.0 };
        let place = |at: [f64; 2]| [down * at[0] / 128.0, across * at[1] / 128.0];
        for [from, to] in [
            [[64.0, 44.0], [64.0, 84.0]],
            [[50.3, 50.8], [75.2, 81.6]],
            [[82.2, 54.6], [46.7, 66.3]],
            [[80.0, 60.0], [48.0, 60.0]],
        ] {
            let sources = Sources::curve([from, to]);
            let [a, b] = [from, to].map(place);
            let whole = (b[0] - a[0]).hypot(b[1] - a[1]);
            let cell = across / 128.0;
            let level = 20.3 * cell;
            for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
                let found = offsets(&surface, &sources, &[level], side);
                let [curve] = &found[0].curves[..] else { panic!("{builtin} {from:?} {found:?}") };
                // Signed distance to the left of the line, in cells.
                let beside = |at: [f64; 2]| {
                    let at = place(at);
                    let left = (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0]);
                    sign * left / whole / cell
                };
                let lowest = curve.vertices.iter().map(|&at| beside(at)).fold(f64::MAX, f64::min);
                let ends = [curve.vertices[0], curve.vertices[curve.vertices.len() - 1]];
                let [first, last] = ends.map(|end| beside(end).abs());
                println!(
                    "{builtin} {from:?} {side:?}: ends {first:.3} {last:.3}, {lowest:.3} cells"
                );
                assert!(first < 0.3 && last < 0.3 && lowest > -0.3);
                let exact = whole + PI * level;
                approx::assert_relative_eq!(
                    length(&surface, &found[0]),
                    exact,
                    max_relative = 0.01
                );
            }
        }
    }
}

#[test]
fn a_closed_curve_has_an_inside_and_an_outside() {
    let surface = flat(101, 101);
    let (sources, _) = circle(101, [50.0, 50.0], 25.0);
    for (side, sign) in [(Side::Left, -1.0), (Side::Right, 1.0)] {
        for contour in offsets(&surface, &sources, &[5.0, 12.5, 20.0], side) {
            let [curve] = &contour.curves[..] else { panic!("{side:?}: {contour:?}") };
            assert!(curve.closed);
            let exact = 2.0 * PI * (25.0 + sign * contour.level);
            approx::assert_relative_eq!(length(&surface, &contour), exact, max_relative = 0.01);
        }
    }
}

/// Two lines in the same direction, as in the paper's figure 7. Points between them are on the right of the
/// northern line, or on the left of the southern one, whichever is nearer.
#[test]
fn sides_meet_half_way_between_curves() {
    let surface = flat(81, 121);
    let sources =
        Sources::curve([[30.0, 30.0], [30.0, 90.0]]).and_curve([[50.0, 30.0], [50.0, 90.0]], 0.0);
    let map = cpu_map(&surface, &sources);
    let levels = [4.0, 9.0, 15.0];
    let whole = contours(&map, &sources, &levels);
    let [left, right] =
        [Side::Left, Side::Right].map(|side| offsets(&surface, &sources, &levels, side));
    for ((left, right), whole) in left.iter().zip(&right).zip(&whole) {
        let sum = length(&surface, left) + length(&surface, right);
        approx::assert_relative_eq!(sum, length(&surface, whole), max_relative = 1e-3);
        for (contour, north) in [(left, [true, false]), (right, [false, true])] {
            for at in contour.curves.iter().flat_map(|curve| &curve.vertices) {
                if !(31.0..89.0).contains(&at[1]) {
                    continue;
                }
                // The left side of a line is north of it, and the right side south of it. Between the lines, sides
                // meet at row 40.
                let expected = [
                    at[0] < 30.0 || (40.0..50.0).contains(&at[0]),
                    at[0] > 50.0 || (30.0..=40.0).contains(&at[0]),
                ];
                let side = if north[0] { expected[0] } else { expected[1] };
                assert!(side || (at[0] - 40.0).abs() < 1.0, "{at:?}");
            }
        }
    }
}

/// An offset curve has an arc around a corner only on the corner's outer side.
#[test]
fn a_corner_is_round_outside() {
    let surface = flat(101, 101);
    // Eastwards, then southwards: the corner's outside is on the left.
    let sources = Sources::curve([[40.0, 20.0], [40.0, 60.0], [80.0, 60.0]]);
    let outside = offsets(&surface, &sources, &[10.0], Side::Left);
    let inside = offsets(&surface, &sources, &[10.0], Side::Right);
    let ends = 2.0 * PI * 10.0 / 2.0;
    let round = 80.0 + ends + PI * 10.0 / 2.0;
    approx::assert_relative_eq!(length(&surface, &outside[0]), round, max_relative = 0.01);
    approx::assert_relative_eq!(length(&surface, &inside[0]), 60.0 + ends, max_relative = 0.01);
}

#[test]
fn points_have_no_sides_and_curves_beyond_the_map_no_offsets() {
    let surface = flat(11, 21);
    let edges = EdgeLengths::new(&surface).unwrap();
    let sources = Sources::curve([[5.0, 5.0], [5.0, 15.0]]).and_point(1.0, 1.0, 0.0);
    let map = cpu_map(&surface, &sources);
    let error = offset_curves(&surface, &edges, &sources, &map, &[2.0], Side::Left).unwrap_err();
    assert_eq!(error, OffsetError::NoSides { source_index: 1 });
    let sources = Sources::curve([[5.0, 5.0], [5.0, 15.0]]);
    for contour in offsets(&surface, &sources, &[-1.0, 0.0, 1e6], Side::Left) {
        assert!(contour.curves.is_empty());
    }
    // There is no offset in a part that no front reaches, and a curve along the border has offsets on one side only.
    let mask: Vec<bool> = (0..11 * 21).map(|i| i / 21 != 5).collect();
    let cut_off = surface.with_mask(&mask).unwrap();
    let sources = Sources::curve([[0.0, 0.0], [0.0, 20.0]]);
    let right = offsets(&cut_off, &sources, &[2.5, 4.5], Side::Right);
    assert_eq!((right[0].curves.len(), right[1].curves.len()), (1, 0));
    assert!(offsets(&cut_off, &sources, &[2.5], Side::Left)[0].curves.is_empty());
    // A surface with two rows.
    let sources = Sources::curve([[0.0, 2.0], [1.0, 2.0]]);
    let left = offsets(&flat(2, 9), &sources, &[3.5], Side::Left);
    assert!(left[0].curves.iter().flat_map(|curve| &curve.vertices).all(|at| at[1] > 2.0));
    assert_eq!(left[0].curves.len(), 1);
}
