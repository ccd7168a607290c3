//! Lanes, threads and memory of the CPU engine.

use geosweep::cpu::{Instructions, RotatedScan};
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Convergence, Stop};
use geosweep::{Sources, Spacing, Surface, Wavefront};

use crate::common::{CONVERGED, at, difference, directed, off_centre, rotated};

/// Sizes close to the width of a tile and of lanes, and lines of points.
const SIZES: [[usize; 2]; 8] =
    [[1, 40], [40, 1], [2, 2], [3, 5], [16, 16], [17, 33], [15, 100], [97, 31]];

/// Returns a wavy height field with holes.
fn holed([rows, cols]: [usize; 2]) -> Surface {
    let heights = (0..rows * cols).map(|i| (i as f64 * 0.7).sin() + (i % cols) as f64 * 0.1);
    let surface =
        Surface::from_heights(rows, cols, heights.collect(), Spacing::square(1.0)).unwrap();
    let mask: Vec<_> = (0..rows * cols).map(|i| i % 13 != 7).collect();
    surface.with_mask(&mask).unwrap()
}

#[test]
fn every_set_of_instructions_gives_the_same_map_to_the_bit() {
    println!("{:?}", Instructions::available());
    for size in SIZES {
        let surface = holed(size);
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let seeds = at([0.0, 0.0]).seeds(&surface).unwrap();
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let solve = |instructions| {
                let mut solver =
                    RotatedScan::new(&edges, wavefront).with_instructions(instructions);
                let convergence = solver.solve(&seeds, CONVERGED);
                (solver.distances(), convergence)
            };
            let baseline = solve(Instructions::Baseline);
            for instructions in Instructions::available() {
                assert_eq!(solve(instructions), baseline, "{size:?} {wavefront} {instructions}");
            }
        }
    }
}

#[test]
fn every_number_of_threads_gives_the_same_map_to_the_bit() {
    for builtin in [Builtin::Maze, Builtin::Peaks] {
        let surface = builtin.surface(120, 90).unwrap();
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let with = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let source = off_centre(120, 90);
                let source = if builtin == Builtin::Maze { [0.0, 0.0] } else { source };
                pool.install(|| rotated::<f32>(&surface, &at(source), wavefront, CONVERGED))
                    .distances()
            };
            let alone = with(1);
            assert_eq!(with(2), alone, "{builtin} {wavefront}");
            assert_eq!(with(5), alone, "{builtin} {wavefront}");
        }
    }
}

/// Skipping must not change the map: the directed scans visit every point every time.
#[test]
fn tiny_and_narrow_grids_agree_with_directed_scans() {
    for size in SIZES {
        let surface = holed(size);
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let rotated = rotated::<f64>(&surface, &at([0.0, 0.0]), wavefront, CONVERGED);
            let directed = directed::<f64>(&surface, &at([0.0, 0.0]), wavefront, CONVERGED);
            let difference = difference(&rotated.distances(), &directed.distances());
            assert!(difference < 1e-6, "{size:?} {wavefront}: {difference:e}");
        }
    }
}

#[test]
fn a_solver_forgets_the_map_before() {
    let torus = Builtin::Torus.surface(70, 50).unwrap();
    let mask: Vec<bool> = (0..70 * 50).map(|k| k % 50 != 20 || k / 50 < 40).collect();
    let torus = [torus.clone().with_mask(&mask).unwrap(), torus];
    // For the largest grid, the solver keeps transposed edges.
    let sizes = SIZES.into_iter().chain([[257, 261]]);
    for surface in torus.into_iter().chain(sizes.map(holed)) {
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let all = Wavefront::ALL.map(|wavefront| {
            Instructions::available().into_iter().map(move |instructions| (wavefront, instructions))
        });
        for (wavefront, instructions) in all.into_iter().flatten() {
            let new = || RotatedScan::new(&edges, wavefront).with_instructions(instructions);
            let mut used = new();
            let last = [surface.rows() - 1, surface.cols() - 1].map(|last| last as f64);
            for source in [[0.0; 2], last, [0.15 * last[0], 0.6 * last[1]]] {
                let Ok(seeds) = at(source).seeds(&surface) else { continue };
                let again = used.solve(&seeds, CONVERGED);
                let mut fresh = new();
                assert_eq!(fresh.solve(&seeds, CONVERGED), again);
                let same = fresh.distances() == used.distances();
                assert!(same, "{source:?} {wavefront} {instructions}");
            }
        }
    }
}

#[test]
fn a_map_without_sources_is_empty_and_ends() {
    let edges = EdgeLengths::<f32>::new(&Builtin::Plane.surface(20, 20).unwrap()).unwrap();
    let mut solver = RotatedScan::new(&edges, Wavefront::Planar);
    let convergence = solver.solve(&[], Stop::within(0.0).or_after(100));
    assert_eq!((convergence.iterations, convergence.residual), (1, 0.0));
    assert!(solver.distances().iter().all(|distance| *distance == f32::INFINITY));
}

/// This memory is in addition to the input: 16 bytes of edge lengths, two copies of times and curvatures, and
/// the surface's own curvature; with straight fronts 12 bytes of transposed lengths, from 256 points per side
/// on.
#[test]
fn memory_is_at_most_forty_bytes_a_point() {
    for (points, wavefront) in [1200, 256].into_iter().flat_map(|points| {
        Wavefront::FOR_ANY_SURFACE
            .into_iter()
            .filter(move |front| points > 256 || !front.is_curved())
            .map(move |front| (points, front))
    }) {
        let surface = Builtin::Plane.surface(points, points).unwrap();
        let seeds = Sources::point(0.0, 0.0).seeds(&surface).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let mut solver = RotatedScan::new(&edges, wavefront);
        solver.solve(&seeds, Stop::after(1));
        solver.solve(&seeds, Stop::after(1));
        let bytes = (edges.bytes() + solver.bytes()) as f64 / (points * points) as f64;
        println!("{wavefront}: {bytes:.1} bytes a point");
        assert!(bytes < 40.0, "{wavefront}: {bytes}");
    }
}

/// Two kinds of changes must not be passed on, since scans would visit whole corridors again: changes of a
/// curved front by rounding, and changes of a front around a corner while not all fronts there are known.
#[test]
fn curved_fronts_visit_few_more_points_than_planar_ones() {
    for builtin in [Builtin::Plane, Builtin::Sphere, Builtin::Peaks, Builtin::Maze] {
        let surface = builtin.surface(600, 600).unwrap();
        let source = if builtin == Builtin::Maze { [0.0, 0.0] } else { off_centre(600, 600) };
        let seeds = at(source).seeds(&surface).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let [planar, curved] = [Wavefront::Planar, Wavefront::Curved].map(|wavefront| {
            let mut solver = RotatedScan::new(&edges, wavefront);
            let Convergence { iterations, .. } = solver.solve(&seeds, CONVERGED);
            (iterations, solver.visits() as f64, solver.updates() as f64)
        });
        let (visits, updates) = (curved.1 / planar.1, curved.2 / planar.2);
        println!("{builtin}: {visits:.2} visits, {updates:.2} updates; {planar:?}, {curved:?}");
        assert!(curved.0 <= planar.0 + 2, "{builtin}: {} iterations, {}", curved.0, planar.0);
        assert!(visits < 1.25 && updates < 1.3, "{builtin}: {visits} visits, {updates} updates");
    }
}
