//! The Vulkan engine compared with the CPU engine, under the validation layers.

use geosweep::Stop;
use geosweep::cpu::Solution;
use geosweep::cpu::twins::{self, Rounds};
use geosweep::glam::DVec3;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, Gluing, Seed};
use geosweep::vulkan::plan::Step;
use geosweep::vulkan::{
    HeadlessSolver, Method, Schedule, TexelChart, Tuning, VulkanError, devices,
};
use geosweep::{
    DeviceChoice, Engine, MetricTensor, Options, Sources, Surface, UsedEngine, Wavefront,
    distance_map,
};

use crate::common::*;
use crate::tile_lanes::FIBRES;

/// Largest difference between engines. Both stop when nothing falls by more than 1e-6 in an iteration, and
/// measure edges in different precision. The bound is ten times that tolerance.
const AGREEMENT: f64 = 1e-5;
/// Largest difference after the same number of iterations. Only rounding remains: a few units of the last
/// digit for each point that a front passes, with both signs.
const TWINS: f64 = 2e-6;
/// `FEW_TILES` in `glsl/shared/constants.glsl`.
pub const FEW_TILES: usize = 64;

const WAVEFRONTS: [Wavefront; 3] = Wavefront::FOR_ANY_SURFACE;

/// Returns whether a device computes on the processor's cores, with the arithmetic of the twins.
pub fn is_processor(solver: &HeadlessSolver) -> bool {
    devices().unwrap().iter().any(|info| info.name == solver.device_name() && info.kind == "CPU")
}

/// A surface and its sources, on which all engines and schedules must find the same map.
struct Case {
    what: String,
    surface: Surface,
    sources: Sources,
}

impl Case {
    fn new(what: impl Into<String>, surface: Surface, sources: Sources) -> Self {
        Self { what: what.into(), surface, sources }
    }

    /// Returns a case with a source in the middle.
    fn from_middle(what: impl Into<String>, surface: Surface) -> Self {
        let sources = middle(&surface);
        Self::new(what, surface, sources)
    }
}

/// Returns odd and tiny grids, with sources at their corners.
fn narrow_grids() -> impl Iterator<Item = Case> {
    let sizes =
        [(1, 1), (1, 2), (1, 17), (23, 1), (2, 2), (2, 3), (3, 5), (4, 4), (17, 1000), (1000, 17)];
    sizes.into_iter().flat_map(|(rows, cols)| {
        let corners = [(0, 0), (rows - 1, cols - 1), (0, cols - 1), (rows / 2, cols / 2)];
        corners.map(|(row, col)| {
            let what = format!("{rows}x{cols} from {row},{col}");
            Case::new(what, rough(rows, cols, 0), Sources::point(row as f64, col as f64))
        })
    })
}

/// Returns a sheared metric with holes that is as rough as noise, so that some lengths do not form triangles.
fn noisy_metric() -> Case {
    let noise = |i: u64| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64 / (1u64 << 24) as f64;
    let tensor = |i: u64| {
        let square = (0.5 + 1.5 * noise(i)).powi(2);
        let hole = if i % 97 == 5 { f64::NAN } else { 1.0 };
        MetricTensor { rr: hole * square, rc: 0.25 * square, cc: 1.5 * square }
    };
    let metric = Surface::from_metric(50, 40, (1..=50 * 40).map(tensor).collect());
    Case::from_middle("rough metric", metric.unwrap())
}

/// Returns several sources, a curve, a source at every point, and positions far from the origin that keep their digits.
fn many_sources_and_far_points() -> [Case; 4] {
    let surface = rough(90, 75, 0);
    let several = Sources::point(10.25, 20.5).and_point(80.0, 3.0, 4.5).and_point(10.5, 20.0, 1.0);
    let every = (0..90 * 75).fold(Sources::default(), |sources, i| {
        sources.and_point(f64::from(i / 75), f64::from(i % 75), 0.0)
    });
    let near = Builtin::Peaks.surface(80, 80).unwrap();
    let far = |i: usize| near.position(i / 80, i % 80).unwrap() + DVec3::splat(4e6);
    let far = Surface::from_positions(80, 80, (0..80 * 80).map(far).collect()).unwrap();
    [
        Case::new("several sources", surface.clone(), several),
        Case::new(
            "a curve",
            surface.clone(),
            Sources::curve([[5.0, 5.0], [70.5, 30.25], [40.0, 70.0]]),
        ),
        Case::new("every point", surface, every),
        Case::from_middle("far from the origin", far),
    ]
}

