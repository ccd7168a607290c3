//! Computes the lengths of edges along the surface rather than along chords. The twin of
//! `glsl/update/arc.glsl`.
//!
//! The *bend* at a grid point along a line of grid points is the part of the second difference of the
//! positions that is normal to the surface. It equals the normal curvature times the squared spacing. The
//! tangential part belongs to the grid line and is ignored: circles of latitude are longer than the shortest
//! paths between their points, and a plane stays a plane whatever grid is drawn on it.
//!
//! On octahedral maps grid lines have corners on a smooth surface, and the steps to both neighbours have different
//! lengths. There the bend is divided by the mean of both squared steps, and is the normal curvature. On other surfaces
//! steps differ mostly by the roughness of the surface, and the bend stays as it is: on rough terrain the error is 6.6e-4
//! then, and 6.7e-4 with the division.
//!
//! A cubic with the bends a and b at its ends, in units of the chord, is longer than its chord by the
//! fraction m^2 / 24 + d^2 / 1440, where m is the mean of the bends and d their difference. The fraction used here
//! is s / 24 with s = |m| sqrt(a b), which differs from the former only by terms of second order in d. It vanishes
//! where only one end bends (a crease that runs through a grid point has flat surface on either side) and where the
//! ends bend to different sides. It needs no threshold that noise could cross. Measured on real terrain with curved
//! fronts (see [`EdgeRule`]), the error is 9.4e-4 with this rule, 9.7e-4 with a b / 24, and 8.8e-4 with m^2 / 24
//! where a b > 0; the last rule would bend a noisy crease.
//!
//! A curve of curvature k and torsion t is longer than its chord c by the fraction k^2 c^2 / 24. The term of
//! the next order is k^2 (k^2 + t^2) c^4 / 180 - (bend / c)^4 / 1152, if the bend is that of a helix with
//! even steps. For a geodesic, k^2 + t^2 is the squared rate at which the surface normal turns along it.
//! Therefore w^2, the squared difference of the unit normals at both ends, stands for (k^2 + t^2) c^2. On
//! cylinders all edges are parts of helices. There s / 24 alone leaves an error of 5e-3 of the fourth power
//! of the edge's angle, and the next term reduces it to a thousandth. Single precision hardly shows this;
//! double precision does.
//!
//! Where a grid line ends, at a hole or the border, its last point has no second difference. Its bend is
//! taken from the next two points inwards: the smaller of their bends, if both are to the same side
//! ([`end_bend`]). A line of three points has no such pair and keeps its chords.

use super::chart::{Direction, STORED};
use super::geometry::Space;
use super::real::{Real, max, min};

/// The rule by which the length of an edge between neighbouring grid points is measured.
///
/// [`EdgeRule::Arc`] is the default, since it is more accurate both on smooth surfaces and on rough ones. The
/// table shows the mean relative error of converged maps from a point source. The first four rows are at 400 x 400
/// points in single precision. The rows of the terrain are means over ten maps of 65 x 65 points of the terrain in
/// `examples/data`, with heights in whole metres. They are compared with exact polyhedral distances on a fourfold
/// spline refinement.
///
/// | surface | wavefront | chord | arc |
/// |---|---|---:|---:|
/// | cylinder | circular | 3.5e-6 | 8.1e-8 |
/// | cylinder | curved | 3.5e-6 | 1.4e-7 |
/// | cone | curved | 2.9e-6 | 3.0e-7 |
/// | sphere | curved | 1.5e-6 | 2.0e-7 |
/// | terrain | circular | 1.2e-3 | 8.6e-4 |
/// | terrain | curved | 1.3e-3 | 9.4e-4 |
///
/// On the cylinder the remaining error is the rounding of single precision; in double precision it is 4e-15.
///
/// The rule makes no difference to a surface given by its metric, which has neither chords nor arcs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum EdgeRule {
    /// The straight line: the surface is the polyhedron of its samples. This rule is for comparisons with
    /// exact distances on a mesh, and for surfaces that are polyhedra.
    Chord,
    /// The arc of a cubic through the neighbouring samples, where the surface bends to the same side at both
    /// ends of the edge, and the chord at creases. Where a neighbour is missing, at a hole or the border, the bend
    /// there is the smaller of the bends at the next two points inwards, or 0 if these bends are to different sides.
    #[default]
    Arc,
}

impl std::fmt::Display for EdgeRule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Chord => "chord",
            Self::Arc => "arc",
        })
    }
}

