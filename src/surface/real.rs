//! The two precisions of the solvers.

/// Stands for "not reached" and "no such edge" inside the solvers and the shaders.
///
/// A large finite number, since GLSL does not promise infinities and their difference is NaN.
/// The public interface says +infinity instead.
pub const FAR: f64 = crate::constants::FAR;

/// f32 for use, f64 for reference.
pub trait Real:
    num_traits::Float + bytemuck::Pod + Default + Send + Sync + std::fmt::Debug
{
    /// [`FAR`] in this precision.
    const FAR: Self;

    /// Binary digits, which also count units in the last place.
    type Bits: num_traits::PrimInt + From<u32> + Into<u64> + Default + Send;

    /// The number's binary digits.
    fn to_bits(self) -> Self::Bits;

    /// The number with these binary digits; of numbers that are not negative the one that lies so many
    /// numbers of this precision above zero.
    fn from_bits(bits: Self::Bits) -> Self;

    /// How many numbers of this precision lie between two that are not negative: their relative
    /// difference in units of the precision, to within a factor of two, without a division.
    fn units_between(self, other: Self) -> Self::Bits;

    /// A relative change that is not negative in units of this precision.
    fn in_units(self) -> Self::Bits;

    /// Rounds to this precision.
    fn of(value: f64) -> Self;

    /// Widens to double precision.
    fn wide(self) -> f64;
}

impl Real for f32 {
    const FAR: Self = FAR as f32;
    type Bits = u32;

    #[inline(always)]
    fn to_bits(self) -> u32 {
        f32::to_bits(self)
    }

    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        f32::from_bits(bits)
    }

    #[inline(always)]
    fn units_between(self, other: Self) -> u32 {
        self.to_bits().abs_diff(other.to_bits())
    }

    #[inline(always)]
    fn in_units(self) -> u32 {
        (self / Self::EPSILON) as u32
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
    type Bits = u64;

    #[inline(always)]
    fn to_bits(self) -> u64 {
        f64::to_bits(self)
    }

    #[inline(always)]
    fn from_bits(bits: u64) -> Self {
        f64::from_bits(bits)
    }

    #[inline(always)]
    fn units_between(self, other: Self) -> u64 {
        self.to_bits().abs_diff(other.to_bits())
    }

    #[inline(always)]
    fn in_units(self) -> u64 {
        (self / Self::EPSILON) as u64
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
