//! Maps in double precision: the error that remains, and the options that are refused.

use geosweep::accuracy::Errors;
use geosweep::surface::builtin::Builtin;
use geosweep::{
    DEFAULT_TOLERANCE_F64, DeviceChoice, Engine, Error, Options, Sources, UsedEngine, Wavefront,
    distance_map, distance_map_f64, estimate_error_f64, vulkan,
};

use crate::common::curved;

fn options(wavefront: Wavefront) -> Options {
    curved().with_wavefront(wavefront)
}

/// Returns the mean relative errors in double and in single precision.
fn errors(builtin: Builtin, points: usize, wavefront: Wavefront) -> [f64; 2] {
    let surface = builtin.surface(points, points).unwrap();
    let source = [(points * 3 / 10) as f64, (points * 2 / 5) as f64];
    let sources = Sources::point(source[0], source[1]);
    let exact = builtin.exact_distances(points, points, source).unwrap();
    let options = options(wavefront);
    let double = distance_map_f64(&surface, &sources, &options).unwrap();
    assert!(double.report.converged && double.report.tolerance == DEFAULT_TOLERANCE_F64);
    let single = distance_map(&surface, &sources, &options).unwrap();
    let of_double = Errors::of(&double.distances, &exact);
    assert_eq!(of_double.reached_by_one, 0);
    [of_double.mean_relative, Errors::of(&single.distances, &exact).mean_relative]
}

#[test]
fn double_precision_is_free_of_single_precisions_rounding() {
    // Measured at 200 x 200 points: 1e-16 to 3e-16 on the planes, and 2e-13 on the cylinder, due to the formula
    // for the lengths of arcs. In single precision: 7e-8 to 1.1e-7 on all of these surfaces.
    let bars = [
        (Builtin::Plane, 1e-14),
        (Builtin::ShearedPlane { degrees: 60.0 }, 1e-14),
        (Builtin::Cylinder, 1e-12),
    ];
    for (builtin, bar) in bars {
        for wavefront in [Wavefront::Circular, Wavefront::Curved] {
            let [double, single] = errors(builtin, 200, wavefront);
            println!("{builtin} {wavefront}: {double:.1e}, {single:.1e}");
            assert!(double < bar && single > 1e-8, "{builtin} {wavefront}: {double} {single}");
        }
    }
    // The error of the method itself stays.
    let [double, single] = errors(Builtin::Sphere, 100, Wavefront::Circular);
    approx::assert_relative_eq!(double, single, max_relative = 1e-2);
}

#[test]
fn mazes_are_exact_with_anchors() {
    let [double, single] = {
        let surface = Builtin::Maze.surface(129, 129).unwrap();
        let (source, options) = (Sources::point(0.0, 0.0), options(Wavefront::Anchored));
        let exact = Builtin::Maze.exact_distances(129, 129, [0.0; 2]).unwrap();
        let double = distance_map_f64(&surface, &source, &options).unwrap();
        let single = distance_map(&surface, &source, &options).unwrap();
        [Errors::of(&double.distances, &exact), Errors::of(&single.distances, &exact)]
    };
    assert!(double.max_relative < 1e-10 && single.mean_relative > 1e-8, "{double} {single}");
}

#[test]
fn a_double_map_converts_to_single_precision() {
    let surface = Builtin::Peaks.surface(33, 41).unwrap();
    let sources = Sources::point(3.25, 4.5).and_point(20.0, 30.0, 0.5);
    let double = distance_map_f64(&surface, &sources, &Options::default()).unwrap();
    let single = double.to_single();
    assert_eq!(single.distance(30, 7), double.distance(30, 7) as f32);
    assert_eq!((single.chart, &single.report), (double.chart, &double.report));
    let own = distance_map(&surface, &sources, &options(double.report.wavefront)).unwrap();
    for (index, (rounded, own)) in single.distances.iter().zip(&own.distances).enumerate() {
        // In single precision, directions of rays have 16 binary digits.
        approx::assert_relative_eq!(rounded, own, max_relative = 5e-4);
        assert_eq!(*rounded, double.distances[index] as f32);
    }
}

#[test]
fn start_values_keep_the_digits_that_single_precision_lacks() {
    let surface = Builtin::Plane.surface(50, 50).unwrap();
    let sources = Sources::default().and_point(0.0, 0.0, 1e9);
    let map = distance_map_f64(&surface, &sources, &options(Wavefront::Curved)).unwrap();
    approx::assert_relative_eq!(map.distance(0, 49) - 1e9, 1.0, max_relative = 1e-6);
    assert_eq!(map.report.max_distance, map.distance(49, 49));
}

#[test]
fn errors_are_estimated_in_double_precision_too() {
    let (builtin, source) = (Builtin::Sphere, [30.0, 40.0]);
    let surface = builtin.surface(129, 129).unwrap();
    let exact = builtin.exact_distances(129, 129, source).unwrap();
    let sources = Sources::point(source[0], source[1]);
    let estimate = estimate_error_f64(&surface, &sources, &options(Wavefront::Curved)).unwrap();
    let error = Errors::of(&estimate.map.distances, &exact).mean_relative;
    let (estimated, _) = estimate.relative();
    assert!(estimated > error && estimated < 1.5 * error, "{estimated} {error}");
    assert_eq!(estimate.unknown(), 0);
    let extrapolated = estimate.into_extrapolated_map();
    let left = Errors::of(&extrapolated.distances, &exact).mean_relative;
    println!("{error:e}, estimated {estimated:e}, {left:e} left");
    assert!(left < 0.2 * error, "{left} {error}");
    let farthest = extrapolated.distances.iter().copied().fold(0.0, f64::max);
    assert_eq!(extrapolated.report.max_distance, farthest);
}

#[test]
fn devices_and_schedules_are_refused() {
    let surface = Builtin::Plane.surface(5, 5).unwrap();
    let (source, auto) = (Sources::point(0.0, 0.0), Options::default());
    for options in [
        auto.clone().with_engine(Engine::Vulkan(DeviceChoice::Any)),
        auto.clone().with_schedule(vulkan::Schedule::Tiles),
    ] {
        let refused = distance_map_f64(&surface, &source, &options);
        assert!(matches!(refused, Err(Error::Options(_))), "{refused:?}");
        assert!(estimate_error_f64(&surface, &source, &options).is_err());
    }
    for (engine, used) in [
        (Engine::Auto, UsedEngine::Cpu),
        (Engine::Cpu, UsedEngine::Cpu),
        (Engine::FastMarching, UsedEngine::FastMarching),
    ] {
        let map = distance_map_f64(&surface, &source, &auto.clone().with_engine(engine)).unwrap();
        assert_eq!((map.report.engine, map.report.fallback), (used, None));
    }
}
