//! Offsets on one side of curves that pass seams of closed surfaces.

use std::f64::consts::{PI, TAU};

use geosweep::geometry::{Contour, Side, offset_curves};
use geosweep::surface::EdgeLengths;
use geosweep::{Sources, Surface};

use crate::common::closed::*;
use crate::common::cpu_map;

fn offsets(surface: &Surface, sources: &Sources, levels: &[f64], side: Side) -> Vec<Contour> {
    let map = cpu_map(surface, sources);
    let edges = EdgeLengths::new(surface).unwrap();
    offset_curves(surface, &edges, sources, &map, levels, side).unwrap()
}

/// The curve crosses the seam, ends near it, or lies far from it. Each offset is a straight line and two quarters of a
/// circle, on the curve's own left and right side, also where the rows of the Moebius strip are reversed.
#[test]
fn offsets_of_lines_are_whole_over_seams() {
    for (name, gluing, shape) in shapes() {
        let surface = flat(41, 65).with_gluing(gluing).unwrap();
        let beyond = |row: f64| if shape.flipped { 40.0 - row } else { row };
        for col in [10.0, 37.0, 50.0, 34.0, 63.0] {
            let (row, end) = (18.0, col + 28.0);
            let mut line = vec![[row, col], [row, end]];
            if end >= 64.0 {
                line = vec![[row, col], [row, 64.0], [beyond(row), 0.0], [beyond(row), end - 64.0]];
            }
            let sources = Sources::curve(line);
            for (side, sign) in [(Side::Left, -1.0), (Side::Right, 1.0)] {
                let found = offsets(&surface, &sources, &[8.0], side);
                let [curve] = &found[0].curves[..] else {
                    panic!("{name} {col} {side}: {found:?}")
                };
                let exact = 28.0 + 8.0 * PI;
                let length = curve.length(&surface).unwrap();
                println!("{name} {col} {side}: {length:.2} of {exact:.2}");
                assert!((length - exact).abs() < 0.02 * exact, "{name} {col} {side}: {length}");
                for at in &curve.vertices {
                    // The vertex is unrolled: continued from the rows and columns at the beginning of the curve.
                    let right = if at[1] < col - 9.0 { 64.0 } else { 0.0 };
                    let right = if at[1] > end + 9.0 { -64.0 } else { right };
                    let row = if right == 0.0 { at[0] } else { beyond(at[0]) };
                    assert!(sign * (row - 18.0) > -0.3, "{name} {col} {side}: {at:?}");
                }
            }
        }
    }
}

/// A circle of latitude has no ends, though it begins and ends on the seam.
#[test]
fn offsets_of_a_circle_around_a_globe_are_circles() {
    let surface = globe(61, 121);
    let circle = Sources::curve((0..=60).map(|k| [20.0, 2.0 * f64::from(k)]));
    // The circle runs eastwards, so that the north is on its left.
    for (side, polar) in [(Side::Left, PI / 3.0 - 0.3), (Side::Right, PI / 3.0 + 0.3)] {
        let found = offsets(&surface, &circle, &[0.3], side);
        let [curve] = &found[0].curves[..] else { panic!("{side}: {found:?}") };
        assert!(curve.closed, "{side}");
        let exact = TAU * polar.sin();
        approx::assert_relative_eq!(curve.length(&surface).unwrap(), exact, max_relative = 0.01);
        for at in curve.lift(&surface).unwrap() {
            approx::assert_abs_diff_eq!(at.z.acos(), polar, epsilon = 0.01);
        }
    }
}

/// The curve is an arc of a great circle over the pole. Between its ends, offsets keep their distance from its plane.
#[test]
fn offsets_of_an_arc_over_a_pole_lie_beside_it() {
    let surface = globe(61, 121);
    let arc = Sources::curve([[10.0, 20.0], [0.0, 20.0], [0.0, 80.0], [10.0, 80.0]]);
    let [from, to] = [20, 80].map(|col| surface.position(10, col).unwrap());
    // The left side of a walk from the first end over the pole to the last end, seen from outside.
    let left = from.cross(to).normalize();
    for (side, sign) in [(Side::Left, 1.0), (Side::Right, -1.0)] {
        let found = offsets(&surface, &arc, &[0.3], side);
        let pieces = &found[0].curves;
        let length: f64 = pieces.iter().map(|curve| curve.length(&surface).unwrap()).sum();
        let exact = PI / 3.0 * 0.3f64.cos() + PI * 0.3f64.sin();
        println!("{side}: {} pieces, {length:.3} of {exact:.3}", pieces.len());
        assert!((length - exact).abs() < 0.03 * exact, "{side}: {length} {exact}");
        for at in pieces.iter().flat_map(|curve| curve.lift(&surface).unwrap()) {
            let beside = sign * at.dot(left);
            assert!(beside > -0.03, "{side}: {at} {beside}");
            let along = at.dot((from + to).normalize());
            if along > (PI / 6.0).cos() * 0.3f64.cos() + 0.02 {
                approx::assert_abs_diff_eq!(beside, 0.3f64.sin(), epsilon = 0.01);
            }
        }
    }
}

/// A torus whose grid begins at any other column has the same offsets.
#[test]
fn offsets_do_not_depend_on_where_the_grid_is_cut() {
    let rolled = |by: usize| {
        let surface = rolled_torus(41, 61, by, 0.1);
        // A bent line from column 20 to column 34 of the first grid.
        let line = [[12.0, 20.0], [15.0, 24.0], [13.0, 29.0], [16.0, 34.0]];
        let mut vertices: Vec<[f64; 2]> = Vec::new();
        for [row, col] in line {
            let col = (col - by as f64).rem_euclid(60.0);
            if let Some(&[before_row, before]) = vertices.last().filter(|before| before[1] > col) {
                let share = (60.0 - before) / (60.0 - before + col);
                let row = before_row + share * (row - before_row);
                vertices.extend([[row, 60.0], [row, 0.0]]);
            }
            vertices.push([row, col]);
        }
        let found = offsets(&surface, &Sources::curve(vertices), &[0.5, 0.8], Side::Left);
        let length = |contour: &Contour| -> f64 {
            contour.curves.iter().map(|curve| curve.length(&surface).unwrap()).sum()
        };
        [length(&found[0]), length(&found[1])]
    };
    let plain = rolled(0);
    for by in [10, 27, 33] {
        let other = rolled(by);
        println!("{by}: {other:?}, {plain:?}");
        for (a, b) in plain.iter().zip(other) {
            assert!((a - b).abs() < 1e-3 * a, "{by}: {a} {b}");
        }
    }
}
