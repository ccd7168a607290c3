//! Encodes the numbers of anchors that fronts over a floor plan carry.

use bytemuck::{Pod, Zeroable};

use super::carried::Carried;
use crate::{Real, TAG, Tagged};

/// The number of an anchor (a pseudo-source), below `ANCHORS`. Its tag says which
/// scan brought the front.
///
/// The bits of the number make a normal floating-point number, which devices leave unchanged. The highest bit
/// of the number is the sign; the other bits stand above the tag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Anchor<R>(R);

/// Number of bits of an anchor's number, without the bit that is the sign.
const LOW: usize = 25;
/// Number of digits of the tag.
const TAG_DIGITS: usize = TAG.count_ones() as usize;
/// 2^-63. All bits of this number below the first bits of its exponent are 0, so an anchor's number can be
/// stored there.
const BASE: f64 = 1.0 / (1u64 << 63) as f64;

impl<R: Real> Anchor<R> {
    /// Encodes a number, without a tag.
    #[inline(always)]
    #[doc(hidden)]
    pub fn new(number: usize) -> Self {
        let (high, low) = ((number >> LOW) as u32, (number & ((1 << LOW) - 1)) as u32);
        let (high, low): (R::Bits, R::Bits) = (high.into(), low.into());
        Self(R::from_bits(high << Self::sign() | R::of(BASE).to_bits() | low << TAG_DIGITS))
    }

    /// Returns the position of the sign's digit.
    #[inline(always)]
    fn sign() -> usize {
        8 * size_of::<R>() - 1
    }

    /// Returns the number of the anchor.
    #[inline(always)]
    #[doc(hidden)]
    pub fn number(self) -> usize {
        let bits = self.0.to_bits();
        let low: R::Bits = ((1 << LOW) - 1).into();
        let number: u64 = (bits >> Self::sign() << LOW | bits >> TAG_DIGITS & low).into();
        number as usize
    }

    /// Returns this anchor with the tag of the scan that brought the front.
    #[inline(always)]
    #[doc(hidden)]
    pub fn brought_by(self, scan: u8) -> Self {
        Self(self.0.with_tag(scan))
    }

    /// Returns whether both are the same anchor, whichever scans brought them.
    #[inline(always)]
    #[doc(hidden)]
    pub fn is(self, other: Self) -> bool {
        let tag: R::Bits = u32::from(TAG).into();
        (self.0.to_bits() ^ other.0.to_bits()) & !tag == R::Bits::default()
    }

    /// Returns whether the tags or the numbers differ.
    #[inline(always)]
    #[doc(hidden)]
    pub fn differs(self, other: Self) -> bool {
        self.0.to_bits() != other.0.to_bits()
    }

    /// Returns the floating-point number that shaders use.
    #[doc(hidden)]
    pub fn value(self) -> R {
        self.0
    }
}

impl<R: Real> Carried for Anchor<R> {
    const TELLS_SCANS: bool = true;

    #[inline(always)]
    fn is_from(self, scan: u8) -> bool {
        self.0.tag_has(TAG, scan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ANCHORS;

    fn assert_keeps_numbers<R: Real>() {
        for number in [0, 1, 77, ANCHORS / 2 - 1, ANCHORS / 2, ANCHORS - 1] {
            for scan in 0..5 {
                let anchor = Anchor::<R>::new(number).brought_by(scan);
                assert!(anchor.number() == number && anchor.value().is_normal());
                assert!((0..8).all(|other| anchor.is_from(other) == (other == scan)));
                assert!(anchor.is(Anchor::new(number)) && !anchor.is(Anchor::new(number ^ 1)));
            }
        }
    }

    #[test]
    fn anchors_keep_their_numbers_and_scans() {
        assert_keeps_numbers::<f32>();
        assert_keeps_numbers::<f64>();
    }
}
