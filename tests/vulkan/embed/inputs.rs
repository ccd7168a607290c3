//! Inputs of a host in every form, compared with the headless solver on the same surface.

use geosweep::Stop;
use geosweep::ash::vk;
use geosweep::glam::DVec3;
use geosweep::surface::{Chart, EdgeRule};
use geosweep::vulkan::embed::{
    Access, Frame, Lookup, Outcome, PackedTimes, PointKind, PointMemory, PointSource, Points,
    Reader, SourceBuffer, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{HeadlessSolver, Method, Schedule};
use geosweep::{MetricTensor, Sources, Spacing, Surface, Wavefront};

use crate::common::{difference, vulkan_solver};
use crate::embed::stage::{Kept, RASTER, STOP, Stage, numbers_of, source, vertices};
use crate::host::Host;

const CHART: Chart = Chart { rows: 31, cols: 45 };
/// Largest difference between maps from the same points: rounding, since shaders measure the same edges as
/// their twin.
const SAME: f64 = 1e-5;

/// Returns the surface of some vertices, with holes where a coordinate is not a usable number.
fn positions(vertices: &[f32]) -> Surface {
    let usable = |x: f32| if x.abs() <= 1e12 { f64::from(x) } else { f64::NAN };
    let position = |v: &[f32]| DVec3::new(usable(v[0]), usable(v[1]), usable(v[2]));
    let positions = vertices.chunks(8).map(position).collect();
    Surface::from_positions(CHART.rows, CHART.cols, positions).unwrap()
}

fn headless(
    solver: &mut HeadlessSolver,
    surface: &Surface,
    sources: &Sources,
    wavefront: Wavefront,
) -> Vec<f32> {
    let mut on_device = solver.upload(surface).unwrap();
    let seeds = sources.seeds(surface).unwrap();
    let method = Method::new(wavefront, STOP);
    solver.solve(&mut on_device, &seeds, method).unwrap().distances
}

/// Returns the map of the headless solver, where sources close to one another are first solved alone.
fn headless_alone(solver: &mut HeadlessSolver, surface: &Surface, sources: &Sources) -> Vec<f32> {
    let mut on_device = solver.upload(surface).unwrap();
    let wavefront = Wavefront::Curved;
    let seeds =
        geosweep::cpu::seeds_for(wavefront, surface, sources.seeds_with_origins(surface).unwrap());
    let method = Method::new(wavefront, STOP);
    solver.solve(&mut on_device, &seeds, method).unwrap().distances
}

/// Replaces some of the vertices by holes, of each kind that the host may write.
fn with_holes(mut vertices: Vec<f32>) -> Vec<f32> {
    for (index, hole) in [(400, f32::NAN), (401, f32::INFINITY), (402, 1e13), (700, f32::NAN)] {
        vertices[8 * index + index % 3] = hole;
    }
    vertices
}

#[test]
fn positions_in_a_buffer_or_an_image_give_the_headless_map() {
    let mut solver = vulkan_solver();
    let vertices = with_holes(vertices(CHART, 0.4));
    let surface = positions(&vertices);
    let texels: Vec<f32> = vertices.chunks(8).flat_map(|v| [v[0], v[1], v[2], f32::NAN]).collect();
    for edge_rule in [EdgeRule::Arc, EdgeRule::Chord] {
        let mut host = Kept::watched();
        // The points follow other data, at an offset that is a multiple of 4 but of no larger power of two.
        let buffer = host.buffer_of(&[vec![7.0; 67], vertices.clone()].concat());
        let image = host.image_of(CHART.cols as u32, CHART.rows as u32, 4, &texels);
        let (kind, slowness) = (PointKind::Positions, None);
        let memory = PointMemory::Buffer { buffer: buffer.handle, offset: 268, stride: 32 };
        let texture = PointMemory::Image { view: image.view, layout: vk::ImageLayout::GENERAL };
        let points =
            [Points { memory, kind, slowness }, Points { memory: texture, kind, slowness }];
        let info = SurfaceInfo::new(CHART).with_points(&points).with_edge_rule(edge_rule);
        let mut stage = Stage::new(host, &RASTER, &info);
        let surface = surface.clone().with_edge_rule(edge_rule);
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let plan = stage.plan(Schedule::Raster, wavefront, 6);
            let map = headless(&mut solver, &surface, &Sources::point(12.0, 30.0), wavefront);
            for points in 0..2 {
                let own = stage.map(points, SourceInput::Inline(&source(12.0, 30.0)), &plan);
                let difference = difference(&map, &own);
                assert!(difference < SAME, "{edge_rule:?}, {wavefront}, {points}: {difference}");
            }
        }
        stage.host.free_image(image);
        stage.end([buffer]);
    }
}

