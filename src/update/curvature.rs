//! The curvature that curved fronts carry, or the number of their origin in its place.

use bytemuck::{Pod, Zeroable};

use super::carried::{Carried, EXACT, SEED};
use super::curved::Front;
use crate::constants::{FIRST_ORIGIN, ORIGIN_COUNTS, WHOLE};
use crate::surface::{Real, TAG, Tagged};

/// Curvature of a front. Its tag says which scan has brought the front, and whether through a whole triangle.
///
/// In maps of several sources, the number of the front's origin may stand in its place (`sight.rs`): a negative number
/// that is larger in size than any curvature, so that of fronts that arrive together it counts as the flatter one.
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

    /// What a front with the origin of this number carries.
    #[inline(always)]
    pub(crate) fn of_origin(number: u32) -> R {
        let digits: R::Bits = (number << TAG.count_ones()).into();
        -R::from_bits(R::of(FIRST_ORIGIN).to_bits() + digits)
    }

    /// Whether that is what it carries.
    #[inline(always)]
    pub(crate) fn is_number(carried: R) -> bool {
        carried <= -R::of(FIRST_ORIGIN)
    }

    /// The number of its origin, if it carries one.
    #[inline(always)]
    pub(crate) fn origin(self) -> Option<usize> {
        let number = || {
            let digits: u64 = ((-self.0).to_bits() - R::of(FIRST_ORIGIN).to_bits()).into();
            digits as usize >> TAG.count_ones()
        };
        Self::is_number(self.0).then(number)
    }

    /// Whether it is a seed's with a number, and the other front has the same origin.
    #[inline(always)]
    pub(crate) fn is_seed_of(self, other: R) -> bool {
        let tag: R::Bits = u32::from(TAG).into();
        let alike = (self.0.to_bits() ^ other.to_bits()) & !tag == R::Bits::default();
        alike & self.is_from(SEED) & Self::is_number(self.0)
    }

    /// The same, which other fronts may replace.
    pub(crate) fn released(self) -> Self {
        if self.is_from(EXACT) { Self(self.0.with_tag(SEED | WHOLE as u8)) } else { self }
    }

    /// How much it has changed, times the arrival time; see [`crate::constants::CURVATURE_COUNTS`].
    #[inline(always)]
    pub(crate) fn bend_from(self, before: Self, time: R) -> R {
        let named = Self::is_number(self.0) | Self::is_number(before.0);
        let tag: R::Bits = u32::from(TAG).into();
        let differs = (self.0.to_bits() ^ before.0.to_bits()) & !tag != R::Bits::default();
        let of_names = if differs { R::of(ORIGIN_COUNTS) } else { R::zero() };
        if named { of_names } else { (self.0 - before.0).abs() * time }
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
