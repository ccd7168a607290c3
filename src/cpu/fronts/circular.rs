//! Circular fronts around a virtual point source.

use super::straight::Straight;
use crate::cpu::settled::from_point_source;
use crate::surface::Real;
use crate::update::{Triangle, point_source};

/// [`crate::Wavefront::PointSource`].
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Circular;

impl Straight for Circular {
    #[inline(always)]
    fn time<R: Real>(triangle: Triangle<R>) -> R {
        point_source(triangle)
    }

    /// By more than rounding: a last digit would be passed on from point to point, and all of them
    /// visited anew.
    #[inline(always)]
    fn earlier<R: Real>(now: R, triangle: Triangle<R>) -> R {
        Self::first(now, point_source(triangle))
    }

    #[inline(always)]
    fn first<R: Real>(now: R, time: R) -> R {
        let is_earlier = time < now * (R::one() - R::epsilon());
        if is_earlier { time } else { now }
    }

    #[inline(always)]
    fn is_settled<R: Real>(triangle: Triangle<R>, now: R) -> bool {
        from_point_source(triangle, now)
    }
}
