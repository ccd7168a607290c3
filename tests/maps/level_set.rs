//! Maps from the zero of a level set, compared with distances from circles and lines.

use geosweep::geometry::level_set;
use geosweep::{Options, Spacing, Surface, distance_map_f64};

/// Returns the mean error of distances from the zero of a signed distance, on `n` x `n` points of the unit square. The
/// level set is the distance times a positive function.
fn mean_error(n: usize, exact: impl Fn(f64, f64) -> f64, factor: impl Fn(f64, f64) -> f64) -> f64 {
    let step = 1.0 / (n - 1) as f64;
    let at = |index: usize| ((index % n) as f64 * step, (index / n) as f64 * step);
    let values = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        (0..n * n).map(at).map(|(x, y)| f(x, y)).collect()
    };
    let surface = Surface::from_heights(n, n, vec![0.0; n * n], Spacing::square(step)).unwrap();
    let phi = values(&|x, y| exact(x, y) * factor(x, y));
    let sources = level_set(surface.chart(), &phi).unwrap();
    let map = distance_map_f64(&surface, &sources, &Options::default()).unwrap();
    let pairs = map.distances.iter().zip(values(&exact));
    pairs.map(|(found, exact)| (found - exact.abs()).abs()).sum::<f64>() / (n * n) as f64
}

#[test]
fn distances_from_circles_are_of_second_order() {
    let circle = |x: f64, y: f64| (x - 0.47).hypot(y - 0.52) - 0.23;
    let two = |x: f64, y: f64| {
        let left = (x - 0.27).hypot(y - 0.31) - 0.12;
        left.min((x - 0.72).hypot(y - 0.66) - 0.17)
    };
    let (one, wavy) = (|_, _| 1.0, |x: f64, y: f64| 1.0 + 0.5 * (3.0 * x + 2.0 * y).sin());
    let sizes = [33, 65, 129];
    for (name, errors) in [
        ("circle", sizes.map(|n| mean_error(n, circle, one))),
        ("circle, wavy", sizes.map(|n| mean_error(n, circle, wavy))),
        ("two circles", sizes.map(|n| mean_error(n, two, one))),
        ("two circles, wavy", sizes.map(|n| mean_error(n, two, wavy))),
    ] {
        println!("{name}: {errors:.1?} {:?}", errors.map(|error| format!("{error:.1e}")));
        assert!(errors[0] < 6e-4, "{name}: {errors:?}");
        assert!(errors.windows(2).all(|pair| pair[1] < pair[0] / 3.3), "{name}: {errors:?}");
    }
}
