//! Many maps at once on a Vulkan device, compared with the CPU engine and with the shaders' twin, under the
//! validation layers.

use geosweep::Stop;
use geosweep::cpu::twins;
use geosweep::glam::DVec3;
use geosweep::pairwise::Pairwise;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, Seed};
use geosweep::vulkan::{
    HeadlessSolver, PairwiseOnDevice, PairwiseSchedule, SurfaceOnDevice, VulkanError,
};
use geosweep::{Engine, Error, MetricTensor, Options, Spacing, Surface, Wavefront};

use crate::common::closed::grid;
use crate::common::*;

/// Largest difference between engines. Both stop when nothing falls by more than 1e-6 in an iteration, and
/// measure edges in different precision. The bound is ten times that tolerance.
const AGREEMENT: f64 = 1e-5;
/// Largest difference after the same number of iterations: only rounding remains; see headless.rs.
const TWINS: f64 = 2e-6;

/// Returns about `count` sources over the whole grid, in the order of the points; `None` for holes.
fn sources(surface: &Surface, count: usize) -> Vec<Option<usize>> {
    let points = surface.chart().points();
    let source = |point: usize| surface.present()[point].then_some(point);
    (0..points).step_by(points.div_ceil(count)).map(source).collect()
}

/// Computes the rows of some sources. Asserts that they have converged or used all iterations.
pub fn solve(
    pairwise: &mut PairwiseOnDevice,
    (solver, uploaded, points): (&HeadlessSolver, &SurfaceOnDevice, usize),
    sources: &[Option<usize>],
    stop: Stop,
) -> Vec<f32> {
    let mut rows = vec![f32::NAN; sources.len() * points];
    let convergence = pairwise.solve(solver, uploaded, sources, stop, &mut rows).unwrap();
    assert!(convergence.iterations <= stop.iterations);
    let converged = convergence.residual <= stop.tolerance;
    assert!(converged || convergence.iterations == stop.iterations, "{convergence:?}");
    rows
}

/// Returns the rows of the sources that are not `None`, as the CPU computes them.
fn rows_on_cpu(surface: &Surface, wavefront: Wavefront, sources: &[Option<usize>]) -> Vec<f32> {
    let options = Options::default()
        .with_engine(Engine::Cpu)
        .with_wavefront(wavefront)
        .with_tolerance(CONVERGED.tolerance)
        .with_iterations(CONVERGED.iterations);
    let sources: Vec<_> = sources.iter().flatten().copied().collect();
    let (mut pairwise, mut all) = (Pairwise::new(surface, &options).unwrap(), Vec::new());
    let report = pairwise.rows(&sources, |rows| {
        all.extend_from_slice(rows.distances);
        Ok::<_, Error>(())
    });
    report.unwrap();
    all
}

/// Compares a device's rows with those of the CPU, map by map. A row without a source has no distances.
pub fn assert_rows_agree(
    surface: &Surface,
    wavefront: Wavefront,
    sources: &[Option<usize>],
    rows: &[f32],
    what: &str,
) {
    let points = surface.chart().points();
    let on_cpu = rows_on_cpu(surface, wavefront, sources);
    let mut on_cpu = on_cpu.chunks_exact(points);
    assert_eq!(rows.len(), sources.len() * points);
    for (map, (source, row)) in sources.iter().zip(rows.chunks_exact(points)).enumerate() {
        if source.is_none() {
            assert!(row.iter().all(|distance| *distance == f32::INFINITY), "{what}, map {map}");
            continue;
        }
        let difference = difference(on_cpu.next().unwrap(), row);
        assert!(difference < AGREEMENT, "{what}, map {map}: {difference}");
    }
}

