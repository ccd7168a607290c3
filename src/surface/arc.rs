//! Lengths of edges along the surface rather than along chords. The twin of `glsl/arc.glsl`.
//!
//! Across each grid point, along each line of grid points, the second difference of the positions
//! normal to the surface is the *bend*: normal curvature times the squared spacing. The part along
//! the surface is the grid line's own affair: circles of latitude are longer than the way between
//! their points, and a plane stays a plane whatever grid is drawn on it.
//!
//! A cubic with the bends a and b at its ends, in chords, is longer than its chord by
//! m^2 / 24 + d^2 / 1440 of it, with m their mean and d their difference. We take
//! |m| sqrt(a b) / 24, as good to second order in d: it falls to nothing where only one end bends
//! (a crease that runs through a grid point has flat surface on either side) or both bend to
//! different sides, with no threshold that noise could cross. Measured on real terrain, see
//! [`EdgeRule`], the curved front: 9.4e-4 so, 9.7e-4 with a b / 24, 8.8e-4 with m^2 / 24 where
//! a b > 0, which would bend a noisy crease.

use super::chart::Direction;
use super::edges::STORED;
use super::real::{Real, max, min};

/// How long the surface is between neighbouring grid points.
///
/// [`EdgeRule::Arc`] is the default, since it is the better one on smooth surfaces and on rough
/// ones. Mean relative error of converged maps from a point source, at 400 x 400 points in single
/// precision; and on ten maps over 65 x 65 points of the terrain in `examples/data`, heights in
/// whole metres, against exact polyhedral distances on a fourfold spline refinement:
///
/// | surface | wavefront | chord | arc |
/// |---|---|---:|---:|
/// | cylinder | point-source | 3.5e-6 | 7.8e-8 |
/// | cylinder | curved | 3.5e-6 | 1.3e-7 |
/// | cone | curved | 3.4e-6 | 6.9e-7 |
/// | sphere | curved | 1.5e-6 | 1.7e-7 |
/// | terrain | point-source | 1.2e-3 | 8.6e-4 |
/// | terrain | curved | 1.3e-3 | 9.4e-4 |
///
/// A surface given by its metric has neither: the rule makes no difference to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum EdgeRule {
    /// The straight line: the surface is the polyhedron of its samples. For comparisons with exact
    /// distances on a mesh, and for surfaces that are polyhedra.
    Chord,
    /// Along a cubic through the neighbouring samples, where the surface bends alike at both ends
    /// of the edge; the chord at creases, and where a neighbour is missing at a hole or the border.
    #[default]
    Arc,
}

impl EdgeRule {
    /// The part of the area of a point's fan of eight triangles to which its angle defect belongs.
    ///
    /// Chords: the fan is a part of the polyhedron, and its tip stands for one cell of the four
    /// (exactly so where the grid follows the lines of curvature). Arcs: each of a curved
    /// triangle's angles is larger than a flat one's with the same sides by a third of the
    /// triangle's total curvature, whatever the grid.
    pub(crate) fn share_of_fan(self) -> f64 {
        match self {
            Self::Chord => 1.0 / 4.0,
            Self::Arc => 1.0 / 3.0,
        }
    }
}

/// Length of an edge from its chord and the bends at its ends.
#[inline(always)]
pub(super) fn arc<R: Real>(chord: R, a: R, b: R) -> R {
    let (a, b) = (turn(a, chord), turn(b, chord));
    let square = R::of(0.5) * (a + b).abs() * max(a * b, R::zero()).sqrt();
    let arc = chord + chord * (square * R::of(1.0 / 24.0));
    if chord > R::zero() { arc } else { chord }
}

/// By how much a bend turns a chord: a turn by more than a radian is beyond what samples tell.
#[inline(always)]
fn turn<R: Real>(bend: R, chord: R) -> R {
    min(max(bend / chord, -R::one()), R::one())
}

/// The bends across a point along the lines of [`STORED`], from the ways to its eight neighbours and
/// whether they are there; none where a neighbour on the line is missing.
#[inline(always)]
pub(super) fn bends<R: Real>(ways: [[R; 3]; 8], there: [bool; 8]) -> [R; 4] {
    let normal = normal(ways);
    let mut bends = [R::zero(); 4];
    for k in 0..4 {
        let (to, back) = (STORED[k] as usize, STORED[k].opposite() as usize);
        let bend = dot(sum(ways[to], ways[back]), normal);
        bends[k] = if there[to] & there[back] { bend } else { R::zero() };
    }
    bends
}

