//! Grid points in the form in which edges are measured, on the CPU and in the shaders.

use glam::DVec3;

use super::real::Real;
use super::{Geometry, MetricTensor, Surface};

/// A grid point: position, or height in the third place, or metric (rr, rc, cc); and slowness, 0
/// in a hole.
pub(crate) type Point<R> = [R; 4];

impl Surface {
    /// A grid point in some precision. Positions and heights are taken relative to `origin`.
    pub(crate) fn point<R: Real>(&self, index: usize, origin: DVec3) -> Point<R> {
        let slowness = match (self.present()[index], self.slowness()) {
            (false, _) => 0.0,
            (true, None) => 1.0,
            (true, Some(slowness)) => slowness[index],
        };
        let [x, y, z] = match self.geometry() {
            Geometry::Positions(positions) => (positions[index] - origin).to_array(),
            Geometry::Heights { heights, .. } => [0.0, 0.0, heights[index] - origin.z],
            Geometry::Metric(metric) => {
                let MetricTensor { rr, rc, cc } = metric[index];
                [rr, rc, cc]
            }
        };
        [x, y, z, slowness].map(R::of)
    }

    /// The middle of the surface: single precision keeps more digits of positions relative to it.
    pub(crate) fn origin(&self) -> DVec3 {
        let chart = self.chart();
        let position = |index: usize| {
            let (row, col) = chart.position(index);
            self.position(row, col)
        };
        let (low, high) = (0..chart.points())
            .filter_map(position)
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), position| {
                (low.min(position), high.max(position))
            });
        if low.is_finite() { 0.5 * (low + high) } else { DVec3::ZERO }
    }

    /// From a point to its neighbour. A surface known only by its metric has no such vector.
    pub(crate) fn difference<R: Real>(
        &self,
        a: Point<R>,
        b: Point<R>,
        (down, right): (isize, isize),
    ) -> [R; 3] {
        match self.geometry() {
            Geometry::Heights { spacing, .. } => {
                let (down, right) = (R::of(down as f64), R::of(right as f64));
                [right * R::of(spacing.dx), down * R::of(spacing.dy), b[2] - a[2]]
            }
            _ => [b[0] - a[0], b[1] - a[1], b[2] - a[2]],
        }
    }

    /// Length of the straight step between two neighbouring points without slowness, in the
    /// shaders' order of operations.
    pub(crate) fn separation<R: Real>(&self, a: Point<R>, b: Point<R>, step: (isize, isize)) -> R {
        if !matches!(self.geometry(), Geometry::Metric(_)) {
            let d = self.difference(a, b, step);
            return ((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]).sqrt();
        }
        let (down, right) = (R::of(step.0 as f64), R::of(step.1 as f64));
        let two = R::of(2.0);
        let square = |g: Point<R>| {
            (g[0] * (down * down) + g[1] * (two * right * down)) + g[2] * (right * right)
        };
        let length = |g| square(g).max(R::zero()).sqrt();
        R::of(0.5) * (length(a) + length(b))
    }
}