/// The small slowness is that of light, in seconds per metre.
#[test]
fn heights_with_slowness_give_the_headless_map() {
    [1.0, 3.3e-9].into_iter().for_each(heights_with_slowness);
}

/// Compares maps with a slowness times `unit`, with a negative value and NaN, and with a patch of 0 if `unit`
/// is 1.
fn heights_with_slowness(unit: f32) {
    let mut solver = vulkan_solver();
    let height = |index: usize| {
        let (row, col) = CHART.position(index);
        3.0 * (0.2 * row as f32).sin() * (0.3 * col as f32).cos()
    };
    let slowness = |index: usize| match index {
        600 => -1.0,
        601 => f32::NAN,
        // With the small unit there is no patch of 0: a millionth of the least slowness would make edges too short.
        _ if unit == 1.0 && (20..25).contains(&(index / CHART.cols)) && index % CHART.cols < 12 => {
            0.0
        }
        _ => unit * (1.0 + 0.02 * (index % 45) as f32),
    };
    let spacing = Spacing { dx: 0.7, dy: 1.1 };
    let points = 0..CHART.points();
    let weights: Vec<_> = points.clone().map(slowness).collect();
    let heights = points.clone().map(|i| f64::from(height(i))).collect();
    let mask: Vec<_> = weights.iter().map(|&weight| weight >= 0.0).collect();
    let surface = Surface::from_heights(CHART.rows, CHART.cols, heights, spacing).unwrap();
    let surface = surface.with_mask(&mask).unwrap();
    let surface = surface.with_slowness(weights.iter().map(|&w| f64::from(w)).collect()).unwrap();

    let mut host = Kept::watched();
    let pairs: Vec<_> = points.clone().flat_map(|i| [height(i), slowness(i)]).collect();
    let texels: Vec<_> = points.clone().flat_map(|i| [height(i), 0.0, slowness(i), 0.0]).collect();
    let buffer = host.buffer_of(&pairs);
    let image = host.image_of(CHART.cols as u32, CHART.rows as u32, 4, &texels);
    let kind = PointKind::Heights(spacing);
    let memory = PointMemory::Buffer { buffer: buffer.handle, offset: 0, stride: 8 };
    let texture = PointMemory::Image { view: image.view, layout: vk::ImageLayout::GENERAL };
    let points = [
        Points { memory, kind, slowness: Some(1) },
        Points { memory: texture, kind, slowness: Some(2) },
    ];
    let info = SurfaceInfo::new(CHART).with_points(&points);
    let mut stage = Stage::new(host, &RASTER, &info);
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let plan = stage.plan(Schedule::Raster, wavefront, 6);
        // A plan is created without the surface, so it may have circular fronts. Over a slowness, these are updated as
        // planar fronts.
        let solved = if wavefront == Wavefront::Curved { wavefront } else { Wavefront::Planar };
        let map = headless(&mut solver, &surface, &Sources::point(3.0, 40.0), solved);
        // Fronts that leave a patch of 0 have the same time everywhere and differ only in curvature. Rounding
        // decides which of them a point takes.
        let has_ties = unit == 1.0 && wavefront == Wavefront::Curved;
        let most = if has_ties { 2e-4 } else { SAME };
        for points in 0..2 {
            let own = stage.map(points, SourceInput::Inline(&source(3.0, 40.0)), &plan);
            let difference = difference(&map, &own);
            assert!(difference < most, "{wavefront}, {points}: {difference}");
        }
    }
    stage.host.free_image(image);
    stage.end([buffer]);
}

