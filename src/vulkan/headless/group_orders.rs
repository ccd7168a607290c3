//! Tests that no map depends on the order in which a device runs the workgroups of a dispatch, or dispatches
//! that no barrier separates. The validation layers are off: with them, solvers would record a barrier
//! between such dispatches.

use std::f32::consts::PI;
use std::sync::Arc;

use ash::vk;
use glam::DVec3;
use gpu_allocator::MemoryLocation;

use super::context::Context;
use super::{HeadlessSolution, HeadlessSolver, testing};
use crate::surface::builtin::Builtin;
use crate::surface::{Chart, Gluing, Sources, Spacing, Surface};
use crate::vulkan::copies;
use crate::vulkan::copies::tests::GroupOrder;
use crate::vulkan::device::memory::{Buffer, BufferInfo};
use crate::vulkan::embed;
use crate::vulkan::schedules::raster;
use crate::vulkan::{Method, Schedule, TileLanes, Tuning};
use crate::{Stop, Wavefront};

/// The device's own order, the opposite order, and a random order; see `glsl/shared/groups.glsl`.
const ORDERS: [i32; 3] = [0, -1, 1];

/// Returns a solver whose workgroups take their numbers in the order `group_order`.
fn solver(group_order: i32, change: impl Fn(Tuning) -> Tuning) -> HeadlessSolver {
    let context = Context::new(&testing::device(), false).unwrap();
    let mut solver = HeadlessSolver::with(context).unwrap();
    solver.for_device.pipelines.group_order = group_order;
    let tuning = change(solver.tuning());
    solver.with_tuning(tuning).unwrap()
}

struct Problem {
    what: &'static str,
    surface: Surface,
    sources: Sources,
    wavefronts: &'static [Wavefront],
}

/// Returns problems with holes, obtuse triangles, anchors, and several fronts that meet.
fn problems() -> [Problem; 3] {
    use Wavefront::{Anchored, Curved, Planar};
    let is_hole = |i: u32| i % 83 != 40 && (i + 1).wrapping_mul(0x9e37_79b1) >> 29 == 0;
    let heights = (0..70 * 83).map(|i| match is_hole(i) {
        true => f64::NAN,
        false => 2.0 * (0.31 * f64::from(i / 83)).sin() * (0.23 * f64::from(i % 83)).cos(),
    });
    let spacing = Spacing { dx: 1.0, dy: 1.3 };
    let holes = Surface::from_heights(70, 83, heights.collect(), spacing).unwrap();
    let maze = Builtin::Maze.surface(67, 75).unwrap();
    let sheared = Builtin::ShearedPlane { degrees: 60.0 }.surface(59, 64).unwrap();
    let several = Sources::point(20.0, 11.25).and_point(44.0, 50.0, 2.0);
    [
        Problem {
            what: "holes",
            surface: holes,
            sources: Sources::point(30.0, 40.0),
            wavefronts: &[Planar, Curved],
        },
        Problem {
            what: "maze",
            surface: maze,
            sources: Sources::point(0.0, 0.0),
            wavefronts: &[Anchored],
        },
        Problem { what: "obtuse", surface: sheared, sources: several, wavefronts: &[Curved] },
    ]
}

/// Returns the maps after some iterations, and the map that has converged.
fn maps(
    solver: &mut HeadlessSolver,
    problem: &Problem,
    schedule: Schedule,
) -> Vec<HeadlessSolution> {
    let mut on_device = solver.upload(&problem.surface).unwrap();
    let seeds = problem.sources.seeds(&problem.surface).unwrap();
    let stops = [Stop::after(1), Stop::after(9), Stop::within(1e-6).or_after(10_000)];
    let all = problem.wavefronts.iter().flat_map(|&wavefront| stops.map(|stop| (wavefront, stop)));
    all.map(|(wavefront, stop)| {
        let method = Method::new(wavefront, stop).with_schedule(schedule);
        solver.solve(&mut on_device, &seeds, method).unwrap()
    })
    .collect()
}

fn assert_same(wanted: &[HeadlessSolution], found: &[HeadlessSolution], what: &str) {
    assert_eq!(wanted.len(), found.len());
    for (wanted, found) in wanted.iter().zip(found) {
        let what = format!("{what}, {}", wanted.wavefront);
        assert_eq!(wanted.iterations, found.iterations, "{what}");
        assert!(wanted.distances == found.distances, "{what}, {} iterations", wanted.iterations);
    }
}

