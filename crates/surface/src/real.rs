//! Defines the two precisions of the solvers, and limits of lengths that fit them.

/// The value for "not reached" and "no such edge" inside the solvers and the shaders.
///
/// A large finite number serves, since GLSL does not guarantee infinities, and the difference of two infinities is NaN.
/// The public interface uses +infinity instead.
pub const FAR: f64 = crate::constants::FAR;

/// Minimum length of an edge between distinct points, in the surface's unit of length.
pub const SHORTEST_EDGE: f64 = 1e-12;
/// Maximum length of an edge. Squares and sums of such lengths stay within single precision and below
/// [`FAR`].
pub const LONGEST_EDGE: f64 = crate::constants::LONGEST_EDGE;

/// Precision of the solvers: f32 for use or f64 for reference, and no other.
pub trait Real:
    sealed::Precision + num_traits::Float + bytemuck::Pod + Default + Send + Sync + std::fmt::Debug
{
    /// [`FAR`] in this precision.
    const FAR: Self;

    /// The type of the binary digits, which also counts units in the last place.
    type Bits: num_traits::PrimInt + From<u32> + Into<u64> + Default + Send + Sync + std::fmt::Debug;

    /// Returns the binary digits of the number.
    fn to_bits(self) -> Self::Bits;

    /// Returns the number with these binary digits. Among non-negative numbers it is the one that lies `bits`
    /// representable numbers above zero.
    fn from_bits(bits: Self::Bits) -> Self;

    /// Returns the number of representable numbers between two non-negative numbers. This is their relative
    /// difference in units of the precision, to within a factor of two, without a division.
    fn units_between(self, other: Self) -> Self::Bits;

    /// Converts a non-negative relative change to units of this precision.
    fn in_units(self) -> Self::Bits;

    /// Returns the angle in radians, from -pi to pi, by which the angle `to` is ahead of `from`. Both are words whose
    /// upper half counts parts of a turn; the lower half is ignored.
    fn angle_between(from: Self::Bits, to: Self::Bits) -> Self;

    /// Returns the word of the angle that is ahead of the angle `from` by some radians, at most three turns. Its lower
    /// half is zero.
    fn angle_ahead(from: Self::Bits, radians: Self) -> Self::Bits;

    /// Rounds to this precision.
    fn of(value: f64) -> Self;

    /// Widens to double precision.
    fn wide(self) -> f64;
}

mod sealed {
    /// Keeps other crates from adding precisions.
    pub trait Precision {}
}

macro_rules! precision {
    ($real:ident, $bits:ident, $signed:ident) => {
        impl sealed::Precision for $real {}

        impl Real for $real {
            const FAR: Self = FAR as $real;
            type Bits = $bits;

            #[inline(always)]
            fn to_bits(self) -> $bits {
                $real::to_bits(self)
            }

            #[inline(always)]
            fn from_bits(bits: $bits) -> Self {
                $real::from_bits(bits)
            }

            #[inline(always)]
            fn units_between(self, other: Self) -> $bits {
                self.to_bits().abs_diff(other.to_bits())
            }

            #[inline(always)]
            fn in_units(self) -> $bits {
                (self / Self::EPSILON) as $bits
            }

            #[inline(always)]
            fn angle_between(from: $bits, to: $bits) -> Self {
                const UPPER: $bits = $bits::MAX << ($bits::BITS / 2);
                const PER_STEP: $real = std::$real::consts::PI / $signed::MAX as $real;
                (to & UPPER).wrapping_sub(from & UPPER) as $signed as $real * PER_STEP
            }

            #[inline(always)]
            fn angle_ahead(from: $bits, radians: $real) -> $bits {
                const HALF: u32 = $bits::BITS / 2;
                const STEPS: $real = ((1 as $bits) << HALF) as $real / std::$real::consts::TAU;
                // Adding this number moves the integer part of a small number to the last binary digits.
                const SHIFT: $real = 1.5 * ((1 as $bits) << ($real::MANTISSA_DIGITS - 1)) as $real;
                let steps = (radians * STEPS + SHIFT).to_bits();
                ((from >> HALF).wrapping_add(steps)) << HALF
            }

            #[inline(always)]
            fn of(value: f64) -> Self {
                value as $real
            }

            #[inline(always)]
            fn wide(self) -> f64 {
                self.into()
            }
        }
    };
}

precision!(f32, u32, i32);
precision!(f64, u64, i64);

/// Converts a count of [`Real::units_between`] to a relative change of an arrival time. The result is at most
/// twice the true change, and 1 for a point that was reached for the first time.
pub fn relative_change<R: Real>(units: R::Bits) -> f64 {
    let units: u64 = units.into();
    (units as f64 * R::epsilon().wide()).min(1.0)
}

/// Returns the larger of two numbers. If one is NaN the first is returned, as in the shaders. Unlike the
/// standard library's function, this is one instruction.
#[inline(always)]
pub fn max<R: Real>(a: R, b: R) -> R {
    if a < b { b } else { a }
}

/// Returns the smaller of two numbers.
#[inline(always)]
pub fn min<R: Real>(a: R, b: R) -> R {
    if b < a { b } else { a }
}