/// The metric shears and stretches, and has a hole. A metric has no rule for edges, so that the rule makes no
/// difference.
#[test]
fn a_metric_gives_the_headless_map() {
    let mut solver = vulkan_solver();
    let tensor = |index: usize| {
        let (row, col) = CHART.position(index);
        let rr = if index == 700 { f64::NAN } else { 1.0 + 0.02 * row as f64 };
        MetricTensor { rr, rc: 0.3 * (0.1 * col as f64).sin(), cc: 2.0 - 0.03 * col as f64 }
    };
    let metric = (0..CHART.points()).map(tensor).collect();
    let surface = Surface::from_metric(CHART.rows, CHART.cols, metric).unwrap();
    let numbers = numbers_of(&surface);
    let stage = Stage::on(Kept::watched(), &RASTER, (&surface, None), numbers);
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let plan = stage.plan(Schedule::Raster, wavefront, 6);
        let map = headless(&mut solver, &surface, &Sources::point(12.0, 30.0), wavefront);
        let own = stage.map(0, SourceInput::Inline(&source(12.0, 30.0)), &plan);
        let difference = difference(&map, &own);
        assert!(difference < SAME, "{wavefront}: {difference}");
    }
    stage.end([]);
}

/// Sources anywhere: on grid points, on edges, in cells, in cells with a missing corner, many in one texel,
/// and more than one dispatch processes. Edges are chords, with which the headless sources are measured too.
#[test]
fn sources_from_the_program_or_a_buffer_give_the_headless_map() {
    let mut solver = vulkan_solver();
    let vertices = with_holes(vertices(CHART, 0.4));
    let surface = positions(&vertices).with_edge_rule(EdgeRule::Chord);
    // Point 700 is row 15, column 25.
    let few = [[4.0, 5.0], [4.5, 5.0], [4.25, 5.75], [20.0, 11.125], [0.0, 44.0], [30.0, 43.5]];
    let beside_a_hole = [[14.25, 24.5], [15.875, 25.75]];
    let scattered = (0..600).map(|i| [(i * 37 % 60) as f32 / 2.0, (i * 53 % 176) as f32 / 4.0]);
    let scattered: Vec<_> = scattered
        .filter(|&[row, col]| Sources::point(row.into(), col.into()).seeds(&surface).is_ok())
        .collect();
    assert!(scattered.len() > 512);
    let timed = |places: &[[f32; 2]]| -> Vec<PointSource> {
        let timed = |(i, &[row, col]): (usize, &[f32; 2])| PointSource {
            time: (i % 7) as f32 * 0.1,
            ..PointSource::at(row, col)
        };
        places.iter().enumerate().map(timed).collect()
    };
    let sets = [timed(&few), timed(&beside_a_hole), timed(&scattered)];

    let mut host = Kept::watched();
    let points = host.buffer_of(&vertices);
    // Entries that are skipped come first and last.
    let nowhere = PointSource::at(f32::NAN, 3.0);
    let off = [PointSource::at(-0.5, 3.0), PointSource::at(3.0, 44.5), nowhere];
    let late = PointSource { time: 1e30, ..PointSource::at(9.0, 9.0) };
    let buffers: Vec<_> = sets
        .iter()
        .map(|set| {
            let all = [&off[..], set, &[late, nowhere]].concat();
            (host.buffer_of(bytemuck::cast_slice(&all)), all.len() as u32)
        })
        .collect();
    let sources: Vec<_> = buffers
        .iter()
        .map(|(buffer, count)| SourceBuffer { buffer: buffer.handle, offset: 0, count: *count })
        .collect();
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(CHART)
        .with_edge_rule(EdgeRule::Chord)
        .with_points(&inputs)
        .with_sources(&sources);
    let passes = [(Schedule::Raster, Wavefront::Curved), (Schedule::Tiles, Wavefront::Circular)];
    let stage = Stage::new(host, &passes, &info);
    for (schedule, wavefront) in passes {
        let plan = stage.plan(schedule, wavefront, 12);
        for (number, set) in sets.iter().enumerate() {
            let sources: Sources = set
                .iter()
                .map(|s| geosweep::Source::Point {
                    at: [f64::from(s.row), f64::from(s.col)].into(),
                    initial: s.time.into(),
                })
                .collect();
            // Entries of a buffer that are skipped count too.
            let inputs = [
                (SourceInput::Inline(set), set.len()),
                (SourceInput::Buffer(number), buffers[number].1 as usize),
            ];
            for (input, entries) in inputs {
                // Curved fronts of few sources are solved alone if other sources are near: on the device,
                // within a third of the distance.
                let (map, most) = match wavefront.is_curved() && entries <= 8 {
                    true => (headless_alone(&mut solver, &surface, &sources), 5e-3),
                    false => (headless(&mut solver, &surface, &sources, wavefront), SAME),
                };
                let own = stage.map(0, input, &plan);
                let difference = difference(&map, &own);
                assert!(difference < most, "{schedule}, {wavefront}, {number}: {difference}");
            }
        }
    }
    stage.end(buffers.into_iter().map(|(buffer, _)| buffer).chain([points]));
}

