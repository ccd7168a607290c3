//! Repeats lines of the grid beyond seams, where obtuse triangles need them.
//!
//! An obtuse triangle is split by grid points some steps away, which solvers look for on the grid
//! (`unfold.rs`). Beside a seam these points lie on the other side. So solvers get a wider grid, on which at least one
//! copy of each point is surrounded by all points that may split its triangles.

use std::borrow::Cow;
use std::sync::Arc;

use super::super::{Chart, EdgeLengths, Seed, Surface};
use super::lattice::Lattice;
use super::{Glued, Groups};
use crate::Targets;
use crate::constants::SPLIT_REACH;

/// The grid on which solvers compute the maps of a surface.
#[derive(Clone, Debug)]
pub struct SolverGrid<'a> {
    surface: Cow<'a, Surface>,
    /// The surface's own grid.
    chart: Chart,
    /// Row and column, on the solver's grid, of the first point of the surface's own grid.
    first: (usize, usize),
}

impl Surface {
    /// Returns the grid for solvers. It is the surface's own grid, unless there are obtuse triangles beside a seam over
    /// which the grid goes on.
    #[doc(hidden)]
    pub fn solver_grid(&self) -> SolverGrid<'_> {
        let lattice = self.lattice();
        if lattice != Lattice::default() && self.has_obtuse_triangles_beside(lattice) {
            return self.wider_grid(lattice);
        }
        self.own_grid()
    }

    /// Returns the grid itself, for solvers that need no points beyond seams.
    #[doc(hidden)]
    pub fn own_grid(&self) -> SolverGrid<'_> {
        SolverGrid { surface: Cow::Borrowed(self), chart: self.chart, first: (0, 0) }
    }

    /// Returns whether a seam has obtuse triangles so near that points beyond it may split them.
    fn has_obtuse_triangles_beside(&self, lattice: Lattice) -> bool {
        let reach = REACH as isize;
        let whole = |points: usize, goes_on: Option<bool>| match goes_on {
            Some(_) => -reach..points as isize + reach,
            None => 0..points as isize,
        };
        let [rows, cols] = [(self.rows(), lattice.rows), (self.cols(), lattice.cols)]
            .map(|(points, goes_on)| whole(points, goes_on));
        let beside = -reach..reach + 1;
        let of_cols = lattice.cols.map(|_| (rows, beside.clone()));
        let of_rows = lattice.rows.map(|_| (beside, cols));
        of_cols.into_iter().chain(of_rows).any(|(rows, cols)| {
            let strip = self.beyond(&lattice, rows, cols);
            // Errors are left to the solver, which reports edges that are too long when it measures the surface.
            let edges = EdgeLengths::<f64>::measured_from(&strip, self.origin(), &|| true);
            edges.is_ok_and(|edges| edges.has_obtuse_triangles())
        })
    }

    /// Returns the surface with more rows and columns beyond its seams.
    fn wider_grid(&self, lattice: Lattice) -> SolverGrid<'_> {
        let overlap = [lattice.rows, lattice.cols].map(|side| side.map_or(0, |_| REACH));
        let span = |points: usize, beyond: usize| -(beyond as isize)..(points + beyond) as isize;
        let (rows, cols) = (span(self.rows(), overlap[0]), span(self.cols(), overlap[1]));
        let mut wide = self.beyond(&lattice, rows.clone(), cols.clone());
        let chart = wide.chart;
        let home = |(row, col)| {
            let (row, col) = self.first_copy(self.continued(row, col)?);
            Some(chart.index(row + overlap[0], col + overlap[1]))
        };
        let places = rows.flat_map(|row| cols.clone().map(move |col| (row, col)));
        let pairs = places.enumerate().filter_map(|(index, at)| Some([home(at)?, index]));
        let groups = Groups::of(pairs.filter(|[home, index]| home != index));
        wide.glued = Some(Arc::new(Glued { groups, lattice: Lattice { overlap, ..lattice } }));
        SolverGrid { surface: Cow::Owned(wide), chart: self.chart, first: overlap.into() }
    }
}

/// Number of lines beyond a seam whose points may split a triangle.
const REACH: usize = SPLIT_REACH as usize;

