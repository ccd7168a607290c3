//! Computes the tangent vectors and the metric of a surface at its grid points and between them.

use glam::{DMat2, DVec2, DVec3};

use geosweep_surface::Surface;
use geosweep_surface::{Cell, Direction, Geometry, corner_weights};

/// The metric of a surface at a place, in steps of rows and columns, and the tangent vectors of such steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub metric: DMat2,
    /// The derivatives of the position by row and by column; `None` if the surface is given by its metric.
    pub tangents: Option<[DVec3; 2]>,
}

impl Frame {
    /// Returns the frame at a grid point that is present.
    pub(super) fn at_point(surface: &Surface, row: usize, col: usize) -> Self {
        if let Geometry::Metric(metric) = surface.geometry() {
            let tensor = metric[surface.chart().index(row, col)];
            return Self { metric: matrix(tensor.rr, tensor.rc, tensor.cc), tangents: None };
        }
        let along = |to| tangent(surface, (row, col), to);
        Self::of([along(Direction::South), along(Direction::East)])
    }

    fn of(tangents: [DVec3; 2]) -> Self {
        let [rows, cols] = tangents;
        let metric = matrix(rows.dot(rows), rows.dot(cols), cols.dot(cols));
        Self { metric, tangents: Some(tangents) }
    }

    /// Returns the frame at a place of the surface, given as fractional row and column.
    pub(super) fn at(surface: &Surface, at: DVec2) -> Self {
        let cell = surface.chart().cell_at(at);
        if cell.inside(at) == DVec2::ZERO {
            let (row, col) = cell.north_west();
            return Self::at_point(surface, row, col);
        }
        let mut sum = [0.0; 9];
        for (row, col, weight) in weights(surface, cell, at) {
            let numbers = Self::at_point(surface, row, col).numbers();
            sum = std::array::from_fn(|k| sum[k] + weight * numbers[k]);
        }
        let [a, b, c, d, e, f, rr, rc, cc] = sum;
        match surface.geometry() {
            Geometry::Metric(_) => Self { metric: matrix(rr, rc, cc), tangents: None },
            _ => Self::of([DVec3::new(a, b, c), DVec3::new(d, e, f)]),
        }
    }

    fn numbers(&self) -> [f64; 9] {
        let [rows, cols] = self.tangents.unwrap_or_default();
        let [[rr, rc], [_, cc]] = self.metric.to_cols_array_2d();
        [rows.x, rows.y, rows.z, cols.x, cols.y, cols.z, rr, rc, cc]
    }

    /// Returns the length of a step of rows and columns.
    pub(super) fn length(&self, step: DVec2) -> f64 {
        step.dot(self.metric * step).max(0.0).sqrt()
    }

    /// Returns the cosine of the angle between two steps.
    pub(super) fn cosine(&self, a: DVec2, b: DVec2) -> f64 {
        a.dot(self.metric * b) / (self.length(a) * self.length(b))
    }

    /// Returns an orthonormal basis as steps of rows and columns: in the direction of increasing columns, and at a
    /// right angle to it on the side of increasing rows. Returns `None` where the grid has no tangent plane.
    pub(super) fn basis(&self) -> Option<[DVec2; 2]> {
        let along = DVec2::Y / self.length(DVec2::Y);
        let across = DVec2::X - along * along.dot(self.metric * DVec2::X);
        let across = across / self.length(across);
        (along.is_finite() && across.is_finite()).then_some([along, across])
    }

    /// Returns the step of rows and columns along a vector in space. Returns `None` at a pole, and if the surface is
    /// given by its metric.
    pub(super) fn step(&self, way: DVec3) -> Option<DVec2> {
        let [rows, cols] = self.tangents?;
        let step = self.metric.inverse() * DVec2::new(rows.dot(way), cols.dot(way));
        step.is_finite().then_some(step)
    }

    /// Returns a step of rows and columns as a vector in space.
    pub(super) fn in_space(&self, step: DVec2) -> Option<DVec3> {
        let [rows, cols] = self.tangents?;
        Some(step.x * rows + step.y * cols)
    }
}

/// Returns the position in space of a place of the surface, given as fractional row and column. Returns `None` if the
/// surface is given by its metric.
pub(super) fn position(surface: &Surface, at: DVec2) -> Option<DVec3> {
    let points = weights(surface, surface.chart().cell_at(at), at).into_iter();
    points.map(|(row, col, weight)| Some(surface.position(row, col)? * weight)).sum()
}

fn matrix(rr: f64, rc: f64, cc: f64) -> DMat2 {
    DMat2::from_cols_array(&[rr, rc, rc, cc])
}