/// The surface's unit normal, or zero where the grid has none (at a pole, beside two holes), from
/// the ways to the neighbours that are there, zero to others.
#[inline(always)]
fn normal<R: Real>(ways: [[R; 3]; 8]) -> [R; 3] {
    let [ux, uy, uz] = along(ways, Direction::East);
    let [vx, vy, vz] = along(ways, Direction::North);
    let cross = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    // Between lines closer than a thousandth of a radian, rounding would turn the normal.
    let is_known = dot(cross, cross) > R::of(1e-6);
    let [x, y, z] = unit(cross);
    let zero = R::zero();
    [
        if is_known { x } else { zero },
        if is_known { y } else { zero },
        if is_known { z } else { zero },
    ]
}

/// The unit vector along a grid line, or zero.
#[inline(always)]
fn along<R: Real>(ways: [[R; 3]; 8], to: Direction) -> [R; 3] {
    let (ahead, behind) = (ways[to as usize], ways[to.opposite() as usize]);
    unit([ahead[0] - behind[0], ahead[1] - behind[1], ahead[2] - behind[2]])
}

#[inline(always)]
fn unit<R: Real>(a: [R; 3]) -> [R; 3] {
    let length = dot(a, a).sqrt();
    let zero = R::zero();
    let is_long = length > zero;
    let [x, y, z] = [a[0] / length, a[1] / length, a[2] / length];
    [if is_long { x } else { zero }, if is_long { y } else { zero }, if is_long { z } else { zero }]
}

#[inline(always)]
fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

