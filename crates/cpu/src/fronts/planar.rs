//! Implements planar fronts.

use super::straight::Straight;
use crate::lines::settled::from_planar;
use geosweep_surface::update::{Triangle, planar};
use geosweep_surface::{Real, min};

/// The front of [`geosweep_surface::Wavefront::Planar`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planar;

impl Straight for Planar {
    #[inline(always)]
    fn time<R: Real>(self, triangle: Triangle<R>) -> R {
        planar(triangle)
    }

    #[inline(always)]
    fn earlier<R: Real>(self, now: R, triangle: Triangle<R>) -> R {
        min(now, planar(triangle))
    }

    #[inline(always)]
    fn first<R: Real>(now: R, time: R) -> R {
        min(now, time)
    }

    #[inline(always)]
    fn is_settled<R: Real>(triangle: Triangle<R>, now: R) -> bool {
        from_planar(triangle, now)
    }
}
