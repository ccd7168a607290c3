//! A surface with what all maps on it share.

use std::sync::OnceLock;

use geosweep::MapSolver;
use geosweep::surface::EdgeLengths;

/// A surface, the solvers of its maps, and its edges in single precision, which geometry on maps needs.
pub struct OnGrid {
    pub solver: MapSolver,
    edges: OnceLock<EdgeLengths<f32>>,
}

impl OnGrid {
    pub fn new(surface: geosweep::Surface) -> Self {
        Self { solver: MapSolver::new(surface), edges: OnceLock::new() }
    }

    pub fn surface(&self) -> &geosweep::Surface {
        self.solver.surface()
    }

    /// Returns the edges, measured for the first call.
    pub fn edges(&self) -> Result<&EdgeLengths<f32>, geosweep::Error> {
        if self.edges.get().is_none() {
            // If two threads measure at once, both find the same lengths.
            let _ = self.edges.set(EdgeLengths::new(self.surface())?);
        }
        Ok(self.edges.get().expect("edges that have just been set"))
    }

    /// Returns the numbers of rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        (self.surface().rows(), self.surface().cols())
    }
}