/// Returns the derivative of the position along a grid line, of the fourth order if the point is one of five successive
/// points of the line. The derivative is zero at a point without neighbours on the line.
fn tangent(surface: &Surface, from: (usize, usize), to: Direction) -> DVec3 {
    let point = |k: isize| {
        let (row, col) = surface.chart().along(from, to, k)?;
        surface.position(row, col)
    };
    let Some(here) = point(0) else { return DVec3::ZERO };
    let reach = |side: isize| (1..=4).take_while(|&k| point(side * k).is_some()).count();
    let (back, ahead) = (reach(-1), reach(1));
    let sum = |side: isize, weights: &[f64]| -> DVec3 {
        let term = |(k, weight): (isize, &f64)| {
            *weight * (point(side * k).unwrap_or(here) - here) * side as f64
        };
        (-1..).zip(weights).map(term).sum()
    };
    match (back, ahead) {
        (2.., 2..) => {
            let across = |k: isize| point(k).unwrap_or(here) - point(-k).unwrap_or(here);
            (8.0 * across(1) - across(2)) / 12.0
        }
        (1, 3..) => sum(1, &BESIDE_END),
        (3.., 1) => sum(-1, &BESIDE_END),
        (0, 4..) => sum(1, &AT_END),
        (4.., 0) => sum(-1, &AT_END),
        (1.., 1..) => sum(1, &[-0.5, 0.0, 0.5]),
        (0, 2..) => sum(1, &[0.0, 0.0, 2.0, -0.5]),
        (2.., 0) => sum(-1, &[0.0, 0.0, 2.0, -0.5]),
        (0, 1) => sum(1, &[0.0, 0.0, 1.0]),
        (1, 0) => sum(-1, &[0.0, 0.0, 1.0]),
        (0, 0) => DVec3::ZERO,
    }
}

/// The weights of the points -1, 0, 1, 2 and 3 in the derivative at 0, beside the end of a line.
const BESIDE_END: [f64; 5] = [-3.0 / 12.0, -10.0 / 12.0, 18.0 / 12.0, -6.0 / 12.0, 1.0 / 12.0];
/// The weights of the points -1, which is missing, and 0 to 4 at the end of a line.
const AT_END: [f64; 6] = [0.0, -25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25];

/// Returns grid points around a place of a cell with their weights: sixteen, if they all are on the surface,
/// or the corners of the cell.
fn weights(surface: &Surface, cell: Cell, at: DVec2) -> Vec<(usize, usize, f64)> {
    let lines = |first: usize, share: f64| -> Vec<(Option<usize>, f64)> {
        let line = |k: usize| (first + k).checked_sub(1);
        let weights = if share == 0.0 { [0.0, 1.0, 0.0, 0.0] } else { cubic(share) };
        (0..4).filter(|&k| weights[k] != 0.0).map(|k| (line(k), weights[k])).collect()
    };
    let ((row, col), inside) = (cell.north_west(), cell.inside(at));
    let (rows, cols) = (lines(row, inside.x), lines(col, inside.y));
    let product = rows
        .iter()
        .flat_map(|&(row, a)| cols.iter().map(move |&(col, b)| Some((row?, col?, a * b))));
    let on_surface = |&(row, col, _): &(usize, usize, f64)| surface.has(row, col);
    let sixteen: Option<Vec<_>> = product.map(|point| point.filter(on_surface)).collect();
    sixteen.unwrap_or_else(|| {
        let corners = cell.corners();
        let there = corners.map(|(row, col)| surface.has(row, col));
        let weights = corner_weights(there, inside).unwrap_or([0.25; 4]);
        let corners = corners.into_iter().zip(weights).zip(there);
        corners.filter(|(_, there)| *there).map(|(((row, col), w), _)| (row, col, w)).collect()
    })
}

/// Returns the weights of Lagrange's cubic through -1, 0, 1 and 2.
pub(super) fn cubic(x: f64) -> [f64; 4] {
    [
        -x * (x - 1.0) * (x - 2.0) / 6.0,
        (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
        -(x + 1.0) * x * (x - 2.0) / 2.0,
        (x + 1.0) * x * (x - 1.0) / 6.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use geosweep_surface::builtin::Builtin;

    #[test]
    fn tangents_of_the_sphere_are_tangent_and_as_long_as_exact_steps() {
        let sphere = Builtin::Sphere.surface(129, 129).unwrap();
        for at in [[64.0, 64.0], [20.0, 101.0], [20.25, 101.5], [126.9, 3.1]] {
            let frame = Frame::at(&sphere, DVec2::from_array(at));
            for axis in [DVec2::X, DVec2::Y] {
                let ends = [-1e-3, 1e-3].map(|k| (DVec2::from_array(at) + k * axis).to_array());
                let step =
                    Builtin::Sphere.exact_distance(129, 129, ends[0], ends[1]).unwrap() / 2e-3;
                assert_abs_diff_eq!(frame.length(axis) / step, 1.0, epsilon = 3e-6);
            }
        }
    }

    #[test]
    fn the_basis_is_orthonormal_and_begins_along_the_columns() {
        let surface = Builtin::ShearedPlane { degrees: 30.0 }.surface(9, 9).unwrap();
        let frame = Frame::at(&surface, DVec2::new(3.5, 4.0));
        let [along, across] = frame.basis().unwrap();
        assert_eq!((along.x, along.y > 0.0, across.x > 0.0), (0.0, true, true));
        assert_abs_diff_eq!(frame.length(along), 1.0, epsilon = 1e-12);
        assert_abs_diff_eq!(frame.length(across), 1.0, epsilon = 1e-12);
        assert_abs_diff_eq!(frame.cosine(along, across), 0.0, epsilon = 1e-12);
    }
}
