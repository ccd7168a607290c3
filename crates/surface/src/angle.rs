//! Computes functions of angles by polynomials, so that compilers vectorize them and shaders compute the same.

use crate::{Real, max, min};

/// Returns sine and cosine of an angle from -pi to pi, to 2e-8.
#[inline(always)]
#[doc(hidden)]
pub fn sin_cos<R: Real>(angle: R) -> [R; 2] {
    // Series of the half angle, which is at most a right angle.
    let half = angle * R::of(0.5);
    let square = half * half;
    let series = |terms: [f64; 7]| {
        terms.into_iter().rev().fold(R::zero(), |sum, term| sum * square + R::of(term))
    };
    let sine = half
        * series([
            1.0,
            -1.0 / 6.0,
            1.0 / 120.0,
            -1.0 / 5040.0,
            1.0 / 362_880.0,
            -1.0 / 39_916_800.0,
            1.0 / 6_227_020_800.0,
        ]);
    let cosine = series([
        1.0,
        -1.0 / 2.0,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40_320.0,
        -1.0 / 3_628_800.0,
        1.0 / 479_001_600.0,
    ]);
    let two = R::of(2.0);
    [two * sine * cosine, R::one() - two * sine * sine]
}

/// Returns the cosine of an angle from -pi to pi, as [`sin_cos`] does.
#[inline(always)]
#[doc(hidden)]
pub fn cosine<R: Real>(angle: R) -> R {
    sin_cos(angle)[1]
}

/// Returns the angle of a vector, from -pi to pi, to 2e-8. The angle of the zero vector is 0.
#[inline(always)]
#[doc(hidden)]
pub fn angle_of<R: Real>([x, y]: [R; 2]) -> R {
    let (across, along) = (y.abs(), x.abs());
    let (less, more) = (min(across, along), max(across, along));
    let tangent = less / max(more, R::min_positive_value());
    // For tangents above tan(pi / 8) the angle is computed from pi / 4 on.
    let is_wide = tangent > R::of(TANGENT);
    let turned = (tangent - R::one()) / (tangent + R::one());
    let t = if is_wide { turned } else { tangent };
    let square = t * t;
    let series =
        [1.0, -1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0, 1.0 / 13.0, -1.0 / 15.0];
    let angle =
        t * series.into_iter().rev().fold(R::zero(), |sum, term| sum * square + R::of(term));
    let quarter = R::of(std::f64::consts::FRAC_PI_2);
    let angle = if is_wide { angle + R::of(std::f64::consts::FRAC_PI_4) } else { angle };
    let angle = if across > along { quarter - angle } else { angle };
    let angle = if x < R::zero() { quarter + quarter - angle } else { angle };
    if y < R::zero() { -angle } else { angle }
}

/// Tangent of an eighth of a half turn.
const TANGENT: f64 = 0.414_213_562;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn are_those_of_the_standard_library() {
        for step in -1000..=1000i32 {
            let angle = f64::from(step) * std::f64::consts::PI / 1000.0;
            let [sine, cosine] = sin_cos(angle);
            assert!((sine - angle.sin()).abs() < 2e-8 && (cosine - angle.cos()).abs() < 2e-8);
            for length in [1e-3, 1.0, 1e4] {
                let found = angle_of([length * angle.cos(), length * angle.sin()]);
                assert!((found - angle).abs() < 2e-8 || step.abs() == 1000, "{angle} {found}");
            }
        }
        assert_eq!(angle_of([0.0, 0.0]), 0.0);
    }

    #[test]
    fn words_hold_angles_in_any_turn() {
        for (from, by) in [(0.3, 0.5), (3.0, 1.0), (-3.0, -1.0), (1.0, 9.0), (2.0, -17.0)] {
            let (of_single, of_double) =
                (f32::angle_ahead(0, from as f32), f64::angle_ahead(0, from));
            let turns = |angle: f64| {
                angle - (angle / std::f64::consts::TAU).round() * std::f64::consts::TAU
            };
            let single = f32::angle_between(of_single, f32::angle_ahead(of_single, by as f32));
            let double = f64::angle_between(of_double, f64::angle_ahead(of_double, by));
            assert!((f64::from(single) - turns(by)).abs() < 1e-4, "{single}");
            assert!((double - turns(by)).abs() < 2e-9, "{double}");
        }
    }
}
