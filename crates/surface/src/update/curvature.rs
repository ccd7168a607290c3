//! Encodes the curvature that curved fronts carry, or the number of their origin in its place.

use bytemuck::{Pod, Zeroable};

use super::carried::{Carried, EXACT, SEED};
use super::curved::Front;
use crate::constants::{FIRST_ORIGIN, ORIGIN_COUNTS, WHOLE};
use crate::{Real, TAG, Tagged};

/// The curvature of a front. Its tag says which scan brought the front, and whether it came through a whole
/// triangle.
///
/// In maps of several sources, the number of the front's origin may stand in place of the curvature
/// (`sight.rs`). The number is encoded as a negative value of a larger magnitude than any curvature. So if
/// two fronts arrive together, a front with a number counts as flatter than one with a curvature.
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

    /// Returns the value that is carried by a front whose origin has this number.
    #[inline(always)]
    #[doc(hidden)]
    pub fn of_origin(number: u32) -> R {
        let digits: R::Bits = (number << TAG.count_ones()).into();
        -R::from_bits(R::of(FIRST_ORIGIN).to_bits() + digits)
    }

    /// Returns whether a front carries the number of an origin.
    #[inline(always)]
    #[doc(hidden)]
    pub fn is_number(carried: R) -> bool {
        carried <= -R::of(FIRST_ORIGIN)
    }

    /// Returns the number of the front's origin, if it carries one.
    #[inline(always)]
    #[doc(hidden)]
    pub fn origin(self) -> Option<usize> {
        let number = || {
            let digits: u64 = ((-self.0).to_bits() - R::of(FIRST_ORIGIN).to_bits()).into();
            digits as usize >> TAG.count_ones()
        };
        Self::is_number(self.0).then(number)
    }

    /// Returns whether this is the value of a seed with a number, and the other front has the same origin.
    #[inline(always)]
    #[doc(hidden)]
    pub fn is_seed_of(self, other: R) -> bool {
        let tag: R::Bits = u32::from(TAG).into();
        let alike = (self.0.to_bits() ^ other.to_bits()) & !tag == R::Bits::default();
        alike & self.is_from(SEED) & Self::is_number(self.0)
    }

    /// Returns this value without the mark of an exact seed, so that other fronts may replace it.
    #[doc(hidden)]
    pub fn released(self) -> Self {
        if self.is_from(EXACT) { Self(self.0.with_tag(SEED | WHOLE as u8)) } else { self }
    }

    /// Returns the change of the curvature, times the arrival time; see [`crate::constants::CURVATURE_COUNTS`].
    #[inline(always)]
    #[doc(hidden)]
    pub fn bend_from(self, before: Self, time: R) -> R {
        let named = Self::is_number(self.0) | Self::is_number(before.0);
        let tag: R::Bits = u32::from(TAG).into();
        let differs = (self.0.to_bits() ^ before.0.to_bits()) & !tag != R::Bits::default();
        let of_names = if differs { R::of(ORIGIN_COUNTS) } else { R::zero() };
        if named { of_names } else { (self.0 - before.0).abs() * time }
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
