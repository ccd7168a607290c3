//! Accuracy of every engine against exact distances.

use geosweep::Stop;
use geosweep::accuracy::{Errors, exact_disc};
use geosweep::surface::builtin::Builtin;
use geosweep::{EdgeRule, Sources, Surface, Wavefront};

use crate::common::{
    CONVERGED, at, circle, directed, off_centre, on_vulkan, rotated, vulkan_solver,
};

/// A way to compute a map. The tests run over all of [`ENGINES`].
struct Engine {
    name: &'static str,
    solve: fn(&Surface, &Sources, Wavefront, Stop) -> Vec<f32>,
}

/// Engines that must meet the error bounds.
const ENGINES: [Engine; 2] = [
    Engine {
        name: "cpu",
        solve: |surface, sources, wavefront, stop| {
            rotated(surface, sources, wavefront, stop).distances()
        },
    },
    Engine {
        name: "vulkan",
        solve: |surface, sources, wavefront, stop| {
            let seeds = sources.seeds(surface).unwrap();
            on_vulkan(&mut vulkan_solver(), surface, &seeds, wavefront, stop)
        },
    },
];

/// Converged maps in single precision have a mean relative error below a bound.
#[test]
fn fronts_of_points_are_accurate() {
    use Builtin::*;
    use Wavefront::{Circular, Curved};
    let steep = ShearedPlane { degrees: 60.0 };
    // Circular fronts at 513: plane 1.3e-7 and sheared plane 2.6e-7 (rounding), cylinder 1e-7, cone 7e-7, sphere 2.1e-5
    // (its curvature bends the front). Curved fronts: plane 1.4e-7, sheared plane 1.5e-7 and cylinder 1.3e-7 (rounding),
    // sphere 1.7e-7, cone 6.2e-7, maze 4.2e-6. With chords sphere 1.5e-6, cylinder and cone 3.5e-6. From a place between
    // grid points of the maze, outwards: 6.2e-4.
    let (far, near) = (off_centre(513, 513), [120.0, 160.0]);
    for (builtin, points, source, wavefront, bar) in [
        (Plane, 257, off_centre(257, 257), Circular, 1e-6),
        (Plane, 513, far, Circular, 1e-6),
        (steep, 513, far, Circular, 1e-6),
        (Cylinder, 513, far, Circular, 1e-6),
        (Cone, 513, far, Circular, 2e-6),
        (Sphere, 513, far, Circular, 5e-5),
        (Plane, 400, near, Curved, 1e-6),
        (steep, 400, near, Curved, 1e-6),
        (Sphere, 400, near, Curved, 1e-6),
        (Cylinder, 400, near, Curved, 1e-6),
        (Cone, 400, near, Curved, 1e-6),
        (Maze, 400, [0.0, 0.0], Curved, 6e-5),
        (Maze, 129, [64.25, 63.5], Circular, 1e-3),
    ] {
        let surface = builtin.surface(points, points).unwrap();
        let exact = builtin.exact_distances(points, points, source).unwrap();
        for engine in &ENGINES {
            let map = (engine.solve)(&surface, &at(source), wavefront, CONVERGED);
            let errors = Errors::of(&map, &exact);
            println!("{} {builtin} {points} {wavefront}: {errors}", engine.name);
            assert_eq!(errors.reached_by_one, 0, "{} {builtin} {points}", engine.name);
            assert!(errors.mean_relative < bar, "{} {builtin} {points}: {errors}", engine.name);
        }
    }
}

