//! The fronts and the states of the points that are solved in the order of time.

use geosweep_surface::Real;
use geosweep_surface::update::StoredFront;

/// Fronts at all points, as bordered arrays. At a point that waits for the first time, only the arrival time along an
/// edge is known.
#[derive(Clone, Debug)]
pub(super) struct StoredFronts<R, C> {
    pub times: Vec<R>,
    pub carried: Vec<C>,
    /// The times of fronts that are final, as far as is known, and [`Real::FAR`] at all other points. Points find the
    /// fronts around them that count in this array alone.
    pub settled: Vec<R>,
}

impl<R: Real, C: Copy> StoredFronts<R, C> {
    #[inline(always)]
    pub(super) fn at(&self, point: usize) -> StoredFront<R, C> {
        StoredFront { time: self.times[point], carried: self.carried[point] }
    }

    pub(super) fn set(&mut self, point: usize, front: StoredFront<R, C>) {
        (self.times[point], self.carried[point]) = (front.time, front.carried);
    }

    /// Returns whether the front at a point is final, as far as is known.
    #[inline(always)]
    pub(super) fn is_final(&self, point: usize) -> bool {
        self.settled[point] < R::FAR
    }
}

/// The state of a point, as bits.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct State(u8);

impl State {
    /// The point waits in the queue.
    pub(super) const WAITS: u8 = 1;
    /// The point's front has been computed. It may have been final and wait again.
    pub(super) const COMPUTED: u8 = 2;
    /// A seed is at the point.
    pub(super) const SEED: u8 = 4;
    /// The point belongs to another patch, from which its front comes.
    pub(super) const FOREIGN: u8 = 8;
    /// Other patches see the point.
    pub(super) const SHARED: u8 = 16;

    #[inline(always)]
    pub(super) fn is(self, bits: u8) -> bool {
        self.0 & bits != 0
    }

    #[inline(always)]
    pub(super) fn set(&mut self, bits: u8) {
        self.0 |= bits;
    }

    #[inline(always)]
    pub(super) fn clear(&mut self, bits: u8) {
        self.0 &= !bits;
    }
}

/// Returns the front at a point that none has reached.
pub(super) fn none<R: Real, C: Default>() -> StoredFront<R, C> {
    StoredFront { time: R::FAR, carried: C::default() }
}

/// Returns the time of a point in the queue, or `None` if it does not wait.
pub(super) fn waiting<R: Real>(
    times: &[R],
    states: &[State],
    limit: f64,
    point: u32,
) -> Option<f64> {
    let point = point as usize;
    states[point].is(State::WAITS).then(|| times[point].wide().min(limit))
}
