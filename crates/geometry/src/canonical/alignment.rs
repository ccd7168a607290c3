//! Aligns two forms of the same points and measures how much they differ.

use nalgebra::DMatrix;

use super::form::centred;

/// The result of moving one set of points as close as possible to another by a rigid motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// The moved points, row-major.
    pub moved: Vec<f64>,
    /// The root mean square of the distances between corresponding points, divided by the root mean square of
    /// the fixed points' distances from their mean. It is 0 for congruent forms. Forms are not scaled, so the deviation
    /// exceeds 1 if the moved form is much larger than the fixed one.
    pub deviation: f64,
}

/// Moves the points `moving` onto the points `fixed`, which are in the same order.
///
/// The motion is the rotation or reflection and the translation with the smallest sum of squared distances
/// (W. Kabsch 1976; orthogonal Procrustes analysis, P. H. Schönemann 1966). Reflections are allowed, since
/// distances do not distinguish a form from its mirror image.
///
/// # Panics
/// If the arrays differ in length, or their length is not a multiple of `dimensions`.
pub fn align(moving: &[f64], fixed: &[f64], dimensions: usize) -> Alignment {
    assert_eq!(moving.len(), fixed.len(), "both forms must have the same number of points");
    assert_eq!(fixed.len() % dimensions, 0, "a whole number of points");
    let [(moving, _), (fixed, middle)] = [moving, fixed].map(|form| centred(dimensions, form));
    let decomposition = moving.tr_mul(&fixed).svd(true, true);
    let (left, right) = (decomposition.u, decomposition.v_t);
    let turn = left
        .zip(right)
        .map_or_else(|| DMatrix::identity(dimensions, dimensions), |(left, right)| left * right);
    let mut moved = moving * turn;
    let deviation = (&moved - &fixed).norm() / fixed.norm().max(f64::MIN_POSITIVE);
    moved.row_iter_mut().for_each(|mut point| point += &middle);
    Alignment { moved: moved.transpose().as_slice().to_vec(), deviation }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns points without symmetry.
    fn form() -> Vec<f64> {
        (0..30).map(|k| f64::from(k * k % 17) + 0.1 * f64::from(k)).collect()
    }

    #[test]
    fn a_turned_and_mirrored_copy_is_brought_back() {
        let fixed = form();
        let (sin, cos) = 0.7f64.sin_cos();
        let copy =
            fixed.as_chunks().0.iter().flat_map(|&[x, y, z]| {
                [7.0 - (cos * x - sin * y), 2.0 + sin * x + cos * y, z - 3.0]
            });
        let copy: Vec<f64> = copy.collect();
        let Alignment { moved, deviation } = align(&copy, &fixed, 3);
        assert!(deviation < 1e-14, "{deviation}");
        for (moved, fixed) in moved.iter().zip(&fixed) {
            approx::assert_abs_diff_eq!(moved, fixed, epsilon = 1e-12);
        }
    }

    #[test]
    fn a_form_twice_as_large_is_as_far_as_half_its_size() {
        let fixed = form();
        let half: Vec<f64> = fixed.iter().map(|coordinate| 0.5 * coordinate).collect();
        approx::assert_relative_eq!(align(&half, &fixed, 3).deviation, 0.5, max_relative = 1e-12);
    }
}
