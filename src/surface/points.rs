//! Grid points in the form in which edges are measured, on the CPU and in the shaders.

use glam::DVec3;
use rayon::prelude::*;

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
        // A slowness too small for this precision is small, but no hole.
        let held =
            if slowness > 0.0 { R::of(slowness).max(R::min_positive_value()) } else { R::zero() };
        [R::of(x), R::of(y), R::of(z), held]
    }

    /// The middle of the surface: single precision keeps more digits of positions relative to it.
    pub(crate) fn origin(&self) -> DVec3 {
        let (chart, present) = (self.chart(), self.present());
        let row_box = |row: usize| {
            let points = chart.index(row, 0)..chart.index(row, 0) + chart.cols;
            let present = &present[points.clone()];
            match self.geometry() {
                // As they lie in memory, since this reads the whole surface once more.
                Geometry::Positions(positions) => corners(
                    positions[points].iter().zip(present).filter_map(|(&at, &is)| is.then_some(at)),
                ),
                _ => corners((0..chart.cols).filter_map(|col| self.position(row, col))),
            }
        };
        let (low, high) = (0..chart.rows)
            .into_par_iter()
            .map(row_box)
            .reduce(|| corners([]), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        if low.is_finite() { 0.5 * (low + high) } else { DVec3::ZERO }
    }

    /// A row of grid points; missing ones if the grid has no such row.
    pub(super) fn row<R: Real>(&self, row: Option<usize>, origin: DVec3) -> Row<R> {
        let chart = self.chart();
        let mut points = [(); 4].map(|_| vec![R::zero(); chart.cols + 2]);
        if let Some(row) = row.filter(|&row| row < chart.rows) {
            for col in 0..chart.cols {
                let point = self.point(chart.index(row, col), origin);
                for (array, value) in points.iter_mut().zip(point) {
                    array[col + 1] = value;
                }
            }
        }
        Row(points)
    }
}

/// The least and the largest coordinates of some positions.
fn corners(positions: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    positions.into_iter().fold(none, |(low, high), at| (low.min(at), high.max(at)))
}

/// A row of grid points, coordinate by coordinate, with a missing point before the first and after
/// the last.
pub(super) struct Row<R>([Vec<R>; 4]);

impl<R: Real> Row<R> {
    /// Number of grid points.
    pub(super) fn len(&self) -> usize {
        self.0[0].len() - 2
    }

    /// So many points from one on, counted from the one before the first.
    #[inline(always)]
    pub(super) fn part(&self, first: usize, points: usize) -> [&[R]; 4] {
        let [x, y, z, slowness] = &self.0;
        [
            &x[first..][..points],
            &y[first..][..points],
            &z[first..][..points],
            &slowness[first..][..points],
        ]
    }

    /// Some of them, with a point more at each end.
    #[inline(always)]
    pub(super) fn window(&self, first: usize, points: usize) -> Window<'_, R> {
        let [x, y, z, slowness] = &self.0;
        Window([
            &x[first..][..points + 2],
            &y[first..][..points + 2],
            &z[first..][..points + 2],
            &slowness[first..][..points + 2],
        ])
    }
}

/// Part of a row, counted from the point before its first.
#[derive(Clone, Copy)]
pub(super) struct Window<'a, R>([&'a [R]; 4]);

impl<R: Real> Window<'_, R> {
    #[inline(always)]
    pub(super) fn at(&self, i: usize) -> Point<R> {
        let [x, y, z, slowness] = self.0;
        [x[i], y[i], z[i], slowness[i]]
    }
}
