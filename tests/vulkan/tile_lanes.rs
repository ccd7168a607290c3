//! The forms in which GPUs run the pass over tiles, on any device, compared with the form in which CPUs run it and with
//! the twin.

use geosweep::surface::builtin::Builtin;
use geosweep::surface::{Seed, Surface};
use geosweep::vulkan::{HeadlessSolution, HeadlessSolver, Method, Schedule, TileLanes, Tuning};
use geosweep::{Sources, Spacing, Stop, Wavefront};

use crate::common::fibres::Fibres;
use crate::common::*;
use crate::headless::{assert_schedule_twins, is_processor};

/// Lines of 8 points fit a subgroup of lavapipe, and lines of 16 points do not. Tiles of 24 points a side fit
/// lavapipe's shared memory only if their edges stay in the image.
const FORMS: [(TileLanes, u32, bool, u32); 4] = [
    (TileLanes::Shuffled, 8, true, 1),
    (TileLanes::Shuffled, 16, false, 2),
    (TileLanes::Points, 16, true, 1),
    (TileLanes::Points, 24, false, 1),
];

fn solver(tile_lanes: TileLanes, tile: u32, tile_edges: bool, inner: u32) -> HeadlessSolver {
    tuned(|old| Tuning { tile_lanes, tile, small_grid: 0, tile_edges, inner, ..old })
}

pub struct Problem {
    pub what: &'static str,
    pub surface: Surface,
    pub seeds: Vec<Seed>,
    pub wavefronts: &'static [Wavefront],
}

impl Problem {
    fn new(
        what: &'static str,
        surface: Surface,
        sources: &Sources,
        wavefronts: &'static [Wavefront],
    ) -> Self {
        let seeds = sources.seeds(&surface).unwrap();
        Self { what, surface, seeds, wavefronts }
    }
}

/// A field on which points up to 16 rows and columns away split triangles.
pub const FIBRES: Fibres =
    Fibres { rows: 49, cols: 62, ratio: 21.0, amplitude: 4.0, is_transposed: false };

/// Returns problems with holes, obtuse triangles near and far, an uneven slowness, fronts of several origins, and anchors. No side
/// of a grid is a multiple of a tile's side.
pub fn problems() -> Vec<Problem> {
    use Wavefront::{Anchored, Circular, Curved, Planar};
    let sphere = Builtin::Sphere.surface(45, 39).unwrap();
    let holes = rough(41, 54, 5);
    let slowed = slowed(40, 53, 30);
    let plane = Surface::from_heights(37, 50, vec![0.0; 37 * 50], Spacing::square(0.7)).unwrap();
    let several = Sources::point(3.0, 5.0).and_point(30.0, 41.0, 1.5).and_point(20.25, 8.5, 0.5);
    let maze = Builtin::Maze.surface(51, 43).unwrap();
    vec![
        Problem::new("sphere", sphere, &Sources::point(11.0, 30.0), &[Planar, Circular, Curved]),
        Problem::new("holes", holes.clone(), &middle(&holes), &[Planar, Curved]),
        Problem::new("slowness", slowed.clone(), &middle(&slowed), &[Planar, Curved]),
        Problem::new("origins", plane, &several, &[Curved]),
        Problem::new("fibres", FIBRES.by_metric(), &Sources::point(25.0, 30.0), &[Planar, Curved]),
        Problem::new("anchors", maze, &Sources::point(0.0, 0.0), &[Anchored, Planar]),
    ]
}

fn solved(
    solver: &mut HeadlessSolver,
    problem: &Problem,
    wavefront: Wavefront,
    stop: Stop,
) -> HeadlessSolution {
    let mut on_device = solver.upload(&problem.surface).unwrap();
    let method = Method::new(wavefront, stop).with_schedule(Schedule::Tiles);
    solver.solve(&mut on_device, &problem.seeds, method).unwrap()
}

/// Fronts are compared after one and nine rounds and after convergence, to the last bit where the device rounds as the
/// twins do.
#[test]
fn every_form_leads_to_the_same_fronts() {
    let problems = problems();
    for (lanes, tile, edges, inner) in FORMS {
        let mut pairs = solver(TileLanes::Pairs, tile, edges, inner);
        let mut points = solver(lanes, tile, edges, inner);
        let is_exact = is_processor(&pairs);
        // One form of each shader module solves all problems, the other forms solve two, since drivers take a second or
        // more for each pipeline.
        let is_first = matches!((lanes, tile), (TileLanes::Shuffled, 8) | (TileLanes::Points, 24));
        let count = if is_first { problems.len() } else { 2 };
        for problem in &problems[..count] {
            for &wavefront in problem.wavefronts {
                for stop in [Stop::after(1), Stop::after(9), CONVERGED] {
                    let wanted = solved(&mut pairs, problem, wavefront, stop);
                    let found = solved(&mut points, problem, wavefront, stop);
                    let what =
                        format!("{}, {lanes:?} of {tile}, {wavefront}, {stop:?}", problem.what);
                    let difference = difference(&wanted.distances, &found.distances);
                    if is_exact {
                        assert!(wanted.distances == found.distances, "{what}: {difference:e}");
                        assert_eq!(wanted.iterations, found.iterations, "{what}");
                    } else if stop == CONVERGED {
                        assert!(difference < 1e-5, "{what}: {difference:e}");
                    }
                }
            }
        }
        assert_nothing_said(&pairs);
        assert_nothing_said(&points);
    }
}

/// A solver has tiles of two sizes. On each grid, its rounds are those of a solver that only has tiles of the size used
/// there.
#[test]
fn small_grids_have_small_tiles() {
    let of = |tile, tile_edges| solver(TileLanes::Pairs, tile, tile_edges, 1);
    let (mut small, mut large) = (of(16, true), of(24, false));
    let by_size = of(24, false);
    let tuning = Tuning { small_grid: 64, ..by_size.tuning() };
    let mut by_size = by_size.with_tuning(tuning).unwrap();
    let wavefronts = &[Wavefront::Planar, Wavefront::Curved];
    for (rows, cols, is_small) in [(64, 51, true), (40, 65, false), (33, 64, true)] {
        let surface = rough(rows, cols, 6);
        let sources = middle(&surface);
        let problem = Problem::new("holes", surface, &sources, wavefronts);
        let alike = if is_small { &mut small } else { &mut large };
        for &wavefront in wavefronts {
            for stop in [Stop::after(3), CONVERGED] {
                let wanted = solved(alike, &problem, wavefront, stop);
                let found = solved(&mut by_size, &problem, wavefront, stop);
                assert_eq!(wanted.iterations, found.iterations, "{rows} x {cols}, {wavefront}");
                assert!(wanted.distances == found.distances, "{rows} x {cols}, {wavefront}");
            }
        }
    }
    [small, large, by_size].iter().for_each(assert_nothing_said);
}

/// Some rounds are in a second recording, which is shorter than the first, and some come after convergence.
#[test]
fn every_round_of_a_form_is_one_of_its_twin() {
    let mut solver = gpu_like_solver();
    let maze = Builtin::Maze.surface(67, 60).unwrap();
    assert_schedule_twins(&mut solver, &maze, (0, 0), Schedule::Tiles, [1, 2, 9, 17, 19, 200]);
    let holes = rough(64, 51, 6);
    let source = some_point(&holes);
    // Later rounds depend on which of two fronts is due first, and this depends on rounding.
    assert_schedule_twins(&mut solver, &holes, source, Schedule::Tiles, [1, 2, 9]);
}
