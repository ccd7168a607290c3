//! Defines the stop criterion and the result of iterations, for all engines.

use crate::Surface;

/// Default tolerance of maps in single precision, near its rounding.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;
/// Default tolerance of maps in double precision, near its rounding.
pub const DEFAULT_TOLERANCE_F64: f64 = 1e-13;

/// Limits at which a solver stops; the first one reached counts.
///
/// ```
/// use geosweep::Stop;
///
/// let stop = Stop::within(1e-6).or_after(100);
/// assert_eq!((stop.tolerance, stop.iterations), (1e-6, 100));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Stop {
    /// Relative tolerance. Scans stop after an iteration in which no arrival time fell by more than this
    /// fraction.
    pub tolerance: f64,
    /// Maximum number of iterations of four scans.
    pub iterations: u32,
}

impl Stop {
    /// Stops once no arrival time falls by more than the fraction `tolerance` in an iteration. The number of
    /// iterations is not limited.
    pub const fn within(tolerance: f64) -> Self {
        Self { tolerance, iterations: u32::MAX }
    }

    /// Stops after `iterations` iterations, or earlier if nothing changes any more.
    pub const fn after(iterations: u32) -> Self {
        Self { tolerance: 0.0, iterations }
    }

    /// Stops once a map of `surface` has settled to `tolerance`, or after a limit far above the iterations that a map
    /// needs.
    #[doc(hidden)]
    pub fn settled(surface: &Surface, tolerance: f64) -> Self {
        let enough = 10 * (surface.rows() + surface.cols());
        Self::within(tolerance).or_after(u32::try_from(enough).unwrap_or(u32::MAX))
    }

    /// Stops after `iterations` iterations at the latest.
    pub const fn or_after(self, iterations: u32) -> Self {
        Self { iterations, ..self }
    }
}

/// The number of iterations of a solution, and its remaining change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Number of iterations of four scans.
    pub iterations: u32,
    /// Largest relative change of an arrival time in the last iteration; 1 if that iteration reached a point
    /// for the first time.
    pub residual: f64,
}

impl Convergence {
    /// Convergence before any map.
    #[doc(hidden)]
    pub const NONE: Self = Self { iterations: 0, residual: 0.0 };

    /// Combines two results: the larger number of iterations and the larger residual.
    #[doc(hidden)]
    pub fn worse(self, other: Self) -> Self {
        Self {
            iterations: self.iterations.max(other.iterations),
            residual: self.residual.max(other.residual),
        }
    }
}
