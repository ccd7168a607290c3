//! The CPU solvers are compared with one another: the converged map does not depend on the order of updates.

use geosweep::Stop;
use geosweep::accuracy::Errors;
use geosweep::cpu::twins;
use geosweep::glam::DVec3;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Sources, Spacing, Surface, Wavefront};

use crate::common::{
    CONVERGED, CONVERGED_F64, Random, at, difference, directed, marched, off_centre, rotated,
};

const WAVEFRONTS: [Wavefront; 2] = [Wavefront::Planar, Wavefront::Circular];
const POINTS: usize = 97;

/// Returns every built-in surface at a size, with its name.
fn builtins(points: usize) -> Vec<(String, Surface)> {
    Builtin::ALL.iter().map(|b| (b.to_string(), b.surface(points, points).unwrap())).collect()
}

/// Returns a sheared, wavy patch. Its heights have noise of `roughness` grid steps, the fraction `holes` of its
/// points is missing, and if it is `slow`, it has a random slowness.
fn random_surface(seed: u64, roughness: f64, holes: f64, slow: bool) -> Surface {
    let points = 49;
    let mut random = Random::new(seed);
    let (a, b, shear) = (6.0 * random.next(), 6.0 * random.next(), 0.6 * random.next());
    let step = 1.0 / (points - 1) as f64;
    let positions = (0..points * points).map(|index| {
        let (u, v) = ((index % points) as f64 * step, (index / points) as f64 * step);
        let wave = 0.15 * (a * u + 3.0 * b * v).sin() * (b * u - 2.0 * v).cos();
        DVec3::new(u + shear * v, v, wave + roughness * step * random.next())
    });
    let surface = Surface::from_positions(points, points, positions.collect()).unwrap();
    let mask: Vec<_> = (0..points * points).map(|i| i == 0 || random.next() >= holes).collect();
    let surface = surface.with_mask(&mask).unwrap();
    if !slow {
        return surface;
    }
    let slowness = (0..points * points).map(|_| 0.5 + 1.5 * random.next());
    surface.with_slowness(slowness.collect()).unwrap()
}

/// Returns smooth and rough surfaces, some with slowness, some with enough holes to split the grid.
fn random_surfaces() -> Vec<(String, Surface)> {
    let kinds = [
        (0.0, 0.0, false),
        (3.0, 0.0, false),
        (0.0, 0.15, false),
        (1.0, 0.35, false),
        (0.0, 0.0, true),
        (1.0, 0.2, true),
    ];
    kinds
        .into_iter()
        .flat_map(|(roughness, holes, slow)| {
            (1..=8).map(move |seed| {
                let name = format!("random {seed}: {roughness} rough, {holes} holes, slow {slow}");
                (name, random_surface(seed, roughness, holes, slow))
            })
        })
        .collect()
}

/// Returns three differences of converged maps: between directed and rotated scans in double and in single precision,
/// and between the precisions.
fn differences(surface: &Surface, source: [f64; 2], wavefront: Wavefront) -> [f64; 3] {
    let source = at(source);
    let a = directed::<f64>(surface, &source, wavefront, CONVERGED_F64).distances();
    let b = rotated::<f64>(surface, &source, wavefront, CONVERGED_F64).distances();
    let c = rotated::<f32>(surface, &source, wavefront, CONVERGED).distances();
    let d = directed::<f32>(surface, &source, wavefront, CONVERGED).distances();
    [difference(&a, &b), difference(&c, &d), difference(&c, &a)]
}

/// Bounds of [`differences`]. In double precision, both solvers stop at a relative change of 1e-13, and in single
/// precision at 1e-6. The precisions differ by up to half a unit in the last place, 6e-8, for each of the hundreds of
/// steps of the longest path.
const SAME: [f64; 3] = [1e-12, 1e-6, 5e-6];

#[track_caller]
fn assert_below(what: &str, found: [f64; 3], bars: [f64; 3]) {
    for (found, most) in found.into_iter().zip(bars) {
        assert!(found < most, "{what}: {found:e} is not below {most:e}");
    }
}

#[test]
fn directed_and_rotated_scans_converge_to_the_same_map() {
    let random = random_surfaces().into_iter().map(|(name, surface)| (name, surface, [0.0, 0.0]));
    let built_in = builtins(POINTS)
        .into_iter()
        .map(|(name, surface)| (name, surface, off_centre(POINTS, POINTS)));
    for (name, surface, source) in built_in.chain(random) {
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            // With rough slowness, and on rough surfaces with many holes, triangles make points depend on one another,
            // so that curved fronts may converge to different results. With a slowness, curved fronts take the place of
            // circular ones.
            let is_slow = name.contains("slow true");
            let bars = match wavefront {
                Wavefront::Curved if is_slow || name.contains("0.35 holes") => [3e-2; 3],
                Wavefront::Circular if is_slow => [3e-2; 3],
                _ => SAME,
            };
            let what = format!("{name}, {wavefront}");
            assert_below(&what, differences(&surface, source, wavefront), bars);
        }
    }
    let maze = Builtin::Maze.surface(POINTS, POINTS).unwrap();
    let found = differences(&maze, off_centre(POINTS, POINTS), Wavefront::Anchored);
    assert_below("anchors in the maze", found, SAME);
}