/// The error of curved fronts falls with the square of the spacing where the surface is smooth. With arcs for
/// edges, the error is below a fifth of the error with chords.
#[test]
fn curved_fronts_are_of_second_order() {
    for builtin in [Builtin::Sphere, Builtin::Cylinder, Builtin::Cone] {
        let error = |points: usize, rule| {
            let surface = builtin.surface(points, points).unwrap().with_edge_rule(rule);
            let source = [(points / 2) as f64, (points / 2) as f64];
            let exact = builtin.exact_distances(points, points, source).unwrap();
            let map = rotated::<f64>(&surface, &at(source), Wavefront::Curved, CONVERGED);
            Errors::of(&map.distances(), &exact).mean_relative
        };
        for (rule, points) in
            [EdgeRule::Chord, EdgeRule::Arc].into_iter().flat_map(|rule| [(rule, 33), (rule, 65)])
        {
            let (coarse, fine) = (error(points, rule), error(4 * points - 3, rule));
            let order = (coarse / fine).log2() / 2.0;
            println!("{builtin}, {rule:?}, from {points}: {coarse:.2e}, order {order:.2}");
            // On the cone at 65 points, arcs leave an error below the resolution of single precision.
            assert!(order > 1.8 || coarse < f32::EPSILON.into(), "{builtin}, {rule:?}: {order}");
        }
        let (chord, arc) = (error(129, EdgeRule::Chord), error(129, EdgeRule::Arc));
        println!("{builtin}: {chord:.2e} with chords, {arc:.2e} with arcs");
        assert!(arc < 0.2 * chord, "{builtin}: {arc} {chord}");
    }
}

/// Maps are compared with geodesics shot from the source, on surfaces that are curved in all directions. On
/// peaks, fronts meet behind bumps. The values are mean errors at 257 points and observed orders from 65
/// points.
#[test]
fn maps_converge_where_no_closed_form_exists() {
    // Measured: planar 5.1e-3 and 1.1e-2, order 0.6 (first order up to a logarithm); point-source 6.3e-5 and
    // 7.0e-4, order 1.1 and 0.9 (curvature bends the front); curved 3.3e-6 and 2.5e-4, order 1.9 and 1.4. On
    // the steep peaks, the rest of the curved front's error comes from chords: with arcs for edges the error
    // is 4.1e-5, of order 2.3.
    let bars = [
        (Builtin::Torus, [(7e-3, 0.55), (9e-5, 0.9), (6e-6, 1.8)]),
        (Builtin::Peaks, [(1.5e-2, 0.55), (1e-3, 0.8), (4e-4, 1.2)]),
    ];
    for (builtin, bars) in bars {
        let [coarse, fine] = [65, 257].map(|points: usize| {
            let surface = builtin.surface(points, points).unwrap();
            let source = [0.3125, 0.40625].map(|fraction| fraction * (points - 1) as f64);
            let reference = builtin.reference_distances(points, points, source);
            Wavefront::FOR_ANY_SURFACE.map(|wavefront| {
                let map = rotated::<f32>(&surface, &at(source), wavefront, CONVERGED);
                let errors = Errors::of(&map.distances(), &reference);
                println!("{builtin} {wavefront} {points}: {errors}");
                assert_eq!(errors.reached_by_one, 0, "{builtin} {wavefront} {points}");
                errors.mean_relative
            })
        });
        for (k, (error, order)) in bars.into_iter().enumerate() {
            let found = (coarse[k] / fine[k]).log2() / 2.0;
            println!("{builtin} {}: order {found:.2}", Wavefront::FOR_ANY_SURFACE[k]);
            assert!(fine[k] < error && found > order, "{builtin}: {} {found}", fine[k]);
        }
    }
}

/// The source is a circle, so its front consists of concentric circles. A planar front is of first order
/// there, and a front from points would be early.
#[test]
fn curved_fronts_leave_curves() {
    let points = 201;
    let (sources, exact) = circle(points, [90.0, 110.0], 40.0);
    let exact: Vec<f64> = exact.into_iter().map(|cells| cells / (points - 1) as f64).collect();
    let surface = Builtin::Plane.surface(points, points).unwrap();
    let error = |wavefront| {
        let map = rotated::<f32>(&surface, &sources, wavefront, CONVERGED).distances();
        Errors::of(&map, &exact).max_of_largest
    };
    let (planar, curved) = (error(Wavefront::Planar), error(Wavefront::Curved));
    println!("planar {planar:.2e}, curved {curved:.2e} of the largest distance");
    // Measured: 2.2e-3 and 4.4e-4. The largest errors are inside, where the front runs into its focus.
    assert!(curved < 6e-4 && curved < 0.3 * planar, "{planar} {curved}");
}

