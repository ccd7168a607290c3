//! Detects floor plans: flat surfaces whose points are evenly spaced.

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use super::{ANCHORS, Chart, EvenGrid, Surface, kept};

impl Surface {
    /// Returns whether the surface is a floor plan: a flat, evenly spaced grid without a slowness and without gluing,
    /// with or without holes. The grid may be sheared as long as no triangle of neighbours is obtuse. The maximum size
    /// is about 30 million points. From point sources over a floor plan, [`crate::Wavefront::Anchored`] is exact.
    ///
    /// ```
    /// use geosweep::{Spacing, Surface};
    /// let floor = Surface::from_heights(3, 4, vec![1.0; 12], Spacing { dx: 0.5, dy: 0.25 })?;
    /// assert!(floor.is_floor_plan());
    /// let mut heights = vec![1.0; 12];
    /// heights[5] = 1.1;
    /// assert!(!Surface::from_heights(3, 4, heights, Spacing { dx: 0.5, dy: 0.25 })?.is_floor_plan());
    /// # Ok::<(), geosweep::surface::SurfaceError>(())
    /// ```
    pub fn is_floor_plan(&self) -> bool {
        self.floor().is_some()
    }

    /// Returns the even grid of a floor plan.
    #[doc(hidden)]
    pub fn floor(&self) -> Option<EvenGrid> {
        let grid = || self.even_grid().filter(|grid| !grid.is_obtuse());
        // A path runs straight through the chart from its anchor to a point. This fails across seams.
        let is_open = has_numbers(self.chart) && !self.is_glued();
        *kept(&self.known.floor, || is_open.then(grid).flatten())
    }

    /// Fits an even grid to the surface by least squares. Returns `None` if the surface is not such a grid,
    /// has a slowness or no positions, or if its points lie on a line.
    pub(super) fn even_grid(&self) -> Option<EvenGrid> {
        if self.is_weighted() {
            return None;
        }
        // On most other surfaces a sample of the points, relative to one of them, already rules out an even
        // grid.
        let few = |lines: usize| (lines / FEW).max(1);
        let first = self.present().iter().position(|&is| is)?;
        let (row, col) = self.chart().position(first);
        let origin = self.position(row, col)?;
        let sample = Fit::of(self, origin, [few(self.rows()), few(self.cols())]);
        if sample.grid().is_some_and(|grid| !sample.is_even(self, grid, 4.0 * NEAR)) {
            return None;
        }
        let all = Fit::of(self, self.origin(), [1, 1]);
        all.grid().filter(|&grid| all.is_even(self, grid, NEAR))
    }
}

/// Maximum number of rows and columns that engines store around a grid.
pub(super) const AROUND: usize = 16;

/// Returns whether fronts can carry the numbers of all points of a grid.
pub(super) fn has_numbers(chart: Chart) -> bool {
    (chart.rows + AROUND) * (chart.cols + AROUND) <= ANCHORS / 2
}

/// Largest distance of a position from an even grid, relative to the grid's extent: the rounding of single
/// precision.
const NEAR: f64 = 1e-7;

/// Number of rows and of columns in a sample.
const FEW: usize = 16;

/// Sums over points, from which the least-squares grid follows. Places are relative to the middle of the
/// grid, and positions to `origin`.
#[derive(Clone, Copy, Default)]
struct Fit {
    /// Step from a sampled row to the next, and from a sampled column to the next.
    every: [usize; 2],
    /// The middle of the surface, or one of its points for the fit to a sample.
    origin: DVec3,
    count: f64,
    place: DVec2,
    position: DVec3,
    squares: DMat2,
    products: [DVec3; 2],
}

impl Fit {
    fn of(surface: &Surface, origin: DVec3, every: [usize; 2]) -> Self {
        // The default matrix is not zero.
        let none = Self { every, origin, squares: DMat2::ZERO, ..Self::default() };
        let of_row = |row| {
            none.row(surface, row).fold(none, |fit, (place, position)| {
                let squares = DMat2::from_cols(place * place.x, place * place.y);
                let products = [position * place.x, position * place.y];
                fit.and(Self { count: 1.0, place, position, squares, products, ..none })
            })
        };
        // The sums are added in the order of rows, so that they do not depend on the number of threads.
        let rows: Vec<_> =
            (0..surface.rows()).into_par_iter().step_by(every[0]).map(of_row).collect();
        rows.into_iter().fold(none, Self::and)
    }

