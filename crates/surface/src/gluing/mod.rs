//! Glues sides of the grid where the surface is closed, so that fronts pass from one to the other.
//!
//! Both sides of a seam hold its samples. Several grid points then are one point of the surface: *copies* of
//! each other. Solvers update each copy from its own side of the seam, and then give all copies of a point the earliest
//! of their fronts. So the grid needs no points beyond its sides, and nothing is interpolated.
//!
//! [`kinds`] defines what a caller may glue, [`compile`] finds which points coincide, and [`groups`] stores them.
//! [`lattice`] describes over which sides the grid goes on as a grid. Edges and curvatures are measured there as inside
//! the grid ([`strips`]). Elsewhere, at poles, folds and where charts meet at an angle, edges are measured on each side
//! by itself, and copies share the mean of their Gaussian curvatures ([`curvature`]). [`places`] finds the copies of
//! sources. [`rings`] lists the cells around copies for shaders. [`sheet`] cuts out parts that go on over seams.
//! [`solver_grid`] repeats lines beyond seams for solvers, where obtuse triangles need them. [`coarse`] glues coarser
//! grids.

mod beyond;
mod coarse;
pub(super) mod compile;
mod curvature;
mod error;
mod groups;
mod kinds;
mod lattice;
mod places;
mod rings;
mod sheet;
mod solver_grid;
pub(super) mod strips;

pub use error::GluingError;
pub use groups::Groups;
pub use kinds::{Gluing, Run};
#[doc(hidden)]
pub use lattice::Lattice;
#[doc(hidden)]
pub use rings::Ring;
#[doc(hidden)]
pub use sheet::Sheet;
#[doc(hidden)]
pub use solver_grid::SolverGrid;

use std::sync::Arc;

use super::{Chart, Known, Seam, Surface, SurfaceError};
use compile::{Compiled, twice};

/// The gluing of a surface, compiled to groups of copies.
#[derive(Clone, Debug)]
pub struct Glued {
    /// Groups of copies, by their row-major indices.
    groups: Groups,
    /// The continuation of the grid beyond its sides.
    lattice: Lattice,
}

/// Advice in the errors of functions that do not support seams.
pub const UNGLUED: &str = "leave the gluing out, and the surface is cut open there";

impl Glued {
    /// Compiles the gluing of a grid without known positions.
    ///
    /// # Errors
    /// If the grid does not have the points, or the gluing depends on positions.
    #[doc(hidden)]
    pub fn of_grid(chart: Chart, gluing: &Gluing) -> Result<Self, GluingError> {
        let Chart { rows, cols } = chart;
        // With positions, sides that do not coincide are found. Here the size is all that is known.
        if *gluing == Gluing::Octahedral && (rows != cols || rows % 2 == 0) {
            return Err(GluingError::NoOddSquare { rows, cols });
        }
        let Some(Compiled { pairs, lattice }) = Compiled::on_grid(chart, gluing)? else {
            return Err(GluingError::Unsupported {
                what: "the gluing of charts whose positions are on a device",
                instead: "name the pairs of points as Gluing::Runs",
            });
        };
        match pairs.is_empty() {
            true => Err(GluingError::Nothing),
            false => Ok(Self { groups: Groups::of(pairs), lattice }),
        }
    }

    /// Returns the groups of copies, by their row-major indices.
    #[doc(hidden)]
    pub fn groups(&self) -> &Groups {
        &self.groups
    }

    /// Returns where the grid continues beyond its sides.
    #[doc(hidden)]
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// Returns whether the two points of each pair are glued. The result is false if there are no pairs.
    fn has_glued(&self, pairs: &[[usize; 2]]) -> bool {
        let is_one = |pair: &[usize; 2]| {
            let [a, b] = pair.map(|index| self.groups.number(index));
            pair[0] == pair[1] || a.is_some() && a == b
        };
        !pairs.is_empty() && pairs.iter().all(is_one)
    }
}

impl Surface {
    /// Glues sides of the grid, so that fronts pass from one side to the other. A second gluing adds to the first.
    ///
    /// Points that are glued must coincide up to a twentieth of an edge and of the seam's size; each takes the position
    /// of its first copy. Heights and metrics of copies must agree in the same way, and slownesses to a thousandth; each
    /// point takes those of its first copy. A point becomes a hole if any of its copies is one.
    ///
    /// # Errors
    /// [`GluingError`], in [`SurfaceError::Gluing`], if the points do not coincide or the grid does not have
    /// them.
    pub fn with_gluing(mut self, gluing: Gluing) -> Result<Self, SurfaceError> {
        let before = self.glued.take();
        let Compiled { pairs, lattice } = self.compile(&gluing)?;
        if before.as_ref().is_some_and(|before| before.has_glued(&pairs)) {
            return Err(twice(self.chart, pairs[0]).into());
        }
        let lattice = before.as_ref().map_or(lattice, |before| before.lattice.and(lattice));
        let old = before.iter().flat_map(|before| before.groups.pairs());
        let groups = Groups::of(old.chain(pairs));
        self.glued_by(groups, lattice)
    }

    /// Glues the points of each group, and gives them the geometry of the first one.
    fn glued_by(mut self, groups: Groups, lattice: Lattice) -> Result<Self, SurfaceError> {
        self.known = Known::default();
        self.glued = Some(Arc::new(Glued { groups, lattice }));
        self.agree()?;
        self.non_empty()
    }

    /// Returns, for a glued surface, the groups of copies of one surface point, by their row-major indices.
    pub fn copies(&self) -> Option<&Groups> {
        self.glued.as_ref().map(|glued| &glued.groups)
    }

    /// Returns whether a line of grid points is a single point of the surface, as at the poles of a globe.
    #[doc(hidden)]
    pub fn has_poles(&self) -> bool {
        self.copies().is_some_and(Groups::have_poles)
    }

    /// Returns whether sides of the grid are glued.
    pub fn is_glued(&self) -> bool {
        self.glued.is_some()
    }

    /// Returns an error if the surface is glued, since `what` then is not available.
    pub(crate) fn check_open(
        &self,
        what: &'static str,
        instead: &'static str,
    ) -> Result<(), GluingError> {
        match self.glued {
            Some(_) => Err(GluingError::Unsupported { what, instead }),
            None => Ok(()),
        }
    }

    /// Returns whether grid lines have corners inside the grid.
    pub(super) fn has_corners(&self) -> bool {
        self.glued.as_ref().is_some_and(|glued| glued.lattice.is_folded)
    }

    /// Returns whether the surface is glued by this gluing and no other.
    #[doc(hidden)]
    pub fn is_glued_by(&self, gluing: &Gluing) -> bool {
        let Some(glued) = &self.glued else { return false };
        self.compile(gluing).is_ok_and(|compiled| Groups::of(compiled.pairs) == glued.groups)
    }

    /// Returns whether the points of a seam are glued.
    pub(super) fn has_glued(&self, seam: &Seam) -> bool {
        let Some(glued) = &self.glued else { return false };
        glued.has_glued(&compile::pairs_of(self.chart, seam).unwrap_or_default())
    }
}
