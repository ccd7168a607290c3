//! Encodes the curvature that curved fronts carry.

use bytemuck::{Pod, Zeroable};

use super::carried::{Carried, EXACT, SEED};
use super::curved::Front;
use crate::constants::WHOLE;
use crate::{Real, TAG, Tagged};

/// The curvature of a front. Its tag says which scan brought the front, and whether it came through a whole
/// triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Curvature<R>(R);

impl<R: Real> Curvature<R> {
    /// Encodes a front that `scan` brings.
    #[inline(always)]
    #[doc(hidden)]
    pub fn of(front: Front<R>, scan: u8) -> Self {
        let (whole, half) =
            (front.curvature.with_tag(scan | WHOLE as u8), front.curvature.with_tag(scan));
        Self(if front.whole { whole } else { half })
    }

    /// Decodes a stored number.
    #[inline(always)]
    pub(super) fn of_value(value: R) -> Self {
        Self(value)
    }

    /// Returns the front with this curvature and the given arrival time.
    #[inline(always)]
    #[doc(hidden)]
    pub fn front(self, time: R) -> Front<R> {
        Front { time, curvature: self.0, whole: !self.0.tag_has(WHOLE as u8, 0) }
    }

    /// Returns this value without the mark of an exact seed, so that other fronts may replace it.
    #[doc(hidden)]
    pub fn released(self) -> Self {
        if self.is_from(EXACT) { Self(self.0.with_tag(SEED | WHOLE as u8)) } else { self }
    }

    /// Returns the stored number. Its tag is below the accuracy of the curvature.
    #[inline(always)]
    #[doc(hidden)]
    pub fn value(self) -> R {
        self.0
    }
}

impl<R: Real> Carried for Curvature<R> {
    const TELLS_SCANS: bool = true;

    #[inline(always)]
    fn is_from(self, scan: u8) -> bool {
        self.0.tag_has(TAG & !(WHOLE as u8), scan)
    }
}
