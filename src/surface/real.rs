//! The two precisions of the solvers.

/// Stands for "not reached" and "no such edge" inside the solvers and the shaders.
///
/// A large finite number, since GLSL does not promise infinities and their difference is NaN.
/// The public interface says +infinity instead.
pub const FAR: f64 = crate::constants::FAR;

/// f32 for use, f64 for reference.
pub trait Real: num_traits::Float + Default + Send + Sync + std::fmt::Debug + 'static {
    /// [`FAR`] in this precision.
    const FAR: Self;

    /// Rounds to this precision.
    fn of(value: f64) -> Self;

    /// Widens to double precision.
    fn wide(self) -> f64;
}

impl Real for f32 {
    const FAR: Self = FAR as f32;

    fn of(value: f64) -> Self {
        value as f32
    }

    fn wide(self) -> f64 {
        self.into()
    }
}

impl Real for f64 {
    const FAR: Self = FAR;

    fn of(value: f64) -> Self {
        value
    }

    fn wide(self) -> f64 {
        self
    }
}