impl SolverGrid<'_> {
    /// Returns the surface on the solver's grid.
    #[doc(hidden)]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Returns whether the grid has more lines than the surface's own grid.
    #[doc(hidden)]
    pub fn is_wider(&self) -> bool {
        matches!(self.surface, Cow::Owned(_))
    }

    /// Moves a seed from the surface's own grid to the solver's grid.
    #[doc(hidden)]
    pub fn seed(&self, mut seed: Seed) -> Seed {
        let (down, right) = self.first;
        let by = glam::DVec2::new(down as f64, right as f64);
        seed.row += down;
        seed.col += right;
        seed.from = seed.from.map(|from| from + by);
        seed.origin = seed.origin.map(|origin| origin.moved(by));
        seed
    }

    /// Moves targets from the surface's own grid to the solver's grid.
    #[doc(hidden)]
    pub fn targets(&self, targets: Targets) -> Targets {
        targets.moved([self.first.0, self.first.1])
    }

    /// Returns the grid of the surface itself.
    #[doc(hidden)]
    pub fn chart(&self) -> Chart {
        self.chart
    }

    /// Returns the indices on the solver's grid of points that are given by their indices on the surface's own grid,
    /// with `None` for holes.
    #[doc(hidden)]
    pub fn points(&self, points: &[usize]) -> Vec<Option<usize>> {
        let present = self.surface.present();
        let index = |&point: &usize| Some(self.index(point)).filter(|&index| present[index]);
        points.iter().map(index).collect()
    }

    /// Returns the index on the solver's grid of a point of the surface.
    fn index(&self, index: usize) -> usize {
        let (row, col) = self.chart.position(index);
        self.surface.chart().index(row + self.first.0, col + self.first.1)
    }

    /// Returns the index of a point of the surface, given its index on the solver's grid, or `None` if the surface's
    /// own grid does not have it.
    #[doc(hidden)]
    pub fn own(&self, index: usize) -> Option<usize> {
        let (row, col) = self.surface.chart().position(index);
        let (row, col) = (row.checked_sub(self.first.0)?, col.checked_sub(self.first.1)?);
        (row < self.chart.rows && col < self.chart.cols).then(|| self.chart.index(row, col))
    }

    /// Returns the values at the surface's own points, given the values at the points of the solver's grid.
    #[doc(hidden)]
    pub fn crop<T: Copy>(&self, values: Vec<T>) -> Vec<T> {
        if !self.is_wider() {
            return values;
        }
        let lines = (0..self.chart.rows).map(|row| self.index(row * self.chart.cols));
        lines.flat_map(|first| &values[first..][..self.chart.cols]).copied().collect()
    }

    /// Writes the values at the surface's own points, given the values at the points of the solver's grid.
    #[doc(hidden)]
    pub fn crop_into<T: Copy>(&self, values: &[T], into: &mut [T]) {
        for (row, own) in into.chunks_exact_mut(self.chart.cols).enumerate() {
            let first = self.index(row * self.chart.cols);
            own.copy_from_slice(&values[first..][..self.chart.cols]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::Closed;
    use crate::{Direction, Gluing, Spacing};

    /// Returns a surface whose columns have the heights 0 and `step` in turn. The last column repeats the first.
    fn corrugated(step: f64) -> Surface {
        let heights = (0..9 * 13).map(|index| step * f64::from(index % 13 % 12 % 2));
        Surface::from_heights(9, 13, heights.collect(), Spacing::square(1.0)).unwrap()
    }

    #[test]
    fn only_obtuse_triangles_beside_seams_make_the_grid_wider() {
        let is_wider = |surface: Surface| surface.solver_grid().is_wider();
        let sheared = |gluing: Option<Gluing>, from: usize| {
            // Heights rise along rows and columns, which makes triangles obtuse.
            let heights = (0..30 * 41).map(|index| {
                let (row, col) = (index / 41, index % 41);
                let inside = (from..40 - from).contains(&(col % 40));
                if inside { 3.0 * (row + col) as f64 } else { 0.0 }
            });
            let open = Surface::from_heights(30, 41, heights.collect(), Spacing::square(1.0));
            gluing
                .map_or_else(
                    || open.clone(),
                    |gluing| open.clone().and_then(|s| s.with_gluing(gluing)),
                )
                .unwrap()
        };
        for closed in Closed::ALL {
            assert!(!is_wider(closed.surface(61, 61).unwrap()), "{}", closed.name());
        }
        assert!(!is_wider(corrugated(0.0).with_gluing(Gluing::columns()).unwrap()));
        assert!(!is_wider(sheared(None, 1)));
        assert!(is_wider(sheared(Some(Gluing::columns()), 1)));
        assert!(!is_wider(sheared(Some(Gluing::columns()), 12)));
    }

    #[test]
    fn points_of_the_wider_grid_are_copies_with_equal_edges() {
        for gluing in [Gluing::columns(), Gluing::flipped_columns(), Gluing::both()] {
            let surface = corrugated(4.0).with_gluing(gluing).unwrap();
            let grid = surface.wider_grid(surface.lattice());
            let [edges, wide] =
                [&surface, grid.surface()].map(|surface| EdgeLengths::<f32>::new(surface).unwrap());
            let own = |(row, col): (usize, usize)| {
                let (row, col) =
                    (row as isize - grid.first.0 as isize, col as isize - grid.first.1 as isize);
                surface.first_copy(surface.continued(row, col).unwrap())
            };
            let length = |from, to| {
                let chart = surface.chart();
                let starts = chart.places().filter(|&at| surface.first_copy(at) == from);
                let mut ends = starts.flat_map(|(row, col)| {
                    Direction::ALL.into_iter().filter_map(move |way| {
                        Some(((row, col), way, chart.neighbour(row, col, way)?))
                    })
                });
                let found = ends.find(|&(.., end)| surface.first_copy(end) == to);
                found.map(|((row, col), way, _)| edges.length(row, col, way))
            };
            for (row, col) in wide.chart().places() {
                for way in Direction::ALL {
                    let Some(end) = wide.chart().neighbour(row, col, way) else { continue };
                    assert_eq!(Some(wide.length(row, col, way)), length(own((row, col)), own(end)));
                }
            }
            let numbers: Vec<_> = grid.surface().chart().places().map(own).collect();
            assert!(
                grid.crop(numbers)
                    .into_iter()
                    .eq(surface.chart().places().map(|at| surface.first_copy(at)))
            );
        }
    }
}
