//! Differentiates samples of a function that may have a kink nearby.
//!
//! The function is a squared arrival time, as it varies along a grid line or with the place of its source.
//! Where the map is smooth, the second differences of the function change little: over a plane they are
//! constant. Where wavefronts meet, the map has a kink, and the second difference across it is far smaller
//! than the others. So the derivative is taken from samples without such a jump.

/// The number of samples on each side.
pub(super) const SIDE: usize = 3;

/// The samples at -3, -2, ..., 3; `None` where there is none.
pub(super) type Samples = [Option<f64>; 2 * SIDE + 1];

/// The places of samples, in steps from the one in the middle.
pub(super) type Places = [f64; 2 * SIDE + 1];

/// The places of evenly spaced samples.
pub(super) const EVEN: Places = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0];

/// The largest change of second differences that counts as smooth, as a fraction of the squared length of a
/// step.
const SMOOTH: f64 = 0.5;
/// The largest such change far from the source, as a fraction of the length of a step times the root of the function. A
/// kink that is no larger turns the gradient by some thousandths of a radian at most, less than the first line of a path
/// may be off.
const SLIGHT: f64 = 0.03;

/// Differences of samples around 0.
struct Stencil {
    samples: Samples,
    places: Places,
    limit: f64,
}

/// Returns the derivative at 0. `scale` is the square of the length of a step, `since` the square root of the sample at
/// 0, and `noise` the rounding of a sample. If only samples on one side are used, the side given by the sign of `toward`
/// is preferred. Returns `None` if no samples without a kink are found.
pub(super) fn derivative(
    samples: Samples,
    (scale, since): (f64, f64),
    noise: f64,
    toward: f64,
) -> Option<f64> {
    let limit = (SMOOTH * scale).max(SLIGHT * since * scale.sqrt()) + 8.0 * noise;
    let stencil = Stencil { samples, places: EVEN, limit };
    let side = if toward < 0.0 { -1 } else { 1 };
    stencil.central().or_else(|| {
        let [near, far] = [side, -side].map(|side| stencil.on_side(side));
        // The far side is used only where the near side has no samples, as at the border.
        if stencil.at(side).is_some() { near } else { near.or(far) }
    })
}

/// Returns the derivative at 0 of samples at given places. `scale` is the square of the length of a step, `bend` the
/// change of second differences that a smooth function may have besides, and `noise` the rounding of a sample. If there
/// is a kink beside 0, only samples on the side without the kink are used. At a kink the function is the minimum of two
/// smooth functions and bends downwards, so the side without the kink is the side with the larger second difference.
pub(super) fn derivative_beside_kink(
    samples: Samples,
    places: Places,
    scale: f64,
    bend: f64,
    noise: f64,
) -> Option<f64> {
    let stencil = Stencil { samples, places, limit: SMOOTH * scale + bend + 8.0 * noise };
    stencil.central().or_else(|| {
        let [back, ahead] = [-1, 1].map(|side| stencil.bend(side));
        let side = if back > ahead || ahead.is_none() { -1 } else { 1 };
        stencil.on_side(side)
    })
}

impl Stencil {
    fn at(&self, k: isize) -> Option<f64> {
        *self.samples.get((k + SIDE as isize) as usize)?
    }

    fn place(&self, k: isize) -> f64 {
        self.places[(k + SIDE as isize) as usize]
    }

    /// Returns the second difference at `k`: the second derivative from the three samples around.
    fn bend(&self, k: isize) -> Option<f64> {
        let [back, here, ahead] = [self.at(k - 1)?, self.at(k)?, self.at(k + 1)?];
        if self.places == EVEN {
            return Some(back - 2.0 * here + ahead);
        }
        let [before, behind] =
            [self.place(k) - self.place(k - 1), self.place(k + 1) - self.place(k)];
        Some(2.0 * ((ahead - here) / behind - (here - back) / before) / (before + behind))
    }

    /// Returns whether the given second differences agree. A single second difference cannot be compared with
    /// others. It counts as smooth if it is not clearly negative, since squared times of smooth maps rarely
    /// bend downwards.
    fn is_smooth(&self, bends: &[Option<f64>]) -> bool {
        let bends = || bends.iter().flatten();
        let low = bends().fold(f64::INFINITY, |a, b| a.min(*b));
        let high = bends().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        high - low <= self.limit && (bends().count() > 1 || low >= -self.limit)
    }