/// Maps are found by raster scans and by tiles in turn, half of them by a device like a GPU.
#[test]
fn engines_agree() {
    let built_in = Builtin::ALL
        .map(|builtin| Case::from_middle(builtin.name(), builtin.surface(129, 117).unwrap()));
    let holes =
        [2, 3, 20].map(|few| Case::from_middle(format!("one hole in {few}"), rough(61, 84, few)));
    let cases = (built_in.into_iter().chain(narrow_grids()).chain(holes))
        .chain([noisy_metric()])
        .chain(many_sources_and_far_points());
    let mut solvers = [vulkan_solver(), gpu_like_solver()];
    for (number, Case { what, surface, sources }) in cases.enumerate() {
        let solver = &mut solvers[number % 2];
        let seeds = sources.seeds(&surface).unwrap();
        let mut on_device = solver.upload(&surface).unwrap();
        for wavefront in WAVEFRONTS {
            let schedule =
                [Schedule::Tiles, Schedule::Raster][(number / 2 + wavefront as usize) % 2];
            let method = Method::new(wavefront, CONVERGED).with_schedule(schedule);
            let cpu = on_cpu(&surface, &seeds, wavefront, CONVERGED);
            let found = solver.solve(&mut on_device, &seeds, method).unwrap();
            let difference = difference(&cpu, &found.distances);
            assert!(difference < AGREEMENT, "{what}, {wavefront}, {schedule}: {difference}");
        }
    }
}

/// Every schedule leads to the same map, and repeats it to the bit.
#[test]
fn schedules_agree() {
    for (number, (surface, what)) in [
        (Builtin::Sphere.surface(65, 80).unwrap(), "sphere"),
        (Builtin::Maze.surface(61, 67).unwrap(), "maze"),
        (rough(50, 37, 5), "holes"),
        (slowed(60, 70, 30), "slowness"),
        (rough(3, 41, 0), "a strip"),
        (rough(1, 1, 0), "a point"),
    ]
    .into_iter()
    .enumerate()
    {
        let mut solver = if number % 2 == 0 { gpu_like_solver() } else { vulkan_solver() };
        let seeds = middle(&surface).seeds(&surface).unwrap();
        let mut on_device = solver.upload(&surface).unwrap();
        for wavefront in WAVEFRONTS {
            let cpu = on_cpu(&surface, &seeds, wavefront, CONVERGED);
            for schedule in Schedule::ALL {
                let method = Method::new(wavefront, CONVERGED).with_schedule(schedule);
                let solution = solver.solve(&mut on_device, &seeds, method).unwrap();
                let difference = difference(&cpu, &solution.distances);
                let what = format!("{what}, {wavefront}, {schedule}");
                assert!(difference < AGREEMENT, "{what}: {difference}");
                assert!(solution.residual <= CONVERGED.tolerance, "{what}");
                let again = solver.solve(&mut on_device, &seeds, method).unwrap();
                assert_eq!(again.distances, solution.distances, "{what}");
            }
        }
    }
}

/// Sources that are added to a map lead to the map of all sources.
#[test]
fn sources_can_be_added_to_a_map() {
    let mut solver = vulkan_solver();
    let surface = rough(61, 84, 6);
    let [first, second] = [seeds_at(&surface, some_point(&surface)), {
        let index = surface.present().iter().position(|&present| present).unwrap();
        seeds_at(&surface, surface.chart().position(index))
    }];
    let all = [first.clone(), second.clone()].concat();
    let mut on_device = solver.upload(&surface).unwrap();
    for wavefront in WAVEFRONTS {
        let cpu = on_cpu(&surface, &all, wavefront, CONVERGED);
        for schedule in Schedule::ALL {
            let method = Method::new(wavefront, CONVERGED).with_schedule(schedule);
            let one = solver.solve(&mut on_device, &first, method).unwrap();
            let both = solver.add(&mut on_device, &second, method).unwrap();
            assert_ne!(one.distances, both.distances);
            let difference = difference(&cpu, &both.distances);
            assert!(difference < AGREEMENT, "{wavefront}, {schedule}: {difference}");
        }
    }
}

/// A surface takes at most 48 bytes per point, including the buffers for transfer. GPUs pad images, small
/// images the most, so the bound is 80 bytes on GPUs.
#[test]
fn a_surface_takes_little_memory() {
    let solver = vulkan_solver();
    let most = if is_processor(&solver) { 48 } else { 80 };
    for (rows, cols) in [(300, 300), (257, 1000), (1000, 1000), (900, 2000)] {
        let bytes = solver.upload(&rough(rows, cols, 0)).unwrap().bytes();
        let points = (rows * cols) as u64;
        assert!(bytes < most * points, "{rows} x {cols}: {bytes}, {} a point", bytes / points);
    }
}