/// Compares engines for every wavefront, with one of the two schedules in turn. The tests with twins compare the
/// schedules with each other.
fn assert_engines_agree(solver: &HeadlessSolver, surface: &Surface, number: usize, what: &str) {
    let points = surface.chart().points();
    let sources = sources(surface, 5);
    let uploaded = solver.upload(surface).unwrap();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let schedule = PairwiseSchedule::ALL[(number + wavefront as usize) % 2];
        let mut pairwise = solver.pairwise(&uploaded, wavefront, Some(schedule)).unwrap();
        let rows = solve(&mut pairwise, (solver, &uploaded, points), &sources, CONVERGED);
        let what = format!("{what}, {wavefront}, {schedule}");
        assert_rows_agree(surface, wavefront, &sources, &rows, &what);
    }
}

/// The last two grids have obtuse triangles, and lines of texels that are longer than a workgroup.
#[test]
fn engines_agree() {
    let solver = vulkan_solver();
    let built_in =
        Builtin::ALL.map(|builtin| (builtin.name().to_owned(), builtin.surface(23, 20).unwrap()));
    let sizes = [(1, 1), (1, 2), (2, 1), (2, 2), (3, 5), (2, 37), (41, 2), (65, 47), (1, 300)];
    let narrow = sizes.map(|(rows, cols)| (format!("{rows} x {cols}"), rough(rows, cols, 0)));
    let holes = [2, 3, 5].map(|few| (format!("one hole in {few}"), rough(21, 34, few)));
    let metric = |index: usize| {
        let (row, col) = ((index / 25) as f64 / 20.0, (index % 25) as f64 / 25.0);
        MetricTensor { rr: 1.0 + row, rc: 0.4 * (3.0 * col).sin(), cc: 2.0 - col }
    };
    let metric = Surface::from_metric(20, 25, (0..20 * 25).map(metric).collect()).unwrap();
    let slowness = (0..22 * 25).map(|i| 1.0 + (i % 3) as f64).collect();
    let steep = steep(22, 25).with_slowness(slowness).unwrap();
    let others = [("slowness", slowed(20, 25, 10)), ("metric", metric), ("slow hills", steep)]
        .map(|(what, surface)| (what.to_owned(), surface));
    let sheared = [(9, 280), (270, 8)]
        .map(|(rows, cols)| (format!("sheared, {rows} x {cols}"), sheared(rows, cols)));
    let surfaces = built_in.into_iter().chain(narrow).chain(holes).chain(others).chain(sheared);
    for (number, (what, surface)) in surfaces.enumerate() {
        assert_engines_agree(&solver, &surface, number, &what);
    }
}

/// Returns a plane whose triangles are obtuse.
fn sheared(rows: usize, cols: usize) -> Surface {
    let surface =
        grid(rows, cols, |row, col| DVec3::new(col as f64 + 1.5 * row as f64, row as f64, 0.0));
    assert!(EdgeLengths::<f32>::new(&surface).unwrap().has_obtuse_triangles());
    surface
}

/// Each map equals the twin's, after some iterations and after convergence.
#[test]
fn every_iteration_of_the_shaders_is_one_of_their_twin() {
    let solver = vulkan_solver();
    let surfaces = [
        (Builtin::Maze.surface(21, 30).unwrap(), "maze"),
        (rough(34, 23, 4), "holes"),
        (Builtin::ShearedPlane { degrees: 65.0 }.surface(19, 26).unwrap(), "all obtuse"),
        (steep(37, 21), "some obtuse"),
    ];
    for (surface, what) in surfaces {
        let sources: Vec<_> = sources(&surface, 7).into_iter().flatten().collect();
        for schedule in PairwiseSchedule::ALL {
            assert_twins(&solver, &surface, &sources, schedule, what);
        }
    }
}