    /// Returns the sampled points of a row that have a position.
    fn row(self, surface: &Surface, row: usize) -> impl Iterator<Item = (DVec2, DVec3)> {
        let middle = 0.5 * DVec2::new(surface.rows() as f64, surface.cols() as f64);
        (0..surface.cols()).step_by(self.every[1]).filter_map(move |col| {
            let place = DVec2::new(row as f64, col as f64) - middle;
            Some((place, surface.position(row, col)? - self.origin))
        })
    }

    fn and(self, other: Self) -> Self {
        let [a, b] = [self.products, other.products];
        Self {
            count: self.count + other.count,
            place: self.place + other.place,
            position: self.position + other.position,
            squares: self.squares + other.squares,
            products: [a[0] + b[0], a[1] + b[1]],
            ..self
        }
    }

    /// Returns the least-squares grid, or `None` if the points lie on a line.
    fn grid(&self) -> Option<EvenGrid> {
        let (place, position) = (self.place / self.count, self.position / self.count);
        let squares = self.squares - DMat2::from_cols(self.place * place.x, self.place * place.y);
        let [a, b] = self.products;
        let products = [a - self.place.x * position, b - self.place.y * position];
        let scale = squares.x_axis.x * squares.y_axis.y;
        if self.count < 3.0 || squares.determinant() <= 1e-9 * scale {
            return None;
        }
        let inverse = squares.inverse();
        let steps = [inverse.x_axis, inverse.y_axis]
            .map(|share| products[0] * share.x + products[1] * share.y);
        (steps[0].cross(steps[1]) != DVec3::ZERO).then_some(EvenGrid { steps })
    }

    /// Returns whether all sampled points lie within `near` of `grid`, relative to the extent of the grid.
    fn is_even(&self, surface: &Surface, grid: EvenGrid, near: f64) -> bool {
        let mean = self.position / self.count - grid.at(self.place / self.count);
        let near = near * grid.length(DVec2::new(surface.rows() as f64, surface.cols() as f64));
        let is_even = |row| {
            self.row(surface, row)
                .all(|(place, position)| position.distance(mean + grid.at(place)) <= near)
        };
        (0..surface.rows()).into_par_iter().step_by(self.every[0]).all(is_even)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spacing;
    use crate::builtin::Builtin;

    #[test]
    fn planes_are_even_and_nothing_else_is() {
        for builtin in Builtin::ALL {
            let surface = builtin.surface(33, 49).unwrap();
            let is_flat =
                matches!(builtin, Builtin::Plane | Builtin::Maze | Builtin::ShearedPlane { .. });
            assert_eq!(surface.even_grid().is_some(), is_flat, "{builtin}");
        }
        let plane = || Surface::from_heights(9, 9, vec![0.0; 81], Spacing::square(1.0)).unwrap();
        assert!(plane().with_slowness(vec![1.0; 81]).unwrap().even_grid().is_none());
        let row: Vec<_> = (0..81).map(|index| index < 9).collect();
        assert!(plane().with_mask(&row).unwrap().even_grid().is_none(), "points on a line");
        let mut bumpy = vec![0.0; 81];
        bumpy[40] = 1e-3;
        let bumpy = Surface::from_heights(9, 9, bumpy, Spacing::square(1.0)).unwrap();
        assert!(bumpy.even_grid().is_none());
    }

    #[test]
    fn lengths_are_those_between_positions() {
        let surface = Builtin::ShearedPlane { degrees: 60.0 }.surface(20, 30).unwrap();
        let grid = surface.even_grid().unwrap();
        let [a, b] = [(3, 4), (17, 22)].map(|(row, col)| surface.position(row, col).unwrap());
        approx::assert_relative_eq!(
            grid.length(DVec2::new(14.0, 18.0)),
            a.distance(b),
            max_relative = 1e-13
        );
    }
}
