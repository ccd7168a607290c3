//! The two precisions of the solvers.

/// Stands for "not reached" and "no such edge" inside the solvers and the shaders.
///
/// A large finite number, since GLSL does not promise infinities and their difference is NaN.
/// The public interface says +infinity instead.
pub const FAR: f64 = crate::constants::FAR;

use crate::constants::SOURCE_CURVATURE;

/// f32 for use, f64 for reference.
pub trait Real: num_traits::Float + Default + Send + Sync + std::fmt::Debug + 'static {
    /// [`FAR`] in this precision.
    const FAR: Self;

    /// Curvature of a front at a point source: as good as infinite, and its products with lengths
    /// of edges stay finite.
    const SOURCE: Self;

    /// The number with a flag in its last binary digit.
    fn with_flag(self, flag: bool) -> Self;

    /// The flag in the last binary digit.
    fn flag(self) -> bool;

    /// Rounds to this precision.
    fn of(value: f64) -> Self;

    /// Widens to double precision.
    fn wide(self) -> f64;
}

impl Real for f32 {
    const FAR: Self = FAR as f32;
    const SOURCE: Self = SOURCE_CURVATURE as f32;

    fn with_flag(self, flag: bool) -> Self {
        Self::from_bits(self.to_bits() & !1 | u32::from(flag))
    }

    fn flag(self) -> bool {
        self.to_bits() & 1 == 1
    }

    fn of(value: f64) -> Self {
        value as f32
    }

    fn wide(self) -> f64 {
        self.into()
    }
}

impl Real for f64 {
    const FAR: Self = FAR;
    const SOURCE: Self = SOURCE_CURVATURE;

    fn with_flag(self, flag: bool) -> Self {
        Self::from_bits(self.to_bits() & !1 | u64::from(flag))
    }

    fn flag(self) -> bool {
        self.to_bits() & 1 == 1
    }

    fn of(value: f64) -> Self {
        value
    }

    fn wide(self) -> f64 {
        self
    }
}