/// Compares maps in images or in shared memory with the twin, after some iterations and after convergence.
pub fn assert_twins(
    solver: &HeadlessSolver,
    surface: &Surface,
    sources: &[usize],
    schedule: PairwiseSchedule,
    what: &str,
) {
    let (chart, edges) = (surface.chart(), EdgeLengths::<f32>::new(surface).unwrap());
    let of_device: Vec<_> = sources.iter().copied().map(Some).collect();
    let uploaded = solver.upload(surface).unwrap();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let mut pairwise = solver.pairwise(&uploaded, wavefront, Some(schedule)).unwrap();
        for stop in [Stop::after(1), Stop::after(2), Stop::after(5), CONVERGED] {
            let device = (solver, &uploaded, chart.points());
            let rows = solve(&mut pairwise, device, &of_device, stop);
            for (source, row) in sources.iter().zip(rows.chunks_exact(chart.points())) {
                let (r, c) = chart.position(*source);
                let seeds = [Seed::at_source(r, c, 0.0)];
                let twin = twins::scan_outward(&edges, &seeds, wavefront, stop).distances();
                let difference = difference(&twin, row);
                let what = format!("{what}, {wavefront}, {schedule}, {source}, {stop:?}");
                assert!(difference < TWINS, "{what}: {difference}");
            }
        }
    }
}

/// Returns hills with some obtuse triangles and a few holes.
fn steep(rows: usize, cols: usize) -> Surface {
    let height = |index: usize| {
        let (row, col) = ((index / cols) as f64, (index % cols) as f64);
        let is_hole = index % 97 == 31;
        if is_hole { f64::NAN } else { 14.0 * (0.31 * row).sin() * (0.23 * col + 0.1 * row).cos() }
    };
    let heights = (0..rows * cols).map(height).collect();
    let surface = Surface::from_heights(rows, cols, heights, Spacing::square(1.0)).unwrap();
    assert!(EdgeLengths::<f32>::new(&surface).unwrap().has_obtuse_triangles());
    surface
}

/// Rows do not depend on the sources beside them, nor on their batch, and are the same when computed again.
/// Rows of holes and of missing sources are infinite.
#[test]
fn rows_do_not_depend_on_their_batch() {
    let solver = vulkan_solver();
    let surface = rough(15, 13, 7);
    let points = surface.chart().points();
    let uploaded = solver.upload(&surface).unwrap();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        for schedule in PairwiseSchedule::ALL {
            let mut pairwise = solver.pairwise(&uploaded, wavefront, Some(schedule)).unwrap();
            let mut solve = |sources: &[Option<usize>]| {
                solve(&mut pairwise, (&solver, &uploaded, points), sources, CONVERGED)
            };
            let all: Vec<_> =
                (0..points).map(|point| surface.present()[point].then_some(point)).collect();
            let matrix = solve(&all);
            assert!(solve(&all) == matrix, "{wavefront}, {schedule}");
            let some = [Some(100), None, Some(3), all[52], Some(3), Some(194)];
            for (source, row) in some.into_iter().zip(solve(&some).chunks_exact(points)) {
                match source {
                    Some(source) => {
                        assert!(row == &matrix[source * points..][..points], "{source}");
                        assert_eq!(row[source], 0.0);
                    }
                    None => assert!(row.iter().all(|&distance| distance == f32::INFINITY)),
                }
            }
            assert!(solve(&[None; 3]).iter().all(|&distance| distance == f32::INFINITY));
            assert!(solve(&[]).is_empty());
        }
    }
}

/// There are more sources than a batch takes. Batches are as large as the device's memory type allows.
#[test]
fn sources_beyond_a_batch_are_computed_in_the_next() {
    let solver = vulkan_solver();
    let surface = rough(52, 60, 0);
    let points = surface.chart().points();
    let uploaded = solver.upload(&surface).unwrap();
    for schedule in PairwiseSchedule::ALL {
        let mut pairwise = solver.pairwise(&uploaded, Wavefront::Planar, Some(schedule)).unwrap();
        let count = pairwise.batch() + 5;
        assert!(count < points, "the grid has room for this number of sources");
        let sources: Vec<_> = (0..count).map(Some).collect();
        let mut rows = vec![f32::NAN; count * points];
        pairwise.solve(&solver, &uploaded, &sources, Stop::after(2), &mut rows).unwrap();
        let mut last = vec![f32::NAN; 7 * points];
        pairwise
            .solve(&solver, &uploaded, &sources[count - 7..], Stop::after(2), &mut last)
            .unwrap();
        assert!(rows[(count - 7) * points..] == last);
        assert!(pairwise.bytes() < 64 << 20, "{}", pairwise.bytes());
    }
}