impl EdgeRule {
    /// Returns the share of the area of a point's fan of eight triangles that carries the angle defect at its tip.
    ///
    /// With chords the fan is a part of the polyhedron, and its tip stands for the area of one cell of the four in the
    /// fan (exactly so where the grid follows the lines of curvature). With arcs each angle of a curved triangle is
    /// larger than that of a flat one with the same sides by a third of the triangle's total curvature, whatever the
    /// grid.
    #[doc(hidden)]
    pub fn share_of_fan(self) -> f64 {
        match self {
            Self::Chord => 1.0 / 4.0,
            Self::Arc => 1.0 / 3.0,
        }
    }
}

/// Returns the length of an edge from its chord and from the bends and unit normals at its ends.
#[inline(always)]
pub(super) fn arc<R: Real, S: Space<R>>(chord: R, [a, b]: [R; 2], [m, n]: [[R; 3]; 2]) -> R {
    let (a, b) = (turn::<R, S>(a, chord), turn::<R, S>(b, chord));
    let square = R::of(0.5) * (a + b).abs() * max(a * b, R::zero()).sqrt();
    let apart = [n[0] - m[0], n[1] - m[1], n[2] - m[2]];
    let next = dot(apart, apart) * R::of(1.0 / 180.0) - square * R::of(1.0 / 1152.0);
    let arc = chord + chord * (square * (R::of(1.0 / 24.0) + next));
    if chord > R::zero() { arc } else { chord }
}

/// Returns the angle in radians by which a bend turns a chord, limited to one radian, since coarser samples do not
/// show the curve.
#[inline(always)]
fn turn<R: Real, S: Space<R>>(bend: R, chord: R) -> R {
    let turn = if S::HAS_EVEN_STEPS { bend / chord } else { bend * chord };
    min(max(turn, -R::one()), R::one())
}

/// Returns the bend at the last point of a line from the bends at the next two points inwards, each
/// [`Real::FAR`] if unknown. The result is the smaller bend if both are to the same side, else 0: a single
/// bend may be a crease.
#[inline(always)]
pub(super) fn end_bend<R: Real>(next: R, after: R) -> R {
    let smaller = if next.abs() < after.abs() { next } else { after };
    let is_known = (next < R::FAR) & (after < R::FAR);
    if is_known & ((next > R::zero()) == (after > R::zero())) { smaller } else { R::zero() }
}

/// Returns the bends at a point along the lines of [`STORED`]. `ways` are the vectors to its eight neighbours, `there`
/// marks the existing neighbours, and `normal` is the surface normal. A bend is [`Real::FAR`] where a neighbour on the
/// line is missing.
#[inline(always)]
pub(super) fn bends<R: Real, S: Space<R>>(
    ways: [[R; 3]; 8],
    there: [bool; 8],
    normal: [R; 3],
) -> [R; 4] {
    let mut bends = [R::zero(); 4];
    for k in 0..4 {
        let (to, back) = (STORED[k] as usize, STORED[k].opposite() as usize);
        let mut bend = dot(sum(ways[to], ways[back]), normal);
        if !S::HAS_EVEN_STEPS {
            let square = R::of(0.5) * (dot(ways[to], ways[to]) + dot(ways[back], ways[back]));
            bend = if square > R::zero() { bend / square } else { R::zero() };
        }
        bends[k] = if there[to] & there[back] { bend } else { R::FAR };
    }
    bends
}

/// Returns the surface's unit normal from the vectors to the neighbours, which are zero for missing ones. The
/// result is zero where the grid has no normal (at a pole, beside two holes).
#[inline(always)]
pub(super) fn normal<R: Real, S: Space<R>>(ways: [[R; 3]; 8]) -> [R; 3] {
    let [ux, uy, uz] = along::<R, S>(ways, Direction::East);
    let [vx, vy, vz] = along::<R, S>(ways, Direction::North);
    let cross = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    // Where grid lines meet at less than a thousandth of a radian, rounding would turn the normal.
    let is_known = dot(cross, cross) > R::of(1e-6);
    let [x, y, z] = unit(cross);
    let zero = R::zero();
    [
        if is_known { x } else { zero },
        if is_known { y } else { zero },
        if is_known { z } else { zero },
    ]
}