/// Returns the map of a schedule's twin, point by point.
fn twin(
    edges: &EdgeLengths<f32>,
    seeds: &[Seed],
    wavefront: Wavefront,
    schedule: Schedule,
    (tuning, on_processor): (Tuning, bool),
    stop: Stop,
) -> Solution<f32> {
    match schedule {
        Schedule::Raster if tuning.scan_pairs => {
            let lines = tuning.scan_lines as usize;
            twins::scan_in_pairs(edges, seeds, wavefront, stop, lines)
        }
        Schedule::Raster => twins::scan_in_turn(edges, seeds, wavefront, stop),
        Schedule::Tiles => {
            let texels = TexelChart::new(edges.chart()).unwrap();
            let portions = tuning.portions(wavefront, texels);
            let recording = schedule.plan(texels, portions, None, u32::MAX);
            let recorded = recording.iter().filter(|step| matches!(step, Step::Tiles { .. }));
            let rounds = Rounds {
                tile: portions.tile as usize,
                inner: tuning.inner,
                recorded: recorded.count() as u32,
                few: Some(if on_processor { 0 } else { FEW_TILES }),
            };
            twins::tile_rounds(edges, seeds, wavefront, stop, rounds)
        }
    }
}

pub fn assert_schedule_twins(
    solver: &mut HeadlessSolver,
    surface: &Surface,
    source: (usize, usize),
    schedule: Schedule,
    iterations: impl IntoIterator<Item = u32>,
) {
    let seeds = seeds_at(surface, source);
    let edges = EdgeLengths::<f32>::new(surface).unwrap();
    let mut on_device = solver.upload(surface).unwrap();
    // Before a map converges, the last digit may decide which of two curved fronts a point keeps. With fused
    // products and inexact roots, maps differ by 5.8e-4 for an iteration or two on lavapipe, and by 1.8e-3 on
    // a GPU.
    let on_processor = is_processor(solver);
    let of_others = if on_processor { TWINS } else { 5e-3 };
    for iterations in iterations {
        let stop = Stop::after(iterations);
        for wavefront in WAVEFRONTS {
            let twin =
                twin(&edges, &seeds, wavefront, schedule, (solver.tuning(), on_processor), stop);
            let method = Method::new(wavefront, stop).with_schedule(schedule);
            let vulkan = solver.solve(&mut on_device, &seeds, method).unwrap();
            let difference = difference(&twin.distances(), &vulkan.distances);
            let what = format!("{iterations} iterations, {schedule}, {wavefront}");
            let most = if wavefront == Wavefront::Planar { TWINS } else { of_others };
            assert!(difference < most, "{what}: {difference}");
            // A device's rounding decides whether one more round changes a last digit: GPUs fuse products.
            let apart = twin.iterations.abs_diff(vulkan.iterations);
            assert!(apart <= 1, "{what}: {} and {}", twin.iterations, vulkan.iterations);
        }
    }
}

#[test]
fn every_iteration_of_the_shader_is_one_of_its_twin() {
    let mut solver = vulkan_solver();
    let (maze, holes) = (Builtin::Maze.surface(101, 120).unwrap(), rough(64, 81, 4));
    for (surface, source) in [
        (&maze, (0, 0)),
        (&rough(75, 62, 0), (50, 13)),
        (&holes, some_point(&holes)),
        (&FIBRES.by_positions(), (25, 30)),
    ] {
        assert_schedule_twins(&mut solver, surface, source, Schedule::Raster, 1..=3);
    }
}

/// Some rounds are in a second recording, and some come after convergence.
#[test]
fn every_round_is_one_of_its_twin() {
    let mut solver = vulkan_solver();
    for (surface, source) in [
        (Builtin::Maze.surface(67, 60).unwrap(), (0, 0)),
        (slowed(40, 53, 30), (20, 27)),
        (rough(49, 38, 0), (31, 13)),
        (rough(1, 40, 0), (0, 39)),
        (FIBRES.by_metric(), (25, 30)),
    ] {
        let solver = &mut solver;
        let source = if surface.has(source.0, source.1) { source } else { some_point(&surface) };
        assert_schedule_twins(solver, &surface, source, Schedule::Tiles, [1, 2, 3, 9, 200]);
    }
}

/// The grid has more rows than one band of the upload, and bends across the bands' border.
#[test]
fn every_band_of_the_upload_arrives() {
    let mut solver = vulkan_solver();
    let sphere = Builtin::Sphere.surface(1100, 1000).unwrap();
    assert_schedule_twins(&mut solver, &sphere, (300, 700), Schedule::Raster, [1]);
}

