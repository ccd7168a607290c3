//! The pairwise engine compared with the engine for single maps, and with the truth.

use geosweep::Stop;
use geosweep::accuracy::Errors;
use geosweep::cpu::twins::scan_outward;
use geosweep::cpu::{Instructions, PairwiseScan, rotated_scan};
use geosweep::pairwise::Pairwise;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, Seed};
use geosweep::{Engine, Error, MetricTensor, Options, Sources, Spacing, Surface, Wavefront};
use rayon::prelude::*;

use crate::common::bounds::{self, Case, SETTLED};
use crate::common::{CONVERGED, difference};

const STRAIGHT: [Wavefront; 2] = [Wavefront::Planar, Wavefront::Circular];

/// Returns the whole matrix.
fn matrix(solver: &PairwiseScan, surface: &Surface, stop: Stop) -> Vec<f32> {
    let points = surface.chart().points();
    let source = |point: usize| surface.present()[point].then_some(point);
    let mut matrix = vec![0.0; points * points];
    let batches = matrix.par_chunks_mut(PairwiseScan::LANES * points);
    batches.enumerate().for_each(|(batch, rows)| {
        let first = batch * PairwiseScan::LANES;
        let sources: Vec<_> = (first..first + rows.len() / points).map(source).collect();
        solver.solve(&sources, stop, rows);
    });
    matrix
}

/// Returns the rows of some sources, computed by [`Pairwise`] on the CPU.
fn rows(surface: &Surface, wavefront: Wavefront, sources: &[usize]) -> Vec<f32> {
    let options = Options::default()
        .with_engine(Engine::Cpu)
        .with_wavefront(wavefront)
        .with_tolerance(CONVERGED.tolerance)
        .with_iterations(CONVERGED.iterations);
    let (mut pairwise, mut all) = (Pairwise::new(surface, &options).unwrap(), Vec::new());
    let report = pairwise.rows(sources, |rows| {
        all.extend_from_slice(rows.distances);
        Ok::<_, Error>(())
    });
    let report = report.unwrap();
    assert!(report.wavefront == wavefront && report.converged(), "{report:?}");
    all
}

/// Returns surfaces of several kinds: sizes that leave a remainder of lanes, lines of points, holes,
/// slowness, a metric, obtuse angles.
fn surfaces() -> Vec<(&'static str, Surface)> {
    let wave = |i: usize| (i as f64 * 0.7).sin();
    let heights = |rows, cols: usize| {
        let heights = (0..rows * cols).map(|i| wave(i) + (i % cols) as f64 * 0.1).collect();
        Surface::from_heights(rows, cols, heights, Spacing { dx: 1.0, dy: 1.5 }).unwrap()
    };
    let mask: Vec<_> = (0..17 * 23).map(|i| i % 13 != 7).collect();
    let slowness: Vec<_> = (0..15 * 19).map(|i| 1.5 + wave(3 * i)).collect();
    let tensor = |i: usize| MetricTensor { rr: 2.0 + wave(i), rc: 0.3 * wave(5 * i), cc: 1.0 };
    let tensors = (0..14 * 18).map(tensor).collect();
    let builtin = |builtin: Builtin| builtin.surface(22, 20).unwrap();
    vec![
        ("row", heights(1, 40)),
        ("column", heights(40, 1)),
        ("heights", heights(17, 23)),
        ("holes", heights(17, 23).with_mask(&mask).unwrap()),
        ("slowness", heights(15, 19).with_slowness(slowness).unwrap()),
        ("metric", Surface::from_metric(14, 18, tensors).unwrap()),
        ("sheared", builtin(Builtin::ShearedPlane { degrees: 60.0 })),
        ("sphere", builtin(Builtin::Sphere)),
        ("cone", builtin(Builtin::Cone)),
        ("maze", builtin(Builtin::Maze)),
    ]
}

/// Compares the rows of points with the maps from these points.
fn compare(
    name: &str,
    surface: &Surface,
    edges: &EdgeLengths<f32>,
    wavefront: Wavefront,
    stop: Stop,
    sources: impl IntoIterator<Item = usize>,
    rows: &[f32],
) {
    let chart = surface.chart();
    for (source, row) in sources.into_iter().zip(rows.chunks_exact(chart.points())) {
        let (r, c) = chart.position(source);
        if !surface.has(r, c) {
            assert!(row.iter().all(|distance| *distance == f32::INFINITY));
            continue;
        }
        let seeds = [Seed::at_source(r, c, 0.0)];
        let apart = difference(row, &scan_outward(edges, &seeds, wavefront, stop).distances());
        assert!(apart < 1e-5, "{name} {wavefront} {source} {stop:?}: {apart:e}");
    }
}

/// The scans are the same in the same order, so that maps agree after any number of iterations, up to the
/// rounding of coefficients and squares. This rounding is a unit in the last place, 6e-8, for each of the few
/// dozen steps of the longest path.
#[test]
fn every_row_is_the_map_of_its_source() {
    for (name, surface) in surfaces() {
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        for wavefront in STRAIGHT {
            // With a slowness, rows are computed map by map.
            let Some(solver) = PairwiseScan::new(&edges, wavefront) else {
                assert_eq!(name, "slowness");
                continue;
            };
            for stop in [Stop::after(1), CONVERGED] {
                let rows = matrix(&solver, &surface, stop);
                let all = 0..surface.chart().points();
                compare(name, &surface, &edges, wavefront, stop, all, &rows);
            }
        }
    }
}

