//! The two precisions of the solvers.

/// Stands for "not reached" and "no such edge" inside the solvers and the shaders.
///
/// A large finite number, since GLSL does not promise infinities and their difference is NaN.
/// The public interface says +infinity instead.
pub const FAR: f64 = crate::constants::FAR;

use crate::constants::{FLAT, SOURCE_CURVATURE};

/// The last binary digits of a number, which may hold a tag.
pub(crate) const TAG: u8 = crate::constants::TAG as u8;

/// f32 for use, f64 for reference.
pub trait Real:
    num_traits::Float + bytemuck::Pod + Default + Send + Sync + std::fmt::Debug
{
    /// [`FAR`] in this precision.
    const FAR: Self;

    /// Curvature of a front at a point source: as good as infinite, and its products with lengths
    /// of edges stay finite.
    const SOURCE: Self;

    /// Counts units in the last place.
    type Bits: Copy + Ord + Default + Into<u64> + Send;

    /// How many numbers of this precision lie between two that are not negative: their relative
    /// difference in units of the precision, to within a factor of two, without a division.
    fn units_between(self, other: Self) -> Self::Bits;

    /// The number that lies so many numbers of this precision above zero.
    fn from_zero(units: Self::Bits) -> Self;

    /// A relative change that is not negative in units of this precision.
    fn in_units(self) -> Self::Bits;

    /// The number with a tag from 0 to 15 in its last binary digits; zero becomes tiny.
    fn with_tag(self, tag: u8) -> Self;

    /// Whether those of the tag's digits that a mask selects are these. In lanes as wide as the number.
    fn tag_has(self, mask: u8, digits: u8) -> bool;

    /// A number of an anchor (see `update/anchored.rs`), below [`Real::NUMBERS`], as a number that devices
    /// keep as it is, between the smallest and the largest: with room for a tag.
    fn of_number(number: usize) -> Self;

    /// Such a number, whatever its tag.
    fn number(self) -> usize;

    /// Whether both are the same but for their tags.
    fn is_numbered_as(self, other: Self) -> bool;

    /// How many numbers there are.
    const NUMBERS: usize;

    /// Rounds to this precision.
    fn of(value: f64) -> Self;

    /// Widens to double precision.
    fn wide(self) -> f64;
}

impl Real for f32 {
    const FAR: Self = FAR as f32;
    const SOURCE: Self = SOURCE_CURVATURE as f32;
    type Bits = u32;

    #[inline(always)]
    fn units_between(self, other: Self) -> u32 {
        self.to_bits().abs_diff(other.to_bits())
    }

    #[inline(always)]
    fn from_zero(units: u32) -> Self {
        Self::from_bits(units)
    }

    #[inline(always)]
    fn in_units(self) -> u32 {
        (self / Self::EPSILON) as u32
    }

    #[inline(always)]
    fn with_tag(self, tag: u8) -> Self {
        let held = if self.abs() < FLAT as f32 { FLAT as f32 } else { self };
        Self::from_bits(held.to_bits() & !u32::from(TAG) | u32::from(tag))
    }

    #[inline(always)]
    fn tag_has(self, mask: u8, digits: u8) -> bool {
        self.to_bits() & u32::from(mask) == u32::from(digits)
    }

    const NUMBERS: usize = 1 << 26;

    #[inline(always)]
    fn is_numbered_as(self, other: Self) -> bool {
        (self.to_bits() ^ other.to_bits()) & !u32::from(TAG) == 0
    }

    #[inline(always)]
    fn of_number(number: usize) -> Self {
        let (high, low) = (number as u32 >> 25, number as u32 & ((1 << 25) - 1));
        Self::from_bits(high << 31 | 1 << 29 | low << 4)
    }

    #[inline(always)]
    fn number(self) -> usize {
        let bits = self.to_bits();
        (bits >> 31 << 25 | bits >> 4 & ((1 << 25) - 1)) as usize
    }

    #[inline(always)]
    fn of(value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self.into()
    }
}

impl Real for f64 {
    const FAR: Self = FAR;
    const SOURCE: Self = SOURCE_CURVATURE;
    type Bits = u64;

    #[inline(always)]
    fn units_between(self, other: Self) -> u64 {
        self.to_bits().abs_diff(other.to_bits())
    }

    #[inline(always)]
    fn from_zero(units: u64) -> Self {
        Self::from_bits(units)
    }

    #[inline(always)]
    fn in_units(self) -> u64 {
        (self / Self::EPSILON) as u64
    }

    #[inline(always)]
    fn with_tag(self, tag: u8) -> Self {
        let held = if self.abs() < FLAT { FLAT } else { self };
        Self::from_bits(held.to_bits() & !u64::from(TAG) | u64::from(tag))
    }

    #[inline(always)]
    fn tag_has(self, mask: u8, digits: u8) -> bool {
        self.to_bits() & u64::from(mask) == u64::from(digits)
    }

    const NUMBERS: usize = 1 << 26;

    #[inline(always)]
    fn is_numbered_as(self, other: Self) -> bool {
        (self.to_bits() ^ other.to_bits()) & !u64::from(TAG) == 0
    }

    #[inline(always)]
    fn of_number(number: usize) -> Self {
        let (high, low) = (number as u64 >> 25, number as u64 & ((1 << 25) - 1));
        Self::from_bits(high << 63 | 1023 << 52 | low << 4)
    }

    #[inline(always)]
    fn number(self) -> usize {
        let bits = self.to_bits();
        (bits >> 63 << 25 | bits >> 4 & ((1 << 25) - 1)) as usize
    }

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }
}

/// The relative change of an arrival time that [`Real::units_between`] has counted: at most twice
/// as large as it is, and 1 for a point that was reached.
pub(crate) fn relative_change<R: Real>(units: R::Bits) -> f64 {
    let units: u64 = units.into();
    (units as f64 * R::epsilon().wide()).min(1.0)
}

/// The larger of two numbers. In comparisons with NaN the first wins, as in the shaders; unlike
/// the standard library's, it is one instruction.
#[inline(always)]
pub(crate) fn max<R: Real>(a: R, b: R) -> R {
    if a < b { b } else { a }
}

/// The smaller of two numbers.
#[inline(always)]
pub(crate) fn min<R: Real>(a: R, b: R) -> R {
    if b < a { b } else { a }
}