/// Returns corridors that lead to and fro, one above the other. A front needs about one iteration for each corridor.
fn corridors(rows: usize, cols: usize) -> Surface {
    let is_open = |index: usize| {
        let (row, col) = (index / cols, index % cols);
        row % 2 == 0 || col == if row % 4 == 1 { cols - 1 } else { 0 }
    };
    let mask: Vec<_> = (0..rows * cols).map(is_open).collect();
    rough(rows, cols, 0).with_mask(&mask).unwrap()
}

/// If a map takes more iterations than one dispatch makes, it continues in the next dispatch.
#[test]
fn mazes_take_as_many_dispatches_as_they_need() {
    let solver = vulkan_solver();
    let surface = corridors(141, 12);
    let (points, edges) = (surface.chart().points(), EdgeLengths::<f32>::new(&surface).unwrap());
    let uploaded = solver.upload(&surface).unwrap();
    // The way is long from the first point, and half as long from a point in the middle.
    let sources = [Some(0), Some(70 * 12)];
    for wavefront in [Wavefront::Planar, Wavefront::Curved] {
        let twins = sources.iter().flatten().map(|&source| {
            let (row, col) = surface.chart().position(source);
            twins::scan_outward(&edges, &[Seed::at_source(row, col, 0.0)], wavefront, CONVERGED)
        });
        let twins: Vec<_> = twins.collect();
        assert!(twins[0].iterations > 32, "{}: a dispatch has as many", twins[0].iterations);
        for schedule in PairwiseSchedule::ALL {
            let mut pairwise = solver.pairwise(&uploaded, wavefront, Some(schedule)).unwrap();
            let mut rows = vec![f32::NAN; 2 * points];
            let convergence =
                pairwise.solve(&solver, &uploaded, &sources, CONVERGED, &mut rows).unwrap();
            let most = twins.iter().map(|twin| twin.iterations).max().unwrap();
            assert_eq!(convergence.iterations, most, "{wavefront}, {schedule}");
            for (twin, row) in twins.iter().zip(rows.chunks_exact(points)) {
                let difference = difference(&twin.distances(), row);
                assert!(difference < TWINS, "{wavefront}, {schedule}: {difference}");
            }
        }
    }
}

#[test]
fn grids_too_large_for_shared_memory_go_into_images() {
    let solver = vulkan_solver();
    let small = solver.upload(&rough(64, 64, 0)).unwrap();
    for wavefront in [Wavefront::Planar, Wavefront::Circular] {
        let pairwise = solver.pairwise(&small, wavefront, None).unwrap();
        assert_eq!(pairwise.schedule(), PairwiseSchedule::SharedMemory);
    }
    let surface = rough(270, 260, 0);
    let large = solver.upload(&surface).unwrap();
    let wanted = Some(PairwiseSchedule::SharedMemory);
    let error = solver.pairwise(&large, Wavefront::Planar, wanted).err().unwrap();
    assert!(matches!(error, VulkanError::NotInSharedMemory { .. }), "{error}");
    let mut pairwise = solver.pairwise(&large, Wavefront::Circular, None).unwrap();
    assert_eq!(pairwise.schedule(), PairwiseSchedule::Images);
    let sources = [Some(0), Some(35_000), None, Some(70_199)];
    let mut rows = vec![f32::NAN; 4 * 270 * 260];
    pairwise.solve(&solver, &large, &sources, CONVERGED, &mut rows).unwrap();
    assert_rows_agree(&surface, Wavefront::Circular, &sources, &rows, "270x260");
}