/// Travel times where speed grows linearly along a plane, v = 1 + x: rays are arcs of circles, and t =
/// acosh(1 + |a - b|^2 / (2 v(a) v(b))). The source lies at the slow side, so that no arc leaves the square.
#[test]
fn travel_times_are_accurate() {
    let points = 257;
    let speed = |col: f64| 1.0 + col / (points - 1) as f64;
    let slowness = (0..points * points).map(|index| 1.0 / speed((index % points) as f64));
    let plane = Builtin::Plane.surface(points, points).unwrap();
    let surface = plane.with_slowness(slowness.collect()).unwrap();
    let source = [64.0, 0.0];
    let straight = Builtin::Plane.exact_distances(points, points, source).unwrap();
    let exact: Vec<f64> = (0..points * points)
        .map(|index| {
            let along = straight[index].powi(2);
            let x = along / (2.0 * speed((index % points) as f64) * speed(source[1]));
            (x + (x * (x + 2.0)).sqrt()).ln_1p()
        })
        .collect();
    // Measured: planar 2.2e-3, point-source 1.7e-5.
    for (wavefront, bar) in [(Wavefront::Planar, 3e-3), (Wavefront::Circular, 3e-5)] {
        for engine in &ENGINES {
            let map = (engine.solve)(&surface, &at(source), wavefront, CONVERGED);
            let errors = Errors::of(&map, &exact);
            println!("{} {wavefront}: {errors}", engine.name);
            assert!(errors.mean_relative < bar, "{} {wavefront}", engine.name);
        }
    }
}

/// Surfaces of the paper's figure 5, from 17 to 1025 points per side, with planar fronts and one iteration.
const FIGURE_5: [Builtin; 3] =
    [Builtin::Plane, Builtin::ShearedPlane { degrees: 60.0 }, Builtin::Sphere];
const SIZES: [usize; 7] = [17, 33, 65, 129, 257, 513, 1025];

/// Returns mean relative errors after one iteration from a source that lies on every grid of [`SIZES`]. Seeds have
/// the exact values within `radius` of the source.
fn errors_after_one_iteration(engine: &Engine, builtin: Builtin, radius: f64) -> Vec<f64> {
    let is_split = matches!(builtin, Builtin::ShearedPlane { .. });
    let error = |&points: &usize| {
        let surface = builtin.surface(points, points).unwrap();
        let last = (points - 1) as f64;
        let exact = builtin.exact_distances(points, points, [last / 4.0, last * 0.375]).unwrap();
        let sources = exact_disc(surface.chart(), &exact, radius);
        // For obtuse triangles, a scan of the device reads points beyond its workgroup with their values from
        // before the scan. So these maps are iterated until they converge.
        let stop = if is_split { CONVERGED } else { Stop::after(1) };
        let map = (engine.solve)(&surface, &sources, Wavefront::Planar, stop);
        Errors::of(&map, &exact).mean_relative
    };
    SIZES.iter().map(error).collect()
}

/// Returns the CPU's errors at all sizes, after comparing the device's with them.
fn errors_of_engines(builtin: Builtin, radius: f64) -> Vec<f64> {
    let [of_cpu, of_device] =
        ENGINES.each_ref().map(|engine| errors_after_one_iteration(engine, builtin, radius));
    for (k, (a, b)) in of_cpu.iter().zip(&of_device).enumerate() {
        // Measured: up to 4 %, at 17 points.
        assert!((a - b).abs() < 0.05 * a, "{builtin}, {}: {a} {b}", SIZES[k]);
    }
    of_cpu
}

/// Returns the slope of the least-squares line through log size and log error.
fn slope(errors: &[f64]) -> f64 {
    let points: Vec<_> =
        SIZES.iter().zip(errors).map(|(&n, e)| (((n - 1) as f64).ln(), e.ln())).collect();
    let count = points.len() as f64;
    let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = points.iter().map(|(_, y)| y).sum::<f64>() / count;
    let covariance: f64 = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    covariance / points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum::<f64>()
}