/// Returns a plane with nine square holes of `size` points per side, and its first point.
fn plan(size: usize, seed: u64) -> (Surface, [f64; 2]) {
    let mut random = Random::new(seed);
    let (rows, cols) = (97, 61);
    let mut floor = vec![true; rows * cols];
    for _ in 0..9 {
        let [row, col] =
            [rows - size - 4, cols - size - 4].map(|most| (random.next() * most as f64) as usize);
        (row..row + size).for_each(|row| floor[row * cols + col..][..size].fill(false));
    }
    let first = floor.iter().position(|&free| free).unwrap();
    let plane = Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0));
    let from = [(first / cols) as f64, (first % cols) as f64];
    (plane.unwrap().with_mask(&floor).unwrap(), from)
}

/// Rays between grid points often turn around corners by a ratio of small whole numbers. If the smallest turn
/// that counts were such a ratio, rounding would decide whether a ray turns.
#[test]
fn curved_fronts_among_strewn_holes_do_not_depend_on_rounding() {
    let points = 49;
    let mut worst = [0.0f64; 2];
    for (holes, seed) in [0.02, 0.1].into_iter().flat_map(|holes| (1..=48).map(move |k| (holes, k)))
    {
        let mut random = Random::new(seed);
        let free: Vec<_> = (0..points * points).map(|k| k == 0 || random.next() >= holes).collect();
        let heights = vec![0.0; points * points];
        let plane = Surface::from_heights(points, points, heights, Spacing::square(1.0));
        let plane = plane.unwrap().with_mask(&free).unwrap();
        let [_, orders, precisions] = differences(&plane, [0.0, 0.0], Wavefront::Curved);
        worst = [worst[0].max(precisions), worst[1].max(orders)];
    }
    println!("single and double precision: {:.1e}, orders: {:.1e}", worst[0], worst[1]);
    // The bounds are those for surfaces without holes.
    assert!(worst[0] < 5e-6 && worst[1] < 5e-6, "{worst:?}");
}

/// Among boxes, rounding may decide where the borders of several shadows cross. This changes few plans, and
/// these only slightly.
#[test]
fn anchors_among_boxes_hardly_depend_on_the_order_of_updates() {
    let (mut plans, mut apart, mut worst) = (0, 0, [0.0f64; 3]);
    for size in [3, 5, 8, 14] {
        for seed in 1..=12 {
            let (surface, from) = plan(size, seed);
            let found = differences(&surface, from, Wavefront::Anchored);
            plans += 1;
            apart += usize::from(found[1] > 2e-5);
            worst = std::array::from_fn(|k| worst[k].max(found[k]));
        }
    }
    println!("f64 {:.1e}, f32 {:.1e}, f32 and f64 {:.1e}", worst[0], worst[1], worst[2]);
    println!("{apart} of {plans} plans by more than 2e-5");
    assert!(apart <= plans / 10, "{apart} of {plans}");
    assert_below("boxes", worst, [2e-4; 3]);
}

/// If neighbours are many grid steps higher or lower, fronts are strongly bent. A change of a front's curvature
/// must not count as a point's first front, since fronts are renewed as long as points have their first front.
#[test]
fn fronts_settle_on_the_roughest_surfaces() {
    // The cases among 150 surfaces in which a change of curvature counted as a first front.
    let cases = [
        (88, 30.0, [0.0, 0.0]),
        (96, 3000.0, [48.0, 48.0]),
        (103, 3000.0, [0.0, 0.0]),
        (143, 30.0, [0.0, 0.0]),
        (143, 30.0, [30.0, 7.0]),
    ];
    for (seed, steps, source) in cases {
        let surface = random_surface(seed, steps, 0.0, false);
        let map = rotated::<f32>(&surface, &at(source), Wavefront::Curved, CONVERGED);
        println!("{seed}, {steps} steps: {} iterations", map.iterations);
        assert!(map.residual <= CONVERGED.tolerance, "{seed}, {steps}: {}", map.residual);
    }
}

