//! Rows of grid points, in the form that the measurement of edges needs.

use glam::DVec3;
use rayon::prelude::*;

use super::Surface;
use super::geometry::{Point, bounds};
use super::real::Real;

impl Surface {
    /// Returns the middle of the surface. Positions relative to this point keep more digits in single
    /// precision.
    #[doc(hidden)]
    pub fn origin(&self) -> DVec3 {
        let chart = self.chart();
        let row_bounds = |row| self.geometry().row_bounds(chart, row, self.present());
        let (low, high) = (0..chart.rows)
            .into_par_iter()
            .map(row_bounds)
            .reduce(|| bounds([]), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        if low.is_finite() { 0.5 * (low + high) } else { DVec3::ZERO }
    }

    /// Returns a row of grid points, with an additional point at either end. `row` may lie beyond the border.
    /// Places that the chart does not have become missing points.
    pub(super) fn row<R: Real>(&self, row: isize, origin: DVec3) -> Row<R> {
        let chart = self.chart();
        let Row(mut points) = Row::missing(chart.cols);
        for at in 0..chart.cols + 2 {
            if let Some((row, col)) = chart.at(row, at as isize - 1) {
                let point = self.point(chart.index(row, col), origin);
                for (array, value) in points.iter_mut().zip(point) {
                    array[at] = value;
                }
            }
        }
        Row(points)
    }
}

/// A row of grid points, with an additional point before the first and after the last. Each component of
/// a point has an array of its own.
pub(super) struct Row<R>([Vec<R>; 4]);

impl<R: Real> Row<R> {
    /// Returns a row of `points` missing points.
    pub(super) fn missing(points: usize) -> Self {
        Self([(); 4].map(|_| vec![R::zero(); points + 2]))
    }

    /// Returns the number of grid points, without the additional ones.
    pub(super) fn len(&self) -> usize {
        self.0[0].len() - 2
    }

    /// Returns `points` points from index `first` on. The index counts from the point before the row's first
    /// one.
    #[inline(always)]
    pub(super) fn part(&self, first: usize, points: usize) -> [&[R]; 4] {
        self.0.each_ref().map(|values| &values[first..][..points])
    }

    /// Returns `points` points with an additional point at each end. The index `first` counts from the row's
    /// first point.
    #[inline(always)]
    pub(super) fn window(&self, first: usize, points: usize) -> Window<'_, R> {
        Window(self.part(first, points + 2))
    }
}

/// A part of a row. Indices count from the point before the part's first point.
#[derive(Clone, Copy)]
pub(super) struct Window<'a, R>([&'a [R]; 4]);

impl<R: Real> Window<'_, R> {
    #[inline(always)]
    pub(super) fn at(&self, i: usize) -> Point<R> {
        let [x, y, z, slowness] = self.0;
        [x[i], y[i], z[i], slowness[i]]
    }
}
