//! Determines the distance of the points that split obtuse triangles.
//!
//! In a constant metric, the triangles without an obtuse angle are those of the reduced basis of Lagrange and Gauss:
//! two steps and their shorter sum or difference. Splitting an obtuse triangle leads to them. So the reduced basis
//! of the metric in a triangle tells beforehand how far the search for its splits has to go.

use glam::{DMat2, DVec2};

use crate::constants::{FARTHEST_SPLIT, OBTUSE, SPLIT_REACH};
use crate::real::{Real, max, min};

/// Maximum number of steps by which a basis is reduced. Each at least halves the longer side, up to the last one.
const MOST_STEPS: usize = 64;
/// Part of the square of the shorter side below which two sides are at a right angle.
const RIGHT: f64 = 5e-6;

/// Returns the steps of the triangles without an obtuse angle in a constant metric: the reduced basis, and the shorter
/// sum of both steps, or zero if the steps are at a right angle. `steps` are two steps in rows and columns, and
/// `squares` the squared lengths of the first, of the second and of their difference.
fn reduced(steps: [DVec2; 2], squares: [f64; 3]) -> [DVec2; 3] {
    let [first, second, base] = squares;
    let ([mut short, mut long], mut of_short, mut of_long) = (steps, first, second);
    let mut along = 0.5 * (first + second - base);
    for _ in 0..MOST_STEPS {
        if of_long < of_short {
            (short, long) = (long, short);
            (of_short, of_long) = (of_long, of_short);
        }
        let times = (along / of_short).round();
        if times == 0.0 || !times.is_finite() {
            break;
        }
        long -= times * short;
        of_long += times * (times * of_short - 2.0 * along);
        along -= times * of_short;
    }
    let third = match along.abs() > RIGHT * of_short {
        true => long - along.signum() * short,
        false => DVec2::ZERO,
    };
    [short, long, third]
}

/// Returns the reduced basis of the grid in a metric: the shortest step of rows and columns, and the shortest one in
/// another direction.
pub fn reduced_basis(metric: DMat2) -> [DVec2; 2] {
    let steps = [DVec2::X, DVec2::Y];
    let square = |step: DVec2| step.dot(metric * step);
    let squares = [square(steps[0]), square(steps[1]), square(steps[0] - steps[1])];
    let [short, long, _] = reduced(steps, squares);
    [short, long]
}

/// Returns the largest distance, in rows and columns, of the points that split a triangle at x0, if the metric around it
/// is that of the triangle. Returns 1 if the triangle is not obtuse: if the squares of the sides at x0 add up to more
/// than `limit` times that of the base. `steps` are two steps in rows and columns, and `squares` the squared lengths of
/// the first, of the second and of their difference.
pub fn splits_within<R: Real>(steps: [DVec2; 2], squares: [R; 3], limit: f64) -> usize {
    let [a, b, base] = squares;
    let is_there = max(a, max(b, base)) < R::FAR * R::FAR;
    if !is_there || a + b >= R::of(limit) * base {
        return 1;
    }
    let all = reduced(steps, squares.map(Real::wide));
    all.iter().fold(1.0, |most, step| step.abs().max_element().max(most)) as usize
}

/// Returns the distance of [`splits_within`], or 1 if it does not exceed [`SPLIT_REACH`] for certain, which is quickly
/// known of most triangles.
pub(crate) fn reach<R: Real>(steps: [DVec2; 2], squares: [R; 3]) -> usize {
    let [a, b, base] = squares;
    // The limit errs towards too many triangles, to allow for rounding.
    if may_reach_far(a, b, base) { splits_within(steps, squares, 1.001 * OBTUSE) } else { 1 }
}

/// Returns the distance in rows and columns from which updates read points, on a surface with obtuse triangles whose
/// splits need the distance `needed`.
pub(crate) fn of_updates(needed: usize) -> usize {
    if needed <= SPLIT_REACH as usize { SPLIT_REACH as usize } else { FARTHEST_SPLIT as usize }
}

/// Returns whether the points that split an obtuse triangle may be more than [`SPLIT_REACH`] rows or columns away. It is
/// so if one side at x0 is short and the other reaches many of its lengths back, or if the angle is so wide that further
/// steps of the reduction may follow the first.
#[inline(always)]
fn may_reach_far<R: Real>(a: R, b: R, base: R) -> bool {
    let twice_along = base - a - b;
    let is_wide = twice_along * twice_along > R::of(3.2) * a * b;
    (twice_along > R::of(10.0) * min(a, b)) | is_wide
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns squared lengths of two steps and of their difference in a metric of axes 1 to `ratio`, turned by `angle`.
    fn squares(ratio: f64, angle: f64, steps: [DVec2; 2]) -> [f64; 3] {
        let axis = DVec2::from_angle(angle);
        let square = |step: DVec2| {
            let [along, across] = [axis.dot(step), axis.perp_dot(step)];
            along * along + ratio * ratio * across * across
        };
        [square(steps[0]), square(steps[1]), square(steps[0] - steps[1])]
    }

    #[test]
    fn reduced_steps_make_no_obtuse_triangle_and_are_short() {
        for ratio in [1.0, 3.0, 8.0, 15.0, 100.0] {
            for turn in 0..200 {
                let angle = 0.0157 * f64::from(turn) + 1e-3;
                let found =
                    reduced([DVec2::X, DVec2::Y], squares(ratio, angle, [DVec2::X, DVec2::Y]));
                let [short, long, _] = found;
                assert!((short.perp_dot(long).abs() - 1.0).abs() < 1e-9);
                let [a, b, c] = squares(ratio, angle, [short, long]);
                assert!((a + b - c).abs() <= a.min(b) * (1.0 + 1e-9), "{ratio} {angle} {found:?}");
                let most =
                    found.map(|step| step.abs().max_element()).into_iter().fold(0.0, f64::max);
                assert!(most <= 0.5 * ratio + 2.0, "{ratio} {angle} {found:?}");
            }
        }
    }

    /// The quick test leaves out no triangle whose reduced basis reaches far.
    #[test]
    fn no_far_point_is_missed() {
        let ring: [DVec2; 8] =
            [(0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0), (1, 1)]
                .map(|(row, col)| DVec2::new(row.into(), col.into()));
        let mut far = 0;
        for ratio in [3.0, 8.0, 13.0, 15.0, 20.0, 50.0, 100.0, 400.0] {
            for cells in [1.0, 0.3, 0.05, 4.0, 30.0] {
                for turn in 0..500 {
                    let angle = 0.006_283 * f64::from(turn) + 3e-4;
                    let wide = |step: DVec2| DVec2::new(step.x, cells * step.y);
                    let (mut reaches, mut found) = (0.0, 1);
                    for to in 0..8 {
                        let steps = [ring[to], ring[(to + 1) % 8]];
                        let [a, b, c] = squares(ratio, angle, steps.map(wide));
                        if a + b >= OBTUSE * c {
                            continue;
                        }
                        let all = reduced(steps, [a, b, c]);
                        let longest = |most: f64, step: &DVec2| most.max(step.abs().max_element());
                        reaches = all.iter().fold(reaches, longest);
                        found = found.max(reach(steps, [a, b, c]));
                    }
                    if reaches > f64::from(SPLIT_REACH) {
                        far += 1;
                        assert_eq!(found as f64, reaches, "{ratio} {cells} {angle}");
                    }
                }
            }
        }
        assert!(far > 1000);
    }
}
