//! Maps that end at a radius or at targets, held against the whole map.

use geosweep::surface::Real;

/// Returns the largest distance of a map.
pub fn farthest<R: Real>(map: &[R]) -> f64 {
    let finite = map.iter().filter(|distance| distance.is_finite());
    finite.fold(0.0, |far, distance| far.max(distance.wide()))
}

/// Asserts that `near` is the part of `whole` within the radius, and that beyond it nothing is reached.
pub fn assert_is_part<R: Real>(near: &[R], whole: &[R], radius: f64, what: &str) {
    for (index, (near, whole)) in near.iter().zip(whole).enumerate() {
        let (near, whole) = (near.wide(), whole.wide());
        // On the edge itself rounding decides.
        if whole > radius * (1.0 + 1e-6) {
            assert!(near.is_infinite(), "{what}, point {index}: {near} of {whole}");
        } else if whole < radius * (1.0 - 1e-6) {
            assert!((near - whole).abs() <= 1e-6 * whole, "{what}, point {index}: {near}, {whole}");
        }
    }
}

/// Returns the number of points that a map reaches.
pub fn reached<R: Real>(map: &[R]) -> usize {
    map.iter().filter(|distance| distance.is_finite()).count()
}
