//! Maps that end at a radius or at targets, compared with the whole map.

use geosweep::surface::Real;
use geosweep::{Options, Sources, Spacing, Surface, Targets, distance_map};

/// Returns the largest distance of a map.
pub fn farthest<R: Real>(map: &[R]) -> f64 {
    let finite = map.iter().filter(|distance| distance.is_finite());
    finite.fold(0.0, |far, distance| far.max(distance.wide()))
}

/// Asserts that `near` is the part of `whole` within the radius, and that beyond it nothing is reached.
pub fn assert_is_part<R: Real>(near: &[R], whole: &[R], radius: f64, what: &str) {
    for (index, (near, whole)) in near.iter().zip(whole).enumerate() {
        let (near, whole) = (near.wide(), whole.wide());
        // At the radius itself rounding decides.
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

/// Asserts that maps with these options end at any, at the two nearest or at all of some targets.
pub fn assert_targets_end_maps(options: &Options) {
    let surface = Surface::from_heights(40, 50, vec![0.0; 2000], Spacing::square(1.0)).unwrap();
    let points = [[20, 26], [20, 40], [8, 20]];
    for (targets, end) in [
        (Targets::any(points), 6.0),
        (Targets::nearest(2, points), 12.0),
        (Targets::all(points), 20.0),
        // A target at the source ends the map at once.
        (Targets::any([[20, 20]]), 0.0),
    ] {
        let options = options.clone().with_targets(targets);
        let map = distance_map(&surface, &Sources::point(20.0, 20.0), &options).unwrap();
        let found = (map.report.max_distance, map.report.ends_at);
        assert_eq!(found, (end, Some(end)), "{options:?}");
    }
}