/// A plan of one iteration, or of a few rounds, is resumed in several command buffers, and several times in one.
/// Sources are added to the map.
#[test]
fn every_schedule_can_be_split_and_added_to() {
    let mut solver = vulkan_solver();
    let surface = positions(&vertices(CHART, 1.4));
    let passes = Schedule::ALL.map(|schedule| (schedule, Wavefront::Curved));
    let stage = Stage::of_waves(Kept::watched(), &passes, SurfaceInfo::new(CHART), 1.4);
    let both = Sources::point(5.0, 7.0).and_point(28.0, 40.0, 0.0);
    let [one, both] = [Sources::point(5.0, 7.0), both]
        .map(|sources| headless(&mut solver, &surface, &sources, Wavefront::Curved));
    for (schedule, wavefront) in passes {
        let portion = if schedule == Schedule::Tiles { 3 } else { 1 };
        let plan = stage.plan(schedule, wavefront, portion);
        assert_eq!(plan.iterations(), portion);
        let own = stage.map(0, SourceInput::Inline(&source(5.0, 7.0)), &plan);
        let apart = difference(&one, &own);
        assert!(apart < SAME, "{schedule}: {apart}");
        let done = stage.surface.outcome(0).unwrap();
        assert!(done.iterations > portion && done.residual <= STOP.tolerance, "{done:?}");

        // Beyond convergence, nothing happens.
        let resume = |recording: geosweep::vulkan::embed::Recording| {
            recording.begin(Access::NONE);
            recording.resume(&plan).unwrap();
            recording.resume(&plan).unwrap();
            recording.outcome(0).unwrap();
            recording.result(0, Reader::COPY, f32::INFINITY)
        };
        stage.run(resume);
        assert_eq!((stage.read(), stage.surface.outcome(0).unwrap()), (own, done), "{schedule}");

        let added = stage.add(SourceInput::Inline(&source(28.0, 40.0)), &plan);
        let apart = difference(&both, &added);
        assert!(apart < SAME, "{schedule}, added: {apart}");

        // Further recordings may be of any length.
        let others = [1, 4, 5, 2, 7].map(|portion| stage.plan(schedule, wavefront, portion));
        stage.run(|recording| {
            recording.begin(Access::NONE);
            recording.solve(SourceInput::Inline(&source(5.0, 7.0)), &plan).unwrap();
            let lengths = || others.iter().cycle().take(2 * done.iterations as usize);
            lengths().for_each(|plan| recording.resume(plan).unwrap());
            recording.outcome(0).unwrap();
            recording.result(0, Reader::COPY, f32::INFINITY)
        });
        let by_others = stage.surface.outcome(0).unwrap();
        assert!(by_others.converged, "{schedule}: {by_others:?}");
        let apart = difference(&one, &stage.read());
        assert!(apart < SAME, "{schedule}, by other plans: {apart}");
        if schedule == Schedule::Tiles {
            // Rounds lead to the same map, however recordings divide them.
            assert_eq!(by_others.iterations, done.iterations);
        }
    }
    stage.end([]);
}

