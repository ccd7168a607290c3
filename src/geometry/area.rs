//! Areas on the surface.

use glam::DVec2;
use rayon::prelude::*;

use super::triangles::{corners, triangles};
use crate::Surface;
use crate::surface::{Geometry, MetricTensor};

/// The area of a surface, in its unit squared, without any slowness: of the triangles that its
/// cells are cut into, from north-west to south-east, and of the halves of cells beside a missing
/// corner.
///
/// ```
/// use geosweep::{Spacing, Surface, geometry::area};
/// let ramp = (0..20).map(|i| f64::from(i % 5) * 1.5).collect();
/// let surface = Surface::from_heights(4, 5, ramp, Spacing::square(2.0))?;
/// assert!((area(&surface) - 6.0 * 4.0 * 2.5).abs() < 1e-12);
/// # Ok::<(), geosweep::surface::SurfaceError>(())
/// ```
pub fn area(surface: &Surface) -> f64 {
    let there = |index: usize| surface.present()[index];
    let of_row = |row| of_triangles(surface, row, there).map(|(_, area)| area).sum::<f64>();
    // In order, so that the sum does not depend on the number of threads.
    let rows: Vec<f64> = rows(surface).map(of_row).collect();
    rows.into_iter().sum()
}

/// The rows of cells.
pub(super) fn rows(surface: &Surface) -> impl IndexedParallelIterator<Item = usize> {
    (0..surface.rows().saturating_sub(1)).into_par_iter()
}

/// The triangles of a row of cells between points that are `there`, each with its area.
pub(super) fn of_triangles(
    surface: &Surface,
    row: usize,
    there: impl Fn(usize) -> bool,
) -> impl Iterator<Item = ([usize; 3], f64)> {
    let chart = surface.chart();
    (0..chart.cols.saturating_sub(1)).flat_map(move |col| {
        let corners = corners(chart, row, col);
        let points = move |triangle: &[usize; 3]| triangle.map(|corner| corners[corner]);
        let triangles = triangles(corners.map(&there), true).iter().map(points);
        triangles.map(|points| (points, triangle_area(surface, points)))
    })
}

/// The area of the triangle between three grid points: flat between positions, and with a metric
/// by the mean of the three tensors' unit areas.
pub(super) fn triangle_area(surface: &Surface, points: [usize; 3]) -> f64 {
    let chart = surface.chart();
    let places = points.map(|point| chart.position(point));
    if let Geometry::Metric(metric) = surface.geometry() {
        let unit = |point: usize| {
            let MetricTensor { rr, rc, cc } = metric[point];
            (rr * cc - rc * rc).sqrt()
        };
        let [a, b, c] = places.map(|(row, col)| DVec2::new(row as f64, col as f64));
        return points.map(unit).iter().sum::<f64>() / 6.0 * (b - a).perp_dot(c - a).abs();
    }
    let [a, b, c] = places.map(|(row, col)| surface.position(row, col).unwrap_or_default());
    0.5 * (b - a).cross(c - a).length()
}