/// A line of a block has three or more workgroups of 16 texels. Neighbouring workgroups share their outermost
/// texels.
#[test]
fn raster_scans_do_not_depend_on_the_order_of_workgroups() {
    let problems = problems();
    // Each order has pipelines of its own, whose compilation takes most of the time.
    for (scan_lines, scan_pairs, order) in [(4, false, ORDERS[1]), (1, true, ORDERS[2])] {
        let with_order =
            |order| solver(order, |old| Tuning { scan_width: 16, scan_lines, scan_pairs, ..old });
        let [mut in_order, mut other] = [ORDERS[0], order].map(with_order);
        for problem in &problems {
            let wanted = maps(&mut in_order, problem, Schedule::Raster);
            raster::tests::PAIRS_ARE_REVERSED.set(order < 0);
            let found = maps(&mut other, problem, Schedule::Raster);
            raster::tests::PAIRS_ARE_REVERSED.set(false);
            let what = format!("{}, {scan_lines} lines, {scan_pairs}, {order}", problem.what);
            assert_same(&wanted, &found, &what);
        }
    }
}

/// A workgroup that takes blocks in turn is the only one of its dispatch, so there is no order of workgroups to vary.
/// But the opposite scan of the pair may run at the same time: maps must not depend on which of the two is recorded
/// first.
#[test]
fn scans_of_a_pair_can_run_in_any_order() {
    let problems = problems();
    let mut solver =
        solver(0, |old| Tuning { scan_width: 64, scan_lines: 4, scan_pairs: true, ..old });
    for problem in &problems {
        let [in_order, reversed] = [false, true].map(|reversed| {
            raster::tests::PAIRS_ARE_REVERSED.set(reversed);
            let maps = maps(&mut solver, problem, Schedule::Raster);
            raster::tests::PAIRS_ARE_REVERSED.set(false);
            maps
        });
        assert_same(&in_order, &reversed, problem.what);
    }
}

/// The maps do not depend on the run either, nor on how recordings divide the rounds: nine rounds take three
/// recordings. On CPUs they do not depend on how invocations share a tile's points.
#[test]
fn rounds_of_tiles_do_not_depend_on_the_order_of_workgroups() {
    let problems = problems();
    let forms = [(TileLanes::Pairs, ORDERS[1]), (TileLanes::Points, ORDERS[2])];
    let forms = forms.map(|(tile_lanes, order)| {
        let with_order =
            |order| solver(order, |old| Tuning { tile_lanes, tile: 16, together: Some(4), ..old });
        let mut in_order = with_order(ORDERS[0]);
        let wanted = problems.each_ref().map(|of| maps(&mut in_order, of, Schedule::Tiles));
        let mut other = with_order(order);
        for (problem, wanted) in problems.iter().zip(&wanted) {
            for solver in [&mut in_order, &mut other] {
                let found = maps(solver, problem, Schedule::Tiles);
                assert_same(wanted, &found, &format!("{}, {tile_lanes:?}, {order}", problem.what));
            }
        }
        (wanted, in_order.for_device.limits.kind)
    });
    let [(of_pairs, kind), (of_points, _)] = &forms;
    if *kind == vk::PhysicalDeviceType::CPU {
        for ((problem, a), b) in problems.iter().zip(of_pairs).zip(of_points) {
            assert_same(a, b, &format!("{}, both forms", problem.what));
        }
    }
}

/// The copies of points in a renderer's frame can be listed in any order too: curvatures, seeds and fronts are
/// the same.
#[test]
fn copies_in_frames_can_be_listed_in_any_order() {
    let solver = solver(0, |tuning| tuning);
    let [found, reversed, scattered] =
        [GroupOrder::AsFound, GroupOrder::Reversed, GroupOrder::Scattered].map(|order| {
            copies::tests::ORDER.set(order);
            let map = frame_of_a_globe(&solver.context);
            copies::tests::ORDER.set(GroupOrder::AsFound);
            map
        });
    assert!(found.iter().all(|distance| (0.0..3.2).contains(distance)), "{found:?}");
    assert!(found == reversed && found == scattered);
}

