//! Defines tags: the last binary digits of a number, in which a type stores additional data beside the value.

use super::real::Real;
use crate::constants::FLAT;

/// Mask of the digits of a tag.
pub const TAG: u8 = crate::constants::TAG as u8;

/// Numbers with a tag, as in the shaders. Each use defines the meaning of the digits: those of the Gaussian
/// curvature in `gaussian_curvature.rs`, those of fronts in `update/curvature.rs` and `update/anchor.rs`.
pub trait Tagged: Real {
    /// Returns the number with a tag from 0 to 15. Zero becomes a tiny number, since devices may flush
    /// smaller numbers to zero.
    #[inline(always)]
    fn with_tag(self, tag: u8) -> Self {
        let flat = Self::of(FLAT);
        let held = if self.abs() < flat { flat } else { self };
        let (digits, tag): (Self::Bits, Self::Bits) =
            (u32::from(TAG).into(), u32::from(tag).into());
        Self::from_bits(held.to_bits() & !digits | tag)
    }

    /// Returns whether the digits of the tag that `mask` selects equal `digits`. The comparison uses lanes as
    /// wide as the number.
    #[inline(always)]
    fn tag_has(self, mask: u8, digits: u8) -> bool {
        let (mask, digits): (Self::Bits, Self::Bits) =
            (u32::from(mask).into(), u32::from(digits).into());
        self.to_bits() & mask == digits
    }
}

impl<R: Real> Tagged for R {}
