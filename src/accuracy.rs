//! Measures the error of a map against exact distances, and makes sources that carry exact values.
//!
//! The tests, the tool's figures and its accuracy report all use these measures.

use crate::Sources;
use crate::surface::{Chart, Real};

/// Errors of a map against exact distances, over the points that both reach. Points with an exact distance of
/// NaN (unknown) are not counted.
///
/// ```
/// use geosweep::accuracy::Errors;
/// let errors = Errors::of(&[0.0f32, 1.0, 2.5], &[0.0, 1.0, 2.0]);
/// assert_eq!((errors.mean_relative, errors.max_relative), (0.125, 0.25));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Mean of |error| / distance. The source itself is left out.
    pub mean_relative: f64,
    /// Root of the mean of (error / distance)^2. The source itself is left out.
    pub rms_relative: f64,
    /// Largest |error| / distance. Points at distance 0 are left out.
    pub max_relative: f64,
    /// Largest |error| divided by the largest exact distance, or the largest |error| if that distance is 0.
    pub max_of_largest: f64,
    /// Number of points that only one of the two maps reaches.
    pub reached_by_one: usize,
}

impl Errors {
    /// Compares a map with exact distances, point by point.
    ///
    /// # Panics
    /// If the sizes differ, or a value of the map is NaN.
    pub fn of<R: Real>(map: &[R], exact: &[f64]) -> Self {
        assert_eq!(map.len(), exact.len(), "one exact distance for each point");
        let (mut sum, mut sum_of_squares, mut count) = (0.0, 0.0, 0);
        let (mut max_relative, mut max_error, mut largest) = (0.0f64, 0.0f64, 0.0f64);
        let mut reached_by_one = 0;
        for (found, &exact) in map.iter().map(|found| found.wide()).zip(exact) {
            assert!(!found.is_nan(), "a distance is NaN");
            if exact.is_nan() {
                continue;
            }
            match (found.is_finite(), exact.is_finite()) {
                (true, true) => {}
                (false, false) => continue,
                _ => {
                    reached_by_one += 1;
                    continue;
                }
            }
            let error = (found - exact).abs();
            largest = largest.max(exact);
            max_error = max_error.max(error);
            if exact > 0.0 {
                let relative = error / exact;
                sum += relative;
                sum_of_squares += relative * relative;
                count += 1;
                max_relative = max_relative.max(relative);
            }
        }
        let count = f64::from(count.max(1));
        Self {
            mean_relative: sum / count,
            rms_relative: (sum_of_squares / count).sqrt(),
            max_relative,
            max_of_largest: if largest > 0.0 { max_error / largest } else { max_error },
            reached_by_one,
        }
    }
}

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { mean_relative, max_relative, max_of_largest, reached_by_one, .. } = self;
        write!(f, "mean relative error {mean_relative:.2e}, largest {max_relative:.2e}, ")?;
        write!(f, "{max_of_largest:.2e} of the largest distance, {reached_by_one} reached by one")
    }
}

/// Returns sources at all grid points whose exact distance is at most `radius`. Each source starts with its
/// exact distance, so that the start has no point-source singularity. With a `radius` of 0 only the source
/// itself is left.
pub fn exact_disc(chart: Chart, exact: &[f64], radius: f64) -> Sources {
    let inside = (0..exact.len()).filter(|&index| exact[index] <= radius);
    inside.fold(Sources::default(), |sources, index| {
        let (row, col) = chart.position(index);
        sources.and_point(row as f64, col as f64, exact[index])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_only_one_map_reaches_count_apart() {
        let inf = f64::INFINITY;
        let errors = Errors::of(&[0.0, 1.1, inf, inf, 5.0], &[0.0, 1.0, 2.0, inf, inf]);
        assert_eq!(errors.reached_by_one, 2);
        approx::assert_relative_eq!(errors.mean_relative, 0.1, max_relative = 1e-12);
        approx::assert_relative_eq!(errors.rms_relative, 0.1, max_relative = 1e-12);
        approx::assert_relative_eq!(errors.max_of_largest, 0.1, max_relative = 1e-12);
    }

    #[test]
    fn points_whose_distance_is_not_known_do_not_count() {
        let errors = Errors::of(&[0.0, 1.1, 7.0, f64::INFINITY], &[0.0, 1.0, f64::NAN, f64::NAN]);
        assert_eq!(errors, Errors::of(&[0.0, 1.1], &[0.0, 1.0]));
    }

    #[test]
    fn the_source_itself_has_no_relative_error() {
        let errors = Errors::of(&[0.5f32, 2.0], &[0.0, 2.0]);
        assert_eq!((errors.mean_relative, errors.max_of_largest), (0.0, 0.25));
        assert_eq!(Errors::of(&[0.0f32], &[0.0]).rms_relative, 0.0);
    }

    #[test]
    fn a_disc_holds_the_points_within_its_radius() {
        let exact = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0];
        let disc = exact_disc(Chart { rows: 2, cols: 3 }, &exact, 1.5);
        let expected = Sources::point(0.0, 0.0).and_point(0.0, 1.0, 1.0).and_point(0.0, 2.0, 1.5);
        assert!(disc.iter().eq(expected.iter()));
    }
}