/// Returns the unit vector along a grid line, or zero. On surfaces whose steps are not even (`HAS_EVEN_STEPS`), the
/// shorter of two steps counts more, as in the derivative of a parabola.
#[inline(always)]
fn along<R: Real, S: Space<R>>(ways: [[R; 3]; 8], to: Direction) -> [R; 3] {
    let (mut ahead, mut behind) = (ways[to as usize], ways[to.opposite() as usize]);
    if !S::HAS_EVEN_STEPS {
        let squares = [dot(ahead, ahead), dot(behind, behind)];
        let both = squares[0] + squares[1];
        let there = min(squares[0], squares[1]) > R::zero();
        for axis in 0..3 {
            ahead[axis] = if there { ahead[axis] * (squares[1] / both) } else { ahead[axis] };
            behind[axis] = if there { behind[axis] * (squares[0] / both) } else { behind[axis] };
        }
    }
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
    use crate::{Chart, EdgeLengths, MetricTensor, Spacing, Surface, builtin::Builtin};

    fn edges(surface: &Surface, rule: EdgeRule) -> EdgeLengths<f64> {
        EdgeLengths::new(&surface.clone().with_edge_rule(rule)).unwrap()
    }

    /// Returns a cylinder of radius 1 with grid lines along and across it, 0.1 radians and 0.1 apart.
    fn cylinder(rows: usize, cols: usize) -> Surface {
        let point = |index: usize| {
            let (row, col) = Chart { rows, cols }.position(index);
            let (angle, along) = (0.1 * col as f64, 0.1 * row as f64);
            DVec3::new(angle.cos(), angle.sin(), along)
        };
        Surface::from_positions(rows, cols, (0..rows * cols).map(point).collect()).unwrap()
    }

    /// Returns the number of surface points on the grid line through both ends of an edge.
    fn points_on_line(surface: &Surface, row: usize, col: usize, to: Direction) -> usize {
        let on = |to: Direction| {
            let line = surface.chart().walk((row, col), to);
            line.take_while(|&(row, col)| surface.has(row, col)).count()
        };
        on(to) + on(to.opposite()) - 1
    }

    #[test]
    fn arcs_of_a_cylinder_are_as_long_as_on_the_unrolled_one_at_holes_and_borders_too() {
        let mut mask = [true; 9 * 11];
        mask[4 * 11 + 3] = false;
        for mask in [[true; 9 * 11], mask] {
            let surface = cylinder(9, 11).with_mask(&mask).unwrap();
            let edges = edges(&surface, EdgeRule::Arc);
            for (row, col) in surface.chart().places() {
                for to in STORED {
                    let length = edges.length(row, col, to);
                    let exact = 0.1 * to.vector().length();
                    if length >= f64::FAR {
                        continue;
                    }
                    // Across the axis the chord is too short by 4e-4; a line of three points keeps its chords. Arcs
                    // leave an error of 7e-10, or 3e-7 at the border, where the normals used are those half an edge
                    // inwards.
                    let is_arc = points_on_line(&surface, row, col, to) > 3;
                    let inside = (2..7).contains(&row) && (2..9).contains(&col);
                    let tolerance = match is_arc {
                        true if inside && surface.points() == 9 * 11 => 1e-9,
                        true => 1e-6,
                        false => 5e-4,
                    };
                    assert_relative_eq!(length, exact, max_relative = tolerance);
                    assert!(is_arc || to.vector().y == 0.0 || length < exact * (1.0 - 1e-5));
                }
            }
        }
    }

    #[test]
    fn arcs_are_measured_along_the_surface_not_along_grid_lines() {
        // A polar grid of a plane: circles bend, but the plane is flat.
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
        // Roofs with a ridge along a column, a flat roof with steep sides, and stairs.
        let roofs: [fn(f64, f64) -> f64; 5] = [
            |_, x| (x - 4.0).abs(),
            // A ridge beside the border, and one a column further.
            |_, x| (x - 1.0).abs(),
            |_, x| (x - 2.0).abs(),
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
    fn lines_bend_at_their_ends_by_the_smaller_of_the_next_two_bends() {
        for (next, after, expected) in [
            (0.2, 0.3, 0.2),
            (-0.3, -0.1, -0.1),
            (0.2, -0.1, 0.0),
            (0.2, 0.0, 0.0),
            (f64::FAR, 0.1, 0.0),
            (0.1, f64::FAR, 0.0),
        ] {
            assert_eq!(end_bend(next, after), expected, "{next} {after}");
        }
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
        // The points at a pole coincide.
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
    fn arcs_of_metrics_and_planes_are_chords() {
        let tensor = |i: usize| MetricTensor { rr: 1.0 + i as f64, rc: 0.1, cc: 2.0 };
        let metric = Surface::from_metric(5, 5, (0..25).map(tensor).collect()).unwrap();
        for surface in [metric, Builtin::ShearedPlane { degrees: 60.0 }.surface(9, 9).unwrap()] {
            assert_same(&edges(&surface, EdgeRule::Chord), &edges(&surface, EdgeRule::Arc));
        }
    }
}