    fn central(&self) -> Option<f64> {
        let [before, here, after] = [-1, 0, 1].map(|k| self.bend(k));
        here?;
        let is_whole = before.is_some() && after.is_some();
        if self.is_smooth(&[before, here, after]) {
            return Some(self.slope(if is_whole { &[-2, -1, 1, 2] } else { &[-1, 1] }));
        }
        // If the kink is further away, the three samples in the middle are smooth. The kink lowers one of the
        // other two second differences, so the one in the middle is compared with the larger of these two.
        let larger = if before > after { before } else { after };
        (is_whole && self.is_smooth(&[larger, here])).then(|| self.slope(&[-1, 1]))
    }

    /// Returns the derivative at 0 of the polynomial through the sample at 0 and the given ones.
    fn slope(&self, around: &[isize]) -> f64 {
        let here = self.at(0).unwrap_or(f64::NAN);
        let term = |&k: &isize| {
            let place = self.place(k);
            let others = around.iter().filter(|&&other| other != k).map(|&other| self.place(other));
            let weight: f64 = others.map(|other| other / (other - place)).product();
            weight / place * (self.at(k).unwrap_or(f64::NAN) - here)
        };
        around.iter().map(term).sum()
    }

    /// Returns the derivative at 0 from the samples at 0 and on one side.
    fn on_side(&self, side: isize) -> Option<f64> {
        let [first, second, third] = [side, 2 * side, 3 * side];
        if [0, first, second].iter().any(|&k| self.at(k).is_none()) {
            return None;
        }
        let [bend, next] = [self.bend(first), self.bend(second)];
        if !self.is_smooth(&[bend, next]) {
            return None;
        }
        Some(match self.at(third) {
            Some(_) => self.slope(&[first, second, third]),
            None => self.slope(&[first, second]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn samples(function: impl Fn(f64) -> f64) -> Samples {
        std::array::from_fn(|k| Some(function(k as f64 - SIDE as f64)))
    }

    fn cubic(x: f64) -> f64 {
        (x - 10.0).powi(2) + 0.01 * x.powi(3)
    }

    #[test]
    fn cubics_have_exact_derivatives_from_both_sides_or_one() {
        let all = samples(cubic);
        assert_abs_diff_eq!(derivative(all, (1.0, 0.0), 0.0, 1.0).unwrap(), -20.0, epsilon = 1e-12);
        for (kept, toward) in [(0..4, 1.0), (0..4, -1.0), (3..7, 1.0), (3..7, -1.0)] {
            let mut some = [None; 7];
            some[kept.clone()].copy_from_slice(&all[kept]);
            let found = derivative(some, (1.0, 0.0), 0.0, toward).unwrap();
            assert_abs_diff_eq!(found, -20.0, epsilon = 1e-12);
        }
    }

    #[test]
    fn samples_at_uneven_places_have_the_derivative_of_the_polynomial_through_them() {
        let places = [-4.5, -2.5, -2.0, 0.0, 0.25, 3.0, 3.5];
        let all = places.map(|x| Some(cubic(x)));
        for kept in [0..7, 0..4, 3..7, 1..6] {
            let mut some = [None; 7];
            some[kept.clone()].copy_from_slice(&all[kept.clone()]);
            let found = derivative_beside_kink(some, places, 1.0, 0.0, 0.0).unwrap();
            assert_abs_diff_eq!(found, -20.0, epsilon = 1e-12);
        }
    }

    #[test]
    fn beside_a_kink_the_derivative_is_the_one_of_its_own_side() {
        // The fronts of two sources at -20 and 20 + 2 k meet at k.
        for kink in [-2.5, -1.5, -0.75, 0.75, 1.5, 2.5] {
            let meet = samples(|x| (x + 20.0f64).min(20.0 + 2.0 * kink - x).powi(2));
            let (toward, exact) = if kink > 0.0 { (-1.0, 40.0) } else { (1.0, -40.0 - 4.0 * kink) };
            for found in [
                derivative(meet, (1.0, 0.0), 0.0, toward),
                derivative_beside_kink(meet, EVEN, 1.0, 0.0, 0.0),
            ] {
                assert_abs_diff_eq!(found.unwrap(), exact, epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn there_is_no_derivative_between_kinks_or_without_samples() {
        let between = samples(|x| (10.0 - x.abs()).powi(2) - if x == 0.0 { 9.0 } else { 0.0 });
        assert_eq!(derivative(between, (1.0, 0.0), 0.0, 1.0), None);
        assert_eq!(
            derivative([None, None, Some(1.0), Some(2.0), None, None, None], (1.0, 0.0), 0.0, 1.0),
            None
        );
    }
}
