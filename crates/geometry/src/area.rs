//! Computes areas on a surface.

use rayon::prelude::*;

use geosweep_surface::Surface;
use geosweep_surface::triangles;

/// Computes the area of a surface, in the surface's unit squared.
///
/// The area is the sum over the triangles of the grid. Each cell is split along its diagonal from north-west
/// to south-east; a cell with one missing corner counts as a single triangle. A slowness does not change the
/// area.
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
    // The sum runs in row order, so that it does not depend on the number of threads.
    let rows: Vec<f64> = rows(surface).map(of_row).collect();
    rows.into_iter().sum()
}

/// Returns the indices of the rows of cells.
pub(super) fn rows(surface: &Surface) -> impl IndexedParallelIterator<Item = usize> {
    surface.chart().rows_of_cells().into_par_iter()
}

/// Returns the triangles of the row `row` of cells, each with its area. `there` tells which points exist.
pub(super) fn of_triangles(
    surface: &Surface,
    row: usize,
    there: impl Fn(usize) -> bool,
) -> impl Iterator<Item = ([usize; 3], f64)> {
    let (chart, geometry) = (surface.chart(), surface.geometry());
    chart.cells_of_row(row).flat_map(move |cell| {
        let corners = cell.indices(chart);
        let points = move |triangle: &[usize; 3]| triangle.map(|corner| corners[corner]);
        let triangles = triangles(corners.map(&there), true).iter().map(points);
        triangles.map(move |points| (points, geometry.triangle_area(chart, points)))
    })
}
