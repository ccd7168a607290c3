//! Implements automatic differentiation: numbers that carry their derivatives with respect to u and v, up to
//! second order.

use std::ops::{Add, Mul, Sub};

use glam::{DVec2, DVec3};

/// The numbers with which parametrisations compute: plain numbers, or jets where derivatives are needed.
pub(super) trait Smooth:
    Copy
    + Add<Output = Self>
    + Add<f64, Output = Self>
    + Sub<Output = Self>
    + Sub<f64, Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + From<f64>
{
    fn sin_cos(self) -> (Self, Self);
    fn tan(self) -> Self;
    fn exp(self) -> Self;
    /// Returns 1 / sqrt(x).
    fn recip_sqrt(self) -> Self;

    fn squared(self) -> Self {
        self * self
    }
}

impl Smooth for f64 {
    fn sin_cos(self) -> (Self, Self) {
        self.sin_cos()
    }

    fn tan(self) -> Self {
        self.tan()
    }

    fn exp(self) -> Self {
        self.exp()
    }

    fn recip_sqrt(self) -> Self {
        self.sqrt().recip()
    }
}

/// The value and derivatives of a function of u and v at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jet {
    pub(super) value: f64,
    /// Derivatives with respect to u and v.
    pub(super) first: DVec2,
    /// Derivatives with respect to uu, uv and vv.
    pub(super) second: DVec3,
}

impl Jet {
    /// Returns u and v themselves as jets.
    pub(super) fn variables(uv: DVec2) -> [Self; 2] {
        let variable = |value, first| Self { value, first, second: DVec3::ZERO };
        [variable(uv.x, DVec2::X), variable(uv.y, DVec2::Y)]
    }

    /// Applies a function to this value by the chain rule, given the function's value and derivatives there.
    fn chain(self, value: f64, first: f64, second: f64) -> Self {
        Self {
            value,
            first: first * self.first,
            second: first * self.second + second * products(self.first, self.first),
        }
    }
}

/// Returns the symmetric product of two gradients.
fn products(a: DVec2, b: DVec2) -> DVec3 {
    DVec3::new(a.x * b.x, 0.5 * (a.x * b.y + a.y * b.x), a.y * b.y)
}

impl Smooth for Jet {
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (self.chain(sin, cos, -sin), self.chain(cos, -sin, -cos))
    }

    fn tan(self) -> Self {
        let tan = self.value.tan();
        let slope = 1.0 + tan * tan;
        self.chain(tan, slope, 2.0 * tan * slope)
    }

    fn exp(self) -> Self {
        let exp = self.value.exp();
        self.chain(exp, exp, exp)
    }

    fn recip_sqrt(self) -> Self {
        let recip = self.value.recip();
        let root = recip.sqrt();
        self.chain(root, -0.5 * root * recip, 0.75 * root * recip * recip)
    }
}

impl From<f64> for Jet {
    fn from(value: f64) -> Self {
        Self { value, first: DVec2::ZERO, second: DVec3::ZERO }
    }
}

impl Add for Jet {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }
}

impl Sub for Jet {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl Mul for Jet {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            first: self.value * other.first + other.value * self.first,
            second: self.value * other.second
                + other.value * self.second
                + 2.0 * products(self.first, other.first),
        }
    }
}

impl Add<f64> for Jet {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl Sub<f64> for Jet {
    type Output = Self;

    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl Mul<f64> for Jet {
    type Output = Self;

    fn mul(self, other: f64) -> Self {
        Self { value: self.value * other, first: self.first * other, second: self.second * other }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes a function that uses every operation.
    fn function<T: Smooth>([u, v]: [T; 2]) -> T {
        let (sin, cos) = (u * v).sin_cos();
        let root = (u.squared() + v * 3.0 + 1.0).recip_sqrt();
        (sin * u - cos) * root + (v - u * 0.5).tan() * (u - v.squared()).exp() - 2.0
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let at = DVec2::new(0.7, 0.4);
        let jet = function(Jet::variables(at));
        let value = |u: f64, v: f64| function([at.x + u, at.y + v]);
        approx::assert_relative_eq!(jet.value, value(0.0, 0.0), max_relative = 1e-15);
        // The error of central differences is the square of the step, plus rounding divided by the step.
        let h = 1e-4;
        let first = DVec2::new(value(h, 0.0) - value(-h, 0.0), value(0.0, h) - value(0.0, -h));
        assert!(jet.first.abs_diff_eq(first / (2.0 * h), 1e-6), "{}", jet.first);
        let bend = |u: f64, v: f64| (value(u, v) - 2.0 * value(0.0, 0.0) + value(-u, -v)) / (h * h);
        let mixed = value(h, h) - value(h, -h) - value(-h, h) + value(-h, -h);
        let second = DVec3::new(bend(h, 0.0), mixed / (4.0 * h * h), bend(0.0, h));
        assert!(jet.second.abs_diff_eq(second, 1e-5), "{}", jet.second);
    }
}