/// The front at a point depends on earlier points alone, so fast marching gives the map of the scans, over obtuse
/// triangles too. Where curved fronts meet, rounding decides which of two stays.
#[test]
fn fast_marching_agrees_with_raster_scans() {
    let mut surfaces = builtins(POINTS);
    for degrees in [30.0, 60.0, -72.0, 80.0] {
        let sheared = Builtin::ShearedPlane { degrees };
        surfaces.push((sheared.to_string(), sheared.surface(POINTS, POINTS).unwrap()));
    }
    for (name, surface) in surfaces {
        let source = at(off_centre(POINTS, POINTS));
        for wavefront in WAVEFRONTS {
            let scanned = rotated::<f32>(&surface, &source, wavefront, CONVERGED).distances();
            let single = difference(&marched::<f32>(&surface, &source, wavefront), &scanned);
            let scanned = rotated::<f64>(&surface, &source, wavefront, CONVERGED_F64).distances();
            let double = difference(&marched::<f64>(&surface, &source, wavefront), &scanned);
            println!("{name}, {wavefront}: {single:.1e}, in double precision {double:.1e}");
            assert!(single < 1e-5 && double < 1e-8, "{name}, {wavefront}: {single:e} {double:e}");
        }
    }
}

/// Obtuse triangles are split, so errors over sheared planes are those over other planes.
#[test]
fn fast_marching_is_exact_over_sheared_planes() {
    for degrees in [60.0, -72.0, 80.0] {
        let builtin = Builtin::ShearedPlane { degrees };
        let surface = builtin.surface(POINTS, POINTS).unwrap();
        let source = off_centre(POINTS, POINTS);
        let exact = builtin.exact_distances(POINTS, POINTS, source).unwrap();
        for (wavefront, bar) in [(Wavefront::Planar, 5e-3), (Wavefront::Circular, 1e-12)] {
            let map = marched::<f64>(&surface, &at(source), wavefront);
            let error = Errors::of(&map, &exact).mean_relative;
            println!("{degrees} {wavefront}: {error:.1e}");
            assert!(error < bar, "{degrees} {wavefront}: {error:e}");
        }
    }
}

/// Theorem 1 bounds the iterations that change the map. One more iteration finds that nothing changes.
#[test]
fn iterations_stay_within_theorem_1() {
    let mut bounded = 0;
    for builtin in Builtin::ALL {
        let surface = builtin.surface(POINTS, POINTS).unwrap();
        let Some(bound) = surface.iteration_bound() else { continue };
        bounded += 1;
        for source in [[0.0, 0.0], off_centre(POINTS, POINTS), [95.0, 3.0]] {
            for wavefront in WAVEFRONTS {
                let sources = at(source);
                let iterations = [
                    rotated::<f32>(&surface, &sources, wavefront, CONVERGED).iterations,
                    directed::<f32>(&surface, &sources, wavefront, CONVERGED).iterations,
                ];
                println!("{builtin} {wavefront}: {iterations:?} iterations, bound {bound}");
                let most = u64::from(iterations[0].max(iterations[1]));
                assert!(most <= bound + 1, "{builtin} {wavefront}: {most} > {bound} + 1");
            }
        }
    }
    assert_eq!(bounded, 7, "every built-in surface but the maze has a bound");
}

/// Scans that skip blocks in which nothing can change give the same map to the last bit, after the same number
/// of iterations, and some blocks are skipped. Blocks have one line, a few lines, or more lines than the grid.
#[test]
fn scans_of_blocks_that_are_due_are_whole_scans() {
    use twins::ScanOrder::{InPairs, InTurn};
    for (name, surface) in random_surfaces().into_iter().step_by(5) {
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let seeds = Sources::point(20.0, 30.5).and_point(0.0, 0.0, 1.0).seeds(&surface);
        let seeds = seeds.or_else(|_| Sources::point(0.0, 0.0).seeds(&surface)).unwrap();
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            for lines in [1, 4, 7, 100] {
                let stop = Stop::within(1e-6).or_after(60);
                let in_turn = twins::scan_in_turn(&edges, &seeds, wavefront, stop);
                let in_pairs = twins::scan_in_pairs(&edges, &seeds, wavefront, stop, lines);
                for (order, whole) in [(InTurn, &in_turn), (InPairs, &in_pairs)] {
                    let (due, visits) = twins::scan_due(
                        &edges,
                        &seeds,
                        wavefront,
                        stop,
                        (order, lines),
                        f64::INFINITY,
                    );
                    let what = format!("{name}, {wavefront}, {order:?}, {lines} lines");
                    assert_eq!(whole.distances(), due.distances(), "{what}");
                    assert_eq!(whole.iterations, due.iterations, "{what}");
                    assert_eq!(whole.residual, due.residual, "{what}");
                    assert_eq!(visits.len(), due.iterations as usize, "{what}");
                    let all = visits.iter().flatten().flatten();
                    let skipped = all.filter(|&&visited| !visited).count();
                    assert!(lines == 100 || skipped > 0, "{what}");
                }
            }
        }
    }
}
