//! Represents a part of a fan of rays as a polynomial, and inverts it.

use std::f64::consts::PI;

use glam::{DMat2, DVec2};

/// Number of rays that a polynomial in the angle interpolates.
pub(super) const RAYS: usize = 11;
const DEGREE: usize = RAYS - 1;

/// Returns the position of a ray between -1 and 1. The positions are the Chebyshev points, ends included.
pub(super) fn chebyshev_point(index: usize) -> f64 {
    (PI * (DEGREE - index) as f64 / DEGREE as f64).cos()
}

/// Returns the Chebyshev coefficients of the polynomial through values at the Chebyshev points.
pub(super) fn coefficients(values: [DVec2; RAYS], cosines: &Cosines) -> [DVec2; RAYS] {
    std::array::from_fn(|k| (0..RAYS).map(|j| values[j] * cosines.0[k][j]).sum())
}

/// The matrix with which [`coefficients`] multiplies.
pub(super) struct Cosines([[f64; RAYS]; RAYS]);

impl Cosines {
    pub(super) fn new() -> Self {
        let halved_at_ends = |k: usize| if k.is_multiple_of(DEGREE) { 0.5 } else { 1.0 };
        let entry = |k: usize, j: usize| {
            let angle = PI * (k * (DEGREE - j)) as f64 / DEGREE as f64;
            2.0 / DEGREE as f64 * halved_at_ends(k) * halved_at_ends(j) * angle.cos()
        };
        Self(std::array::from_fn(|k| std::array::from_fn(|j| entry(k, j))))
    }
}

/// The value and first two derivatives at one end of a step, with respect to the fraction of the step.
#[derive(Clone, Copy)]
pub(super) struct Knot {
    pub(super) value: DVec2,
    pub(super) first: DVec2,
    pub(super) second: DVec2,
}

/// Returns the coefficients of Hermite's polynomial of fifth degree with the given ends, lowest first, for
/// arguments from 0 to 1.
pub(super) fn quintic(start: Knot, end: Knot) -> [DVec2; 6] {
    let rise = end.value - start.value - start.first - 0.5 * start.second;
    let slope = end.first - start.first - start.second;
    let bend = end.second - start.second;
    [
        start.value,
        start.first,
        0.5 * start.second,
        10.0 * rise - 4.0 * slope + 0.5 * bend,
        -15.0 * rise + 7.0 * slope - bend,
        6.0 * rise - 3.0 * slope + 0.5 * bend,
    ]
}

/// The place (u, v) as a function of the angle, from -1 to 1 across the rays, and of the length, from 0 to 1
/// along a step.
pub(super) struct Patch {
    /// Coefficients of Chebyshev polynomials in the angle and of powers of the length.
    pub(super) coefficients: [[DVec2; 6]; RAYS],
}

impl Patch {
    /// Returns the value at (angle, length).
    pub(super) fn value(&self, at: DVec2) -> DVec2 {
        let (mut before, mut now) = (at.x, 1.0);
        let mut value = DVec2::ZERO;
        for powers in &self.coefficients {
            let along = powers.iter().rev().fold(DVec2::ZERO, |sum, &next| sum * at.y + next);
            value += now * along;
            (before, now) = (now, 2.0 * at.x * now - before);
        }
        value
    }

    /// Returns the value, and the matrix of its derivatives with respect to angle and length.
    fn linearized(&self, at: DVec2) -> (DVec2, DMat2) {
        // The Chebyshev polynomials of degrees k - 1 and k, and their derivatives.
        let ((mut before, mut now), (mut slope_before, mut slope)) = ((at.x, 1.0), (1.0, 0.0));
        let (mut value, mut derivatives) = (DVec2::ZERO, DMat2::ZERO);
        for powers in &self.coefficients {
            let (mut along, mut rate) = (DVec2::ZERO, DVec2::ZERO);
            for &next in powers.iter().rev() {
                rate = rate * at.y + along;
                along = along * at.y + next;
            }
            value += now * along;
            derivatives.x_axis += slope * along;
            derivatives.y_axis += now * rate;
            (slope_before, slope) = (slope, 2.0 * (now + at.x * slope) - slope_before);
            (before, now) = (now, 2.0 * at.x * now - before);
        }
        (value, derivatives)
    }