/// A command buffer that is recorded once is submitted for other points and sources, which it reads from
/// buffers.
#[test]
fn a_recording_can_be_submitted_again() {
    let mut solver = vulkan_solver();
    let mut host = Kept::watched();
    let mut points = host.buffer_of(&vertices(CHART, 0.0));
    let mut sources = host.buffer_of(&[0.0; 4]);
    let source_buffers = [SourceBuffer { buffer: sources.handle, offset: 0, count: 1 }];
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(CHART).with_points(&inputs).with_sources(&source_buffers);
    let stage = Stage::new(host, &RASTER, &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 10);
    let commands = stage.host.commands();
    stage.host.begin(commands);
    let recording = stage.solver.record(&stage.host.device, commands, &stage.surface);
    let frame = Frame::new(&plan, SourceInput::Buffer(0), Reader::COPY).with_points(0);
    recording.frame(&frame).unwrap();
    stage.host.end(commands);
    for (phase, row, col) in [(0.5, 3.0, 40.0), (2.5, 20.0, 8.0)] {
        let vertices = vertices(CHART, phase);
        points.floats_mut()[..vertices.len()].copy_from_slice(&vertices);
        sources.floats_mut()[..4].copy_from_slice(bytemuck::cast_slice(&source(row, col)));
        stage.host.submit(commands, vk::Fence::null());
        unsafe { stage.host.device.queue_wait_idle(stage.host.queue) }.unwrap();
        assert!(stage.surface.outcome(0).unwrap().converged);
        stage.run(|_| stage.surface.result(0, Reader::COPY.layout));
        let place = Sources::point(row.into(), col.into());
        let map = headless(&mut solver, &positions(&vertices), &place, Wavefront::Curved);
        let difference = difference(&map, &stage.read());
        assert!(difference < SAME, "{phase}: {difference}");
    }
    stage.end([points, sources]);
}

/// Iterations end at the method's limit, which is not convergence.
#[test]
fn iterations_run_out_without_convergence() {
    let passes = Schedule::ALL.map(|schedule| (schedule, Wavefront::Planar));
    let stage = Stage::of_waves(Kept::watched(), &passes, SurfaceInfo::new(CHART), 0.0);
    for (schedule, wavefront) in passes {
        let stop = Stop::within(1e-6).or_after(3);
        let method = Method::new(wavefront, stop).with_schedule(schedule);
        let plan = stage.solver.plan(CHART, method, 2).unwrap();
        stage.run(|recording| {
            recording.begin(Access::NONE);
            recording.measure(0).unwrap();
            recording.solve(SourceInput::Inline(&source(0.0, 0.0)), &plan).unwrap();
            for _ in 0..4 {
                recording.resume(&plan).unwrap();
            }
            recording.outcome(0).unwrap();
            recording.result(0, Reader::COPY, -1.0)
        });
        let outcome = stage.surface.outcome(0).unwrap();
        match schedule {
            // Two scans to and fro are enough here.
            Schedule::Raster => assert!(outcome.iterations <= 3, "{outcome:?}"),
            _ => {
                // A round visits only tiles, of which there are six here, or more if shared memory is small.
                let unreached = stage.read().contains(&-1.0);
                assert!(unreached || schedule == Schedule::Tiles);
                assert!(!outcome.converged && (3..=4).contains(&outcome.iterations), "{outcome:?}");
            }
        }
    }
    stage.end([]);
}