#[inline(always)]
fn sum<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use glam::DVec3;

    use super::*;
    use crate::surface::{EdgeLengths, MetricTensor, Spacing, Surface, builtin::Builtin};

    fn edges(surface: &Surface, rule: EdgeRule) -> EdgeLengths<f64> {
        EdgeLengths::new(&surface.clone().with_edge_rule(rule)).unwrap()
    }

    /// A cylinder of radius 1 with grid lines along and across it, at 0.1 radian and 0.1.
    fn cylinder(rows: usize, cols: usize) -> Surface {
        let point = |index: usize| {
            let (angle, along) = (0.1 * (index % cols) as f64, 0.1 * (index / cols) as f64);
            DVec3::new(angle.cos(), angle.sin(), along)
        };
        Surface::from_positions(rows, cols, (0..rows * cols).map(point).collect()).unwrap()
    }

    #[test]
    fn arcs_of_a_cylinder_are_as_long_as_on_the_unrolled_one() {
        let edges = edges(&cylinder(6, 8), EdgeRule::Arc);
        for (row, col) in (1..6).flat_map(|row| (1..7).map(move |col| (row, col))) {
            let length = |to| edges.length(row, col, to);
            assert_relative_eq!(length(Direction::North), 0.1, max_relative = 1e-12);
            // Both ends must have neighbours on the line through them.
            let inside = row > 1 && row < 5 && (2..5).contains(&col);
            for (to, exact) in [
                (Direction::East, 0.1),
                (Direction::NorthEast, 0.1 * 2f64.sqrt()),
                (Direction::NorthWest, 0.1 * 2f64.sqrt()),
            ]
            .into_iter()
            .take(if inside { 3 } else { usize::from((1..6).contains(&col)) })
            {
                // The chord is short by 4e-4.
                assert_relative_eq!(length(to), exact, max_relative = 3e-6);
            }
        }
    }

    #[test]
    fn arcs_are_measured_along_the_surface_not_along_grid_lines() {
        // Polar grid of a plane: circles bend, the plane does not.
        let point = |index: usize| {
            let (angle, radius) = (0.2 * (index % 7) as f64, 1.0 + 0.1 * (index / 7) as f64);
            DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.25)
        };
        let plane = Surface::from_positions(5, 7, (0..35).map(point).collect()).unwrap();
        let (chords, arcs) = (edges(&plane, EdgeRule::Chord), edges(&plane, EdgeRule::Arc));
        assert_same(&chords, &arcs);
    }

    fn assert_same(a: &EdgeLengths<f64>, b: &EdgeLengths<f64>) {
        let chart = a.chart();
        for index in 0..chart.points() {
            let (row, col) = chart.position(index);
            for to in STORED {
                let (a, b) = (a.length(row, col, to), b.length(row, col, to));
                assert_relative_eq!(a, b, max_relative = 1e-14);
            }
        }
    }

    #[test]
    fn creases_keep_their_chords() {
        // A roof with its ridge along a column, a flat one with steep sides, and stairs.
        let roofs: [fn(f64, f64) -> f64; 3] = [
            |_, x| (x - 4.0).abs(),
            |_, x| (5.0 * (x - 4.0).abs() - 10.0).max(0.0),
            |_, x| (x / 2.0).round(),
        ];
        for roof in roofs {
            let heights = (0..81).map(|i| roof((i / 9) as f64, (i % 9) as f64)).collect();
            let surface = Surface::from_heights(9, 9, heights, Spacing::square(1.0)).unwrap();
            assert_same(&edges(&surface, EdgeRule::Chord), &edges(&surface, EdgeRule::Arc));
        }
    }

    #[test]
    fn edges_beside_holes_and_borders_keep_their_chords() {
        let mut mask = vec![true; 5 * 8];
        mask[2 * 8 + 1] = false;
        let surface = cylinder(5, 8).with_mask(&mask).unwrap();
        let (chords, arcs) = (edges(&surface, EdgeRule::Chord), edges(&surface, EdgeRule::Arc));
        let is_arc = |row, col, to| {
            let (chord, arc) = (chords.length(row, col, to), arcs.length(row, col, to));
            assert_eq!(chord < f64::FAR, arc < f64::FAR);
            arc > chord * (1.0 + 1e-6)
        };
        for (row, arcs) in [(1, 1..6), (2, 3..6)] {
            for col in 0..8 {
                assert_eq!(is_arc(row, col, Direction::East), arcs.contains(&col), "{row} {col}");
            }
        }
        assert!(is_arc(3, 3, Direction::NorthWest) && !is_arc(3, 2, Direction::NorthWest));
    }

    #[test]
    fn extremes_stay_finite() {
        for scale in [2e-12, 1e11] {
            let points = (0..49).map(|i| {
                let (y, x) = ((i / 7) as f64, (i % 7) as f64);
                DVec3::new(x, y, (1.3 * x).sin() * (0.9 * y).cos()) * scale
            });
            let surface = Surface::from_positions(7, 7, points.collect()).unwrap();
            let single = EdgeLengths::<f32>::new(&surface).unwrap();
            let double = EdgeLengths::<f64>::new(&surface).unwrap();
            for to in STORED {
                let single = f64::from(single.length(3, 3, to));
                assert_relative_eq!(single, double.length(3, 3, to), max_relative = 1e-5);
            }
        }
        // The points of a pole coincide.
        let points = (0..35).map(|i| {
            let (angle, polar) = (0.3 * f64::from(i % 7), 0.2 * f64::from(i / 7));
            let (sin, cos) = polar.sin_cos();
            DVec3::new(sin * angle.cos(), sin * angle.sin(), cos)
        });
        let pole = Surface::from_positions(5, 7, points.collect()).unwrap();
        let pole = EdgeLengths::<f32>::new(&pole).unwrap();
        assert_eq!(pole.length(0, 3, Direction::East), 0.0);
        assert_relative_eq!(pole.length(2, 3, Direction::North), 0.2, max_relative = 1e-4);
    }

    #[test]
    fn a_metric_and_a_plane_are_as_before() {
        let tensor = |i: usize| MetricTensor { rr: 1.0 + i as f64, rc: 0.1, cc: 2.0 };
        let metric = Surface::from_metric(5, 5, (0..25).map(tensor).collect()).unwrap();
        for surface in [metric, Builtin::ShearedPlane { degrees: 60.0 }.surface(9, 9).unwrap()] {
            assert_same(&edges(&surface, EdgeRule::Chord), &edges(&surface, EdgeRule::Arc));
        }
    }
}