    /// Finds where the patch, or its continuation along the rays, takes a value, by Newton's method from a
    /// guess.
    pub(super) fn find(&self, value: DVec2, guess: DVec2) -> Option<DVec2> {
        const MOST_STEPS: usize = 12;
        /// Steps shorter than this end the search. The remaining error is the square of the step.
        const CLOSE: f64 = 1e-7;
        /// Distance beyond the first and last ray up to which the polynomial is accurate. The overlap ensures
        /// that no point is lost between this patch and the next.
        const OVERLAP: f64 = 0.01;
        let mut at = guess;
        for _ in 0..MOST_STEPS {
            let (found, derivatives) = self.linearized(at);
            let step = derivatives.inverse() * (value - found);
            // The polynomial is meaningless further away. Steps are not finite where rays cross.
            if !step.is_finite() || step.length_squared() > 4.0 {
                return None;
            }
            at += step;
            if step.abs().max_element() < CLOSE {
                return (at.x.abs() <= 1.0 + OVERLAP).then_some(at);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: DVec2, expected: DVec2, tolerance: f64) {
        assert!(found.abs_diff_eq(expected, tolerance), "{found}, not {expected}");
    }

    #[test]
    fn coefficients_are_those_of_the_polynomial() {
        let polynomial = |x: f64| DVec2::new(1.0 + 2.0 * x, 4.0 * x.powi(3) - 3.0 * x);
        let values = std::array::from_fn(|k| polynomial(chebyshev_point(k)));
        let found = coefficients(values, &Cosines::new());
        let expected = |k| match k {
            0 => DVec2::X,
            1 => 2.0 * DVec2::X,
            3 => DVec2::Y,
            _ => DVec2::ZERO,
        };
        for (k, found) in found.into_iter().enumerate() {
            assert_near(found, expected(k), 1e-15);
        }
    }

    #[test]
    fn a_quintic_is_met_by_its_ends() {
        let quintic = quintic(
            Knot { value: DVec2::ONE, first: DVec2::X, second: DVec2::Y },
            Knot { value: DVec2::ZERO, first: 3.0 * DVec2::Y, second: DVec2::X },
        );
        let [a, b, c, d, e, f] = quintic;
        assert_near(a + b + c + d + e + f, DVec2::ZERO, 1e-13);
        let first = b + 2.0 * c + 3.0 * d + 4.0 * e + 5.0 * f;
        assert_near(first, 3.0 * DVec2::Y, 1e-13);
        let second = 2.0 * c + 6.0 * d + 12.0 * e + 20.0 * f;
        assert_near(second, DVec2::X, 1e-13);
    }

    #[test]
    fn values_are_found_where_they_are() {
        // The function (x + y^2 / 4, y + x^2 / 4), in which x^2 = (T0 + T2) / 2.
        let mut coefficients = [[DVec2::ZERO; 6]; RAYS];
        coefficients[0] =
            [0.125 * DVec2::Y, DVec2::Y, 0.25 * DVec2::X, DVec2::ZERO, DVec2::ZERO, DVec2::ZERO];
        coefficients[1][0] = DVec2::X;
        coefficients[2][0] = 0.125 * DVec2::Y;
        let patch = Patch { coefficients };
        let at = DVec2::new(-0.75, 0.5);
        let value = DVec2::new(-0.75 + 0.0625, 0.5 + 0.140625);
        assert_near(patch.value(at), value, 1e-15);
        let found = patch.find(value, DVec2::ZERO).unwrap();
        assert_near(found, at, 1e-12);
        assert_eq!(patch.find(DVec2::splat(2.0), at), None);
    }
}