/// Several readings are compared with the image: distances at some places, the packed times, the outcome in a
/// buffer of the host, and the value of points that are not reached.
#[test]
fn the_map_can_be_read_in_other_ways() {
    let mut vertices = vertices(CHART, 0.9);
    // A wall of holes: points beyond column 30 are not reached.
    for row in 0..CHART.rows {
        vertices[8 * CHART.index(row, 30)] = f32::NAN;
    }
    let mut host = Kept::watched();
    let points = host.buffer_of(&vertices);
    let asked = [
        [3.0, 4.0],   // at a grid point
        [3.5, 4.0],   // on an edge
        [7.25, 20.5], // in a cell
        [12.0, 40.0], // not reached
        [12.0, 29.5], // beside the wall
        [-1.0, 4.0],  // off the grid
        [f32::NAN, 4.0],
        [30.0, 0.0], // a corner
    ];
    let places = host.buffer_of(&[&[0.0; 3], asked.as_flattened()].concat());
    let looked_up = host.buffer(4 * 16, true);
    let texels = host.buffer(16 * 64 * 64, true);
    let record = host.buffer(16 + Outcome::BYTES as u64, true);
    let lookup = Lookup {
        places: places.handle,
        places_offset: 12,
        distances: looked_up.handle,
        distances_offset: 8,
        count: asked.len() as u32,
    };
    let lookup_buffers = [lookup];
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(CHART).with_points(&inputs).with_lookups(&lookup_buffers);
    let stage = Stage::new(host, &RASTER, &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 20);
    stage.run(|recording| {
        let result = recording.frame(
            &Frame::new(&plan, SourceInput::Inline(&source(16.0, 11.0)), Reader::COPY)
                .with_points(0)
                .with_unreached(-5.0),
        );
        recording.lookup(0, -7.0, Access::NONE, Access::HOST_READ).unwrap();
        recording.outcome_to(record.handle, 16, Access::HOST_READ).unwrap();
        result
    });
    let map = stage.read();
    let at = |row: usize, col: usize| map[CHART.index(row, col)];
    assert_eq!((at(16, 11), at(12, 40), at(12, 30)), (0.0, -5.0, -5.0));
    assert!(map.iter().all(|&d| d >= 0.0 || d == -5.0));

    let found = &looked_up.floats()[2..][..asked.len()];
    let cell = 0.125 * (3.0 * at(7, 20) + 3.0 * at(7, 21) + at(8, 20) + at(8, 21));
    let corner = at(30, 0);
    let expected = [at(3, 4), 0.5 * (at(3, 4) + at(4, 4)), cell, -7.0, -7.0, -7.0, -7.0, corner];
    for (found, expected) in found.iter().zip(expected) {
        approx::assert_relative_eq!(*found, expected, max_relative = 1e-6);
    }

    let bytes = record.bytes()[16..][..Outcome::BYTES].try_into().unwrap();
    let outcome = stage.surface.outcome_from(bytes).unwrap();
    assert!(outcome.converged && outcome.iterations > 1, "{outcome:?}");
    assert_eq!(outcome, stage.surface.outcome(0).unwrap());

    let PackedTimes { image, layer, border } = stage.surface.packed();
    let device = &stage.host.device;
    stage.host.run(|commands| {
        stage.solver.record(device, commands, &stage.surface).end(Access::TRANSFER_READ);
        let layers = vk::ImageSubresourceLayers::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .base_array_layer(layer)
            .layer_count(1);
        let copy = vk::BufferImageCopy::default()
            .image_subresource(layers)
            .image_extent(image.extent.into());
        unsafe {
            let to = texels.handle;
            device.cmd_copy_image_to_buffer(commands, image.image, image.layout, to, &[copy]);
        }
        stage.host.barrier(commands, Access::TRANSFER_WRITE, Access::HOST_READ);
    });
    for (index, &distance) in map.iter().enumerate() {
        let (row, col) = CHART.position(index);
        let texel =
            (row / 2 + border as usize) * image.extent.width as usize + (col / 2 + border as usize);
        let time = texels.floats()[4 * texel + 2 * (row % 2) + col % 2];
        assert_eq!(if time < 1e30 { time } else { -5.0 }, distance, "{row},{col}");
    }
    stage.end([points, places, looked_up, record, texels]);
}

/// The recording reads a height field before the host's render pass that writes it has ended, unless the
/// recording is told of the pass.
#[test]
fn a_writer_that_is_not_named_is_reported() {
    let after_rendering = |before| {
        let mut host = Host::new();
        let image = host.image_of(8, 8, 1, &[0.0; 64]);
        let target = host.target(&image, 8, 8);
        let points = [Points {
            memory: PointMemory::Image { view: image.view, layout: vk::ImageLayout::GENERAL },
            kind: PointKind::Heights(Spacing::square(1.0)),
            slowness: None,
        }];
        let info = SurfaceInfo::new(Chart { rows: 8, cols: 8 }).with_points(&points);
        let mut stage = Stage::new(host, &RASTER, &info);
        let plan = stage.plan(Schedule::Raster, Wavefront::Circular, 4);
        stage.host.run(|commands| {
            stage.host.clear(commands, &target, 3.0);
            let recording = stage.solver.record(&stage.host.device, commands, &stage.surface);
            recording
                .frame(
                    &Frame::new(&plan, SourceInput::Inline(&source(0.0, 0.0)), Reader::COPY)
                        .with_before(before)
                        .with_points(0),
                )
                .unwrap();
        });
        let messages = stage.host.messages();
        stage.host.free_target(target);
        stage.host.free_image(image);
        stage.take_down([]);
        messages
    };
    let stages = vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT;
    let rendering = Access::new(stages, vk::AccessFlags::COLOR_ATTACHMENT_WRITE);
    assert_eq!(after_rendering(rendering), Vec::<String>::new());
    let messages = after_rendering(Access::NONE);
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD-READ-AFTER-WRITE")), "{messages:?}");
}