/// Away from the singularity at a point source, the planar front is of first order. With exact values in a
/// disc around the source, the slope is -1.02 (plane), -1.09 (sheared), -1.02 (sphere).
#[test]
fn planar_fronts_are_of_first_order() {
    for builtin in FIGURE_5 {
        let errors = errors_of_engines(builtin, 0.15);
        println!("{builtin}: slope {:.3}, {errors:.5?}", slope(&errors));
        assert!(slope(&errors) < -0.95, "{builtin}");
    }
}

/// A front is most curved at a bare point, where each octave of distance adds an error proportional to the
/// grid spacing h. The error is thus h log(1/h): first order up to the logarithm. Over these sizes the slope
/// is -0.63 to -0.67. From 65 points on, the error divided by h log2(1/h) stays the same within a third.
#[test]
fn planar_fronts_from_a_point_are_of_first_order_but_for_a_logarithm() {
    for builtin in FIGURE_5 {
        let errors = errors_of_engines(builtin, 0.0);
        println!("{builtin}: slope {:.3}, {errors:.5?}", slope(&errors));
        assert!(slope(&errors) < -0.62, "{builtin}");
        let constant = |k: usize| {
            let cells = (SIZES[k] - 1) as f64;
            errors[k] * cells / cells.log2()
        };
        let constants: Vec<_> = (2..SIZES.len()).map(constant).collect();
        println!("    error / (h log2(1/h)): {constants:.3?}");
        let (low, high) = constants
            .iter()
            .fold((f64::INFINITY, 0.0f64), |(low, high), &c| (low.min(c), high.max(c)));
        assert!(high < 1.5 * low, "{builtin}: {constants:?}");
    }
}

/// Source of figure 6, where the maze's corridor begins.
const ENTRY: [f64; 2] = [1.0, 1.0];

#[test]
fn one_iteration_does_not_reach_the_end_of_a_maze_and_more_do() {
    // Mean relative error, and largest error relative to the largest distance. Measured: planar 8.2e-4 and
    // 3.8e-4; point-source 2.1e-4 and 2.2e-4. Nearly all of the error comes from the corners of the walls,
    // where the front turns around a grid point with a new centre.
    let points = 257;
    let surface = Builtin::Maze.surface(points, points).unwrap();
    let exact = Builtin::Maze.exact_distances(points, points, ENTRY).unwrap();
    for (wavefront, mean, largest) in
        [(Wavefront::Planar, 1e-3, 5e-4), (Wavefront::Circular, 3e-4, 3e-4)]
    {
        for engine in &ENGINES {
            let solve =
                |stop| Errors::of(&(engine.solve)(&surface, &at(ENTRY), wavefront, stop), &exact);
            let once = solve(Stop::after(1));
            println!("{} {wavefront}, one iteration: {once}", engine.name);
            assert!(once.reached_by_one > surface.points() / 2, "{}", engine.name);
            // In one iteration, the CPU's parallel scans reach only points that see the source, and these points
            // have their final values. Vulkan's successive scans also reach points with values that are not final.
            assert!(engine.name == "cpu" || once.max_of_largest > 0.01, "{}", engine.name);
            let converged = solve(CONVERGED);
            println!("{} {wavefront}, converged: {converged}", engine.name);
            assert_eq!(converged.reached_by_one, 0, "{}", engine.name);
            assert!(converged.mean_relative < mean, "{}", engine.name);
            assert!(converged.max_of_largest < largest, "{}", engine.name);
        }
    }
}

/// The maze turns twelve times. A directed iteration follows three turns, in the order of its scans. A
/// rotated iteration, whose scans go down, up, right and left, follows fewer. The last iteration confirms
/// convergence.
#[test]
fn a_maze_takes_as_many_iterations_as_its_turns() {
    for points in [65, 257] {
        let surface = Builtin::Maze.surface(points, points).unwrap();
        for wavefront in [Wavefront::Planar, Wavefront::Circular] {
            let directed = directed::<f32>(&surface, &at(ENTRY), wavefront, CONVERGED).iterations;
            let rotated = rotated::<f32>(&surface, &at(ENTRY), wavefront, CONVERGED).iterations;
            println!("{points} {wavefront}: {directed} directed, {rotated} rotated iterations");
            assert_eq!((directed, rotated), (5, 9), "{points} {wavefront}");
        }
    }
}