/// An exchange has a workgroup for each map.
#[test]
fn maps_of_a_batch_exchange_their_fronts_in_any_order() {
    let [points, _] = globe();
    let points =
        points.chunks_exact(3).map(|at| DVec3::new(at[0].into(), at[1].into(), at[2].into()));
    let ball = Surface::from_positions(CHART.rows, CHART.cols, points.collect()).unwrap();
    let ball = ball.with_gluing(Gluing::globe()).unwrap();
    let sources = [Some(7), Some(300), None, Some(500), Some(CHART.points() - 1)];
    let list_orders = [GroupOrder::AsFound, GroupOrder::Reversed, GroupOrder::Scattered];
    let [found, reversed, scattered] = [0, 1, 2].map(|k| {
        let solver = solver(ORDERS[k], |old| Tuning { scan_width: 16, ..old });
        copies::tests::ORDER.set(list_orders[k]);
        let on_device = solver.upload(&ball).unwrap();
        copies::tests::ORDER.set(GroupOrder::AsFound);
        let mut pairwise = solver.pairwise(&on_device, Wavefront::Curved, None).unwrap();
        let mut rows = vec![0.0; sources.len() * CHART.points()];
        let stop = Stop::within(1e-6).or_after(1000);
        pairwise.solve(&solver, &on_device, &sources, stop, &mut rows).unwrap();
        rows
    });
    assert!(found[..CHART.points()].iter().all(|distance| (0.0..3.2).contains(distance)));
    assert!(found == reversed && found == scattered);
}

/// Grid of a globe by latitudes and longitudes.
const CHART: Chart = Chart { rows: 31, cols: 61 };

/// Returns the positions of the globe's points, and their rows and columns.
fn globe() -> [Vec<f32>; 2] {
    let (mut points, mut places) = (Vec::new(), Vec::new());
    for (row, col) in CHART.places() {
        let (polar, angle) = (PI * row as f32 / 30.0, 2.0 * PI * (col % 60) as f32 / 60.0);
        points.extend([polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos()]);
        places.extend([row as f32, col as f32]);
    }
    [points, places]
}

/// Returns the map of the globe from a frame.
fn frame_of_a_globe(context: &Arc<Context>) -> Vec<f32> {
    let [points, places] = globe();
    let Context { device, physical_device, .. } = &**context;
    let filled = |name, floats: Vec<f32>, location| {
        let info = BufferInfo { name, size: 4 * floats.len() as u64, location };
        let mut buffer = Buffer::new(device, &mut *context.allocator(), info).unwrap();
        if location == MemoryLocation::CpuToGpu {
            let bytes: &[u8] = bytemuck::cast_slice(&floats);
            buffer.mapped()[..bytes.len()].copy_from_slice(bytes);
        }
        buffer
    };
    let mut buffers = [
        filled("points", points, MemoryLocation::CpuToGpu),
        filled("places", places, MemoryLocation::CpuToGpu),
        filled("distances", vec![0.0; CHART.points()], MemoryLocation::GpuToCpu),
    ];
    let passes = [(Schedule::Raster, Wavefront::Curved)];
    let instance = &context.instance.handle;
    let mut solver = embed::Solver::new(instance, *physical_device, device, &passes).unwrap();
    let inputs = [embed::Points::positions(buffers[0].buffer, 12)];
    let [_, places, distances] = buffers.each_ref().map(|buffer| buffer.buffer);
    let count = CHART.points() as u32;
    let lookups =
        [embed::Lookup { places, places_offset: 0, distances, distances_offset: 0, count }];
    let gluing = Gluing::globe();
    let info = embed::SurfaceInfo::new(CHART)
        .with_points(&inputs)
        .with_lookups(&lookups)
        .with_gluing(&gluing);
    let mut surface = solver.surface(device, &mut *context.allocator(), &info).unwrap();
    let method = Method::new(Wavefront::Curved, Stop::within(1e-6).or_after(100));
    let plan = solver.plan(CHART, method, 20).unwrap().over_seams();
    let sources = [embed::PointSource::at(8.0, 60.0)];
    let record = |device: &ash::Device, commands| {
        let recording = solver.record(device, commands, &surface);
        recording.prepare();
        let sources = embed::SourceInput::Inline(&sources);
        let frame = embed::Frame::new(&plan, sources, embed::Reader::COPY).with_points(0);
        recording.frame(&frame).unwrap();
        recording.lookup(0, -1.0, embed::Access::NONE, embed::Access::HOST_READ).unwrap();
    };
    context.run(record).unwrap();
    assert!(surface.outcome(0).unwrap().converged);
    let map = bytemuck::cast_slice(&buffers[2].read()[..4 * CHART.points()]).to_vec();
    surface.destroy(device, &mut *context.allocator());
    solver.destroy(device);
    buffers.iter_mut().for_each(|buffer| buffer.destroy(device, &mut *context.allocator()));
    map
}