#[test]
fn a_map_does_not_depend_on_the_maps_before() {
    let mut solver = gpu_like_solver();
    let surface = rough(70, 50, 6);
    let mut on_device = solver.upload(&surface).unwrap();
    let seeds = seeds_at(&surface, some_point(&surface));
    let mut solve = |seeds: &[_], wavefront| {
        let method = Method::new(wavefront, CONVERGED);
        solver.solve(&mut on_device, seeds, method).unwrap()
    };
    let first = solve(&seeds, Wavefront::Circular);
    let others = Sources::point(0.5, 0.5).seeds(&rough(70, 50, 0)).unwrap();
    assert_ne!(first.distances, solve(&others, Wavefront::Planar).distances);
    let again = solve(&seeds, Wavefront::Circular);
    assert_eq!(first.distances, again.distances);
    assert_eq!((first.iterations, first.residual), (again.iterations, again.residual));
}

#[test]
fn the_one_call_says_what_it_used() {
    let surface = rough(20, 30, 0);
    let sources = Sources::point(3.0, 4.0).and_point(15.0, 20.0, -2.0);
    let map = |engine| {
        // By default, fronts of several sources carry their ray on the CPU, and their curvature on a device.
        let options = Options::default().with_engine(engine).with_wavefront(Wavefront::Planar);
        distance_map(&surface, &sources, &options).unwrap()
    };
    let vulkan = map(Engine::Vulkan(device_choice()));
    assert_eq!((vulkan.report.engine, &vulkan.report.reason), (UsedEngine::Vulkan, &None));
    assert!(vulkan.report.device.is_some() && vulkan.report.converged);
    assert_eq!((vulkan.report.points, vulkan.report.reached), (600, 600));
    let cpu = map(Engine::Cpu);
    assert_eq!(
        (cpu.report.engine, &cpu.report.device, &cpu.report.reason),
        (UsedEngine::Cpu, &None, &None)
    );
    assert!(difference(&vulkan.distances, &cpu.distances) < AGREEMENT);
    assert_eq!(vulkan.distance(15, 20), -2.0);
    // A grid of this size is too small for a GPU.
    let auto = map(Engine::Auto);
    assert_eq!((auto.report.engine, &auto.report.fallback), (UsedEngine::Cpu, &None));
    assert!(auto.report.reason.is_some_and(|why| why.contains("600 points")));
    assert_eq!(auto.distances, cpu.distances);
}

/// Where cells are all alike, fronts of several sources and over seams are those of straight lines, as on the CPU.
#[test]
fn straight_lines_give_the_maps_of_every_schedule() {
    let tensor = MetricTensor { rr: 9.0, rc: 4.0, cc: 2.5 };
    let open = || Surface::from_metric(41, 52, vec![tensor; 41 * 52]).unwrap();
    let holes: Vec<_> = (0..41 * 52).map(|k| k / 52 != 20 || k % 52 > 45).collect();
    for (surface, is_whole) in [
        (open(), true),
        (open().with_gluing(Gluing::columns()).unwrap(), true),
        (open().with_gluing(Gluing::both()).unwrap(), true),
        (open().with_mask(&holes).unwrap(), false),
    ] {
        let sources = Sources::point(5.0, 48.25)
            .and_point(5.5, 47.0, 0.5)
            .and_curve([[3.5, 10.0], [12.0, 10.5], [12.0, 17.0]], 0.0);
        let cpu = distance_map(&surface, &sources, &Options::default()).unwrap();
        assert_eq!(cpu.report.schedule == "straight-lines", is_whole);
        for schedule in [Schedule::Raster, Schedule::Tiles] {
            let options = Options::default().with_engine(Engine::Vulkan(device_choice()));
            let options = options.with_schedule(schedule);
            let map = distance_map(&surface, &sources, &options).unwrap();
            assert_eq!((map.report.engine, map.report.converged), (UsedEngine::Vulkan, true));
            // Behind holes, fronts carry their ray on the CPU and their curvature on a device.
            let most = if is_whole { 1e-6 } else { 5e-3 };
            let apart = difference(&map.distances, &cpu.distances);
            assert!(apart < most, "{schedule:?}, {is_whole}: {apart}");
        }
    }
}

#[test]
fn a_choice_that_cannot_be_met_is_an_error() {
    let surface = rough(5, 5, 0);
    for choice in [DeviceChoice::Name("no such device".into()), DeviceChoice::Index(99)] {
        let options = Options::default().with_engine(Engine::Vulkan(choice));
        let error = distance_map(&surface, &Sources::point(1.0, 1.0), &options).unwrap_err();
        assert!(error.to_string().contains("available: 0: \""), "{error}");
    }
}

#[test]
fn a_grid_larger_than_the_device_is_an_error() {
    let solver = vulkan_solver();
    let surface = rough(1, 200_000, 0);
    let Err(error) = solver.upload(&surface) else { panic!("no device has such images") };
    assert!(matches!(error, VulkanError::TooLarge { .. }), "{error}");
}
