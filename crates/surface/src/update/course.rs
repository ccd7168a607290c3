//! Encodes the way of a front: the direction of its ray at a point, and the number of its source.

use bytemuck::{Pod, Zeroable};

use super::carried::Carried;
use super::curvature::Curvature;
use super::rays::RayFront;
use crate::Real;

/// The direction in which a front passes a point, as an angle in the point's fan ([`crate::Fan`]), and the number of
/// the source from which it comes.
///
/// The upper half of the word is the angle ([`Real::angle_between`]). The lower half holds the number, and a mark at
/// points of a curve, from which the front leaves to both sides.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Course<R: Real>(pub R::Bits);

impl<R: Real> PartialEq for Course<R> {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

impl<R: Real> Course<R> {
    const HALF: usize = size_of::<R>() * 4;
    /// Sources with this number or a larger one share it.
    pub const MOST_SOURCES: u32 = (1 << (Self::HALF - 1)) as u32 - 1;

    fn one() -> R::Bits {
        1.into()
    }

    fn mark() -> R::Bits {
        Self::one() << (Self::HALF - 1)
    }

    /// Encodes an angle, as a word, and the number of a source.
    #[inline(always)]
    pub fn new(angle: R::Bits, source: u32) -> Self {
        let lower = (Self::one() << Self::HALF) - Self::one();
        Self(angle & !lower | source.min(Self::MOST_SOURCES).into())
    }

    /// Returns this course at a point of a curve, from which the front leaves in the opposite direction too.
    pub fn to_both_sides(self) -> Self {
        Self(self.0 | Self::mark())
    }

    /// Returns whether the front also leaves in the opposite direction.
    #[inline(always)]
    pub fn is_to_both_sides(self) -> bool {
        self.0 & Self::mark() != R::Bits::default()
    }

    /// Returns the number of the source.
    #[inline(always)]
    pub fn source(self) -> u32 {
        let source: u64 = (self.0 & (Self::mark() - Self::one())).into();
        source as u32
    }

    /// Returns whether both courses have the same source, and neither leaves to both sides.
    #[inline(always)]
    pub fn is_plain_as(self, other: Self) -> bool {
        let lower = (Self::one() << Self::HALF) - Self::one();
        ((self.0 ^ other.0) & lower == R::Bits::default())
            & (self.0 & Self::mark() == R::Bits::default())
    }

    /// Returns a course with another angle.
    #[inline(always)]
    pub fn turned_to(self, angle: R::Bits) -> Self {
        Self::new(angle, self.source())
    }

    /// Returns whether both courses have the same source and about the same angle.
    #[inline(always)]
    pub fn is_same_as(self, other: Self) -> bool {
        let steps = R::angle_between(self.0, other.0).abs();
        (self.source() == other.source())
            & (steps <= R::angle_between(R::Bits::default(), Self::one() << (Self::HALF + 1)))
    }
}

/// The curvature that a front carries, with the tags of [`Curvature`], and its course.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(transparent)]
#[doc(hidden)]
pub struct CarriedRay<R>([R; 2]);

impl<R: Real> CarriedRay<R> {
    /// Encodes a front that `scan` brings.
    #[inline(always)]
    pub fn of(front: RayFront<R>, scan: u8) -> Self {
        Self([Curvature::of(front.front, scan).value(), R::from_bits(front.course.0)])
    }

    #[inline(always)]
    fn curvature(self) -> Curvature<R> {
        Curvature::of_value(self.0[0])
    }

    /// Returns the front with this data and the given arrival time.
    #[inline(always)]
    pub fn front(self, time: R) -> RayFront<R> {
        RayFront { front: self.curvature().front(time), course: self.course() }
    }

    #[inline(always)]
    pub fn value(self) -> R {
        self.0[0]
    }

    #[inline(always)]
    pub fn course(self) -> Course<R> {
        Course(self.0[1].to_bits())
    }
}

/// Courses are words that need not be numbers, so bits are compared.
impl<R: Real> PartialEq for CarriedRay<R> {
    fn eq(&self, other: &Self) -> bool {
        self.0.map(R::to_bits) == other.0.map(R::to_bits)
    }
}

impl<R: Real> Carried for CarriedRay<R> {
    const TELLS_SCANS: bool = true;

    #[inline(always)]
    fn is_from(self, scan: u8) -> bool {
        self.curvature().is_from(scan)
    }
}
