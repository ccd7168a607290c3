//! When to stop iterating, and when to stop renewing curved fronts. The twin of
//! `glsl/progress.comp`.
//!
//! Fronts that are renewed settle in a few iterations where each depends on earlier ones alone.
//! On rough surfaces, or where slowness jumps, triangles let two points depend on one another, and
//! around corners their fronts can then take turns for ever: three of 48 random surfaces did.

use crate::Stop;
use crate::constants::{CURVATURE_COUNTS, FIRST_REACHED, PATIENCE};
use crate::surface::{Real, min, relative_change};

/// What a change of curvature counts, in units of the arrival time: `bend` is its size times that
/// time. However large, it is not taken for a point's first front.
#[inline(always)]
pub(crate) fn bend_units<R: Real>(bend: R) -> R::Bits {
    min(bend * R::of(CURVATURE_COUNTS), R::one()).in_units()
}

/// How the iterations so far have gone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    stop: Stop,
    /// Iterations of four scans.
    pub iterations: u32,
    /// Relative change of the last one.
    pub residual: f64,
    since_reached: u32,
}

impl Progress {
    pub(crate) fn new(stop: Stop) -> Self {
        Self { stop, iterations: 0, residual: f64::INFINITY, since_reached: 0 }
    }

    /// Counts an iteration, given its largest change; returns whether it was the last.
    pub(crate) fn is_done<R: Real>(&mut self, change: R::Bits) -> bool {
        self.iterations += 1;
        self.residual = relative_change::<R>(change);
        let units: u64 = change.into();
        let first_reached = f64::from(FIRST_REACHED) * f64::from(f32::EPSILON);
        let reached = units as f64 * R::epsilon().wide() > first_reached;
        self.since_reached = if reached { 0 } else { self.since_reached + 1 };
        self.residual <= self.stop.tolerance || self.iterations >= self.stop.iterations
    }

    /// Whether there may be no further iteration.
    pub(crate) fn is_last(&self) -> bool {
        self.iterations >= self.stop.iterations
    }

    /// Whether the next iteration renews curved fronts.
    pub(crate) fn renews(&self) -> bool {
        self.since_reached < PATIENCE
    }
}
