//! Decides when to stop iterating, and when to stop renewing curved fronts. The twin of
//! `glsl/passes/progress.comp`.
//!
//! Renewed fronts settle in a few iterations if each depends only on earlier ones. On rough surfaces, or
//! where the slowness jumps, two points may depend on one another through triangles. Around corners their
//! fronts may then alternate forever, as on three of 48 random surfaces.

use geosweep_surface::constants::{CURVATURE_COUNTS, FIRST_REACHED, PATIENCE};
use geosweep_surface::{Convergence, Stop};
use geosweep_surface::{Real, min, relative_change};

/// Returns the weight of a change of curvature, in units of the last place of the arrival time. `bend` is the size of
/// the change times the arrival time. Any change weighs less than a point's first front.
#[inline(always)]
pub fn bend_units<R: Real>(bend: R) -> R::Bits {
    min(bend * R::of(CURVATURE_COUNTS), R::one()).in_units()
}

/// The progress of the iterations so far.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    stop: Stop,
    /// Number of iterations of four scans.
    pub iterations: u32,
    /// Largest relative change in the last iteration.
    pub residual: f64,
    since_reached: u32,
}

impl Progress {
    pub(crate) fn new(stop: Stop) -> Self {
        Self { stop, iterations: 0, residual: f64::INFINITY, since_reached: 0 }
    }

    /// Counts an iteration, given its largest change. Returns whether it was the last one.
    pub(crate) fn is_done<R: Real>(&mut self, change: R::Bits) -> bool {
        self.iterations += 1;
        self.residual = relative_change::<R>(change);
        let units: u64 = change.into();
        let first_reached = f64::from(FIRST_REACHED) * f64::from(f32::EPSILON);
        let reached = units as f64 * R::epsilon().wide() > first_reached;
        self.since_reached = if reached { 0 } else { self.since_reached + 1 };
        self.is_settled() || self.is_last()
    }

    /// Returns the number of iterations so far and the residual.
    pub(crate) fn convergence(&self) -> Convergence {
        Convergence { iterations: self.iterations, residual: self.residual }
    }

    /// Returns whether the last iteration changed nothing by more than the tolerance.
    pub(crate) fn is_settled(&self) -> bool {
        self.residual <= self.stop.tolerance
    }

    /// Returns whether no further iteration is allowed.
    pub(crate) fn is_last(&self) -> bool {
        self.iterations >= self.stop.iterations
    }

    /// Returns whether the next iteration renews curved fronts.
    pub(crate) fn renews(&self) -> bool {
        self.since_reached < PATIENCE
    }
}
