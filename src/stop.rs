//! When iterations stop, and how they came to an end: the same for every engine.

/// When raster scans stop: at whichever comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Stop after an iteration in which no arrival time fell by more than this fraction.
    pub tolerance: f64,
    /// Stop after this many iterations of four scans.
    pub iterations: u32,
}

impl Stop {
    /// Stops after a fixed number of iterations, or earlier if nothing changes any more.
    pub fn after(iterations: u32) -> Self {
        Self { tolerance: 0.0, iterations }
    }
}

/// How a solution came about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Iterations of four scans.
    pub iterations: u32,
    /// Largest relative change of an arrival time in the last iteration; 1 if a point was first
    /// reached in it.
    pub residual: f64,
}

impl Convergence {
    /// That of no map at all.
    pub(crate) const NONE: Self = Self { iterations: 0, residual: 0.0 };

    /// That of two together: of the slower, and of the less converged.
    pub(crate) fn worse(self, other: Self) -> Self {
        Self {
            iterations: self.iterations.max(other.iterations),
            residual: self.residual.max(other.residual),
        }
    }
}
