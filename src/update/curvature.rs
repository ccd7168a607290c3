//! The curvature that curved fronts carry.

use bytemuck::{Pod, Zeroable};

use super::carried::Carried;
use super::curved::Front;
use crate::constants::WHOLE;
use crate::surface::{Real, TAG, Tagged};

/// Curvature of a front. Its tag says which scan has brought the front, and whether through a whole triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct Curvature<R>(R);

impl<R: Real> Curvature<R> {
    /// Of a front that a scan brings.
    #[inline(always)]
    pub(crate) fn of(front: Front<R>, scan: u8) -> Self {
        let (whole, half) =
            (front.curvature.with_tag(scan | WHOLE as u8), front.curvature.with_tag(scan));
        Self(if front.whole { whole } else { half })
    }

    /// The front that it stands for, with its arrival time.
    #[inline(always)]
    pub(crate) fn front(self, time: R) -> Front<R> {
        Front { time, curvature: self.0, whole: !self.0.tag_has(WHOLE as u8, 0) }
    }

    /// The number itself, up to its tag, which is below what it is known to.
    #[inline(always)]
    pub(crate) fn value(self) -> R {
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