/// Steep, sheared, stretched and folded surfaces, with or without holes; most of them have obtuse triangles.
/// Rows satisfy their bounds and equal the single maps of both precisions. Planar fronts converge to one
/// result, circular ones nearly always.
#[test]
fn rows_on_any_surface_keep_their_bounds_and_are_single_maps() {
    let (mut compared, mut split, mut apart) = (0, 0, [0; 2]);
    for number in bounds::cases(150) {
        for case in [Case::new(number), Case::irregular(number)] {
            let (surface, chart) = (&case.surface, case.surface.chart());
            let edges = EdgeLengths::<f32>::new(surface).unwrap();
            let exact = EdgeLengths::<f64>::new(surface).unwrap();
            let there: Vec<_> = (0..chart.points()).filter(|&k| surface.present()[k]).collect();
            let step = there.len().div_ceil(PairwiseScan::LANES);
            let sources: Vec<_> = there.into_iter().step_by(step).map(Some).collect();
            for (at, wavefront) in STRAIGHT.into_iter().enumerate() {
                let Some(solver) = PairwiseScan::new(&edges, wavefront) else {
                    assert!(surface.slowness().is_some());
                    continue;
                };
                split += usize::from(edges.has_obtuse_triangles());
                let mut rows = vec![0.0; sources.len() * chart.points()];
                solver.solve(&sources, SETTLED, &mut rows);
                let all = sources.iter().flatten().zip(rows.chunks_exact(chart.points()));
                for (&source, row) in all.step_by(3) {
                    let (r, c) = chart.position(source);
                    let from = Sources::point(r as f64, c as f64);
                    let name = format!("{} from {source}", case.name);
                    let bounds = Case::of(name.clone(), surface.clone(), from).bounds();
                    bounds
                        .check(row)
                        .unwrap_or_else(|error| panic!("{name}, {wavefront}: {error}"));
                    let seeds = [Seed::at_source(r, c, 0.0)];
                    let single = rotated_scan(&edges, &seeds, wavefront, SETTLED).distances();
                    let double = rotated_scan(&exact, &seeds, wavefront, SETTLED).distances();
                    let off = bounds.difference(row, &single).max(bounds.difference(row, &double));
                    compared += 1;
                    if off > 2e-5 {
                        println!("{name}, {wavefront}: {off:e}");
                        apart[at] += 1;
                    }
                }
            }
        }
    }
    println!("{compared} rows, {apart:?} apart, {split} times with obtuse triangles");
    assert!(split * 2 > compared / 6, "{split} of {compared}");
    assert!(apart[0] == 0 && apart[1] * 100 <= compared, "{apart:?} of {compared}");
}

/// Curved and anchored fronts store more than their arrival time, so that their rows are computed map by map.
#[test]
fn rows_of_curved_fronts_are_the_maps_of_their_sources() {
    for (name, surface) in surfaces() {
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        assert!(PairwiseScan::new(&edges, Wavefront::Anchored).is_none());
        assert!(PairwiseScan::new(&edges, Wavefront::Curved).is_none());
        // If triangles make points depend on one another, curved fronts may converge to different results.
        if name == "slowness" {
            continue;
        }
        let sources: Vec<_> = (0..surface.chart().points()).step_by(7).collect();
        let rows = rows(&surface, Wavefront::Curved, &sources);
        compare(name, &surface, &edges, Wavefront::Curved, CONVERGED, sources, &rows);
    }
}

#[test]
fn instructions_and_threads_give_the_same_matrix_to_the_bit() {
    for (name, surface) in surfaces() {
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        if name == "slowness" {
            continue;
        }
        for wavefront in STRAIGHT {
            let with = |instructions, threads| {
                let solver = PairwiseScan::new(&edges, wavefront).unwrap();
                let solver = solver.with_instructions(instructions);
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| matrix(&solver, &surface, Stop::after(3)))
            };
            let baseline = with(Instructions::Baseline, 1);
            for instructions in Instructions::available() {
                assert!(with(instructions, 3) == baseline, "{name} {wavefront} {instructions}");
            }
        }
    }
}

/// Behind each corner of the maze, two fronts touch. Fronts that take the mean of both are wrong by 1e-3 in these
/// maps. With anchors, only rounding remains.
#[test]
fn the_maze_is_exact_with_anchors() {
    let side = 49;
    let surface = Builtin::Maze.surface(side, side).unwrap();
    let chart = surface.chart();
    let places = [(0, 0), (1, 41), (8, 8), (17, 47), (24, 24), (31, 1), (40, 45), (48, 48)];
    let sources = places.map(|(row, col)| chart.index(row, col));
    let rows = rows(&surface, Wavefront::Anchored, &sources);
    for ((r, c), row) in places.into_iter().zip(rows.chunks_exact(chart.points())) {
        let exact = Builtin::Maze.exact_distances(side, side, [r as f64, c as f64]).unwrap();
        let largest = Errors::of(row, &exact).max_relative;
        println!("from {r}, {c}: {largest:.2e}");
        assert!(largest < 4e-6, "from {r}, {c}: {largest:e}");
    }
}
