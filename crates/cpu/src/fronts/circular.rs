//! Implements circular fronts around a virtual point source.

use super::straight::Straight;
use crate::lines::settled::from_circular;
use geosweep_surface::update::{Triangle, circular};
use geosweep_surface::{EdgeLengths, Origins, Real};

/// The front of [`geosweep_surface::Wavefront::Circular`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circular {
    origins: Origins,
}

impl Circular {
    pub(crate) fn new<R: Real>(edges: &EdgeLengths<R>) -> Self {
        Self { origins: Origins::none(edges.front_meets_itself()) }
    }
}

impl Straight for Circular {
    fn origins(&mut self) -> Option<&mut Origins> {
        Some(&mut self.origins)
    }

    #[inline(always)]
    fn time<R: Real>(self, triangle: Triangle<R>) -> R {
        circular(triangle, self.origins.are_causal())
    }

    /// Accepts only times that are earlier by more than rounding. Otherwise a change of the last digit would spread
    /// from point to point, and all these points would be visited again.
    #[inline(always)]
    fn earlier<R: Real>(self, now: R, triangle: Triangle<R>) -> R {
        Self::first(now, circular(triangle, self.origins.are_causal()))
    }

    #[inline(always)]
    fn first<R: Real>(now: R, time: R) -> R {
        let is_earlier = time < now * (R::one() - R::epsilon());
        if is_earlier { time } else { now }
    }

    #[inline(always)]
    fn is_settled<R: Real>(triangle: Triangle<R>, now: R) -> bool {
        from_circular(triangle, now)
    }
}
