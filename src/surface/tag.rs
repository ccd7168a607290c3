//! Tags: the last binary digits of a number, in which types that own them keep what is beside its value.

use super::real::Real;
use crate::constants::FLAT;

/// The digits of a tag.
pub(crate) const TAG: u8 = crate::constants::TAG as u8;

/// Numbers with a tag, as shaders have them too. A type of its own says what the digits mean: those of the
/// Gaussian curvature in `gaussian_curvature.rs`, of fronts in `update/curvature.rs` and `update/anchor.rs`.
pub(crate) trait Tagged: Real {
    /// The number with a tag from 0 to 15; zero becomes tiny, since devices may flush smaller ones.
    #[inline(always)]
    fn with_tag(self, tag: u8) -> Self {
        let flat = Self::of(FLAT);
        let held = if self.abs() < flat { flat } else { self };
        let (digits, tag): (Self::Bits, Self::Bits) =
            (u32::from(TAG).into(), u32::from(tag).into());
        Self::from_bits(held.to_bits() & !digits | tag)
    }

    /// Whether those of the tag's digits that a mask selects are these. In lanes as wide as the number.
    #[inline(always)]
    fn tag_has(self, mask: u8, digits: u8) -> bool {
        let (mask, digits): (Self::Bits, Self::Bits) =
            (u32::from(mask).into(), u32::from(digits).into());
        self.to_bits() & mask == digits
    }
}

impl<R: Real> Tagged for R {}
