//! Lets another thread follow a computation and cancel it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use crate::Convergence;

/// The error of a computation that was cancelled by its [`Monitor`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the computation was cancelled")]
pub struct Cancelled;

/// Handle to a computation in another thread, to follow its progress and to cancel it. Clones share the same state.
///
/// A computation that is cancelled ends with the error [`Cancelled`] after the current band of lines, part of the
/// edges or submission to a device: on the CPU within milliseconds. Matrices on the CPU whose maps are computed in
/// batches end after the current batches, of up to 16 maps on each thread.
#[derive(Clone, Debug, Default)]
pub struct Monitor(Arc<State>);

#[derive(Debug, Default)]
struct State {
    is_cancelled: AtomicBool,
    iterations: AtomicU32,
    /// Bits of the residual.
    residual: AtomicU64,
}

impl Monitor {
    /// Cancels the computation. This cannot be undone: later computations with this monitor are cancelled when
    /// they start.
    pub fn cancel(&self) {
        self.0.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns whether the computation has been cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.0.is_cancelled.load(Ordering::Relaxed)
    }

    /// Returns the number of iterations that the map has finished, and the relative change of the last one.
    /// Both are 0 before the first iteration ends. Where several maps are computed, they are those of the map
    /// that has finished an iteration last. On a device they stay at 0.
    pub fn progress(&self) -> Convergence {
        Convergence {
            iterations: self.0.iterations.load(Ordering::Relaxed),
            residual: f64::from_bits(self.0.residual.load(Ordering::Relaxed)),
        }
    }

    /// Notes that an iteration has ended.
    #[doc(hidden)]
    pub fn note(&self, iterations: u32, residual: f64) {
        self.0.residual.store(residual.to_bits(), Ordering::Relaxed);
        self.0.iterations.store(iterations, Ordering::Relaxed);
    }

    /// Returns an error if the computation has been cancelled.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// Monitors are equal if they belong to the same computation.
impl PartialEq for Monitor {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
