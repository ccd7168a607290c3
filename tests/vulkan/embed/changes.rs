//! Inputs that change: parts of a buffer selected by an offset, other buffers and images in place of those
//! with which a surface was created, and vertices that were zeroed.

use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Access, ContourFrame, CurveRecord, CurveVertex, Frame, LevelInput, PathFrame, PathsInfo,
    PointKind, PointMemory, PointSource, Points, Reader, RegionFrame, SourceBuffer, SourceInput,
    StartInput, SurfaceInfo,
};
use geosweep::vulkan::{Schedule, VulkanError};

use crate::embed::stage::{Kept, RASTER, Stage, source, vertices};
use crate::host::HostBuffer;

const CHART: Chart = Chart { rows: 21, cols: 34 };
const STRIDE: u64 = 32;
const PART: u64 = STRIDE * (CHART.rows * CHART.cols) as u64;
const PHASES: [f32; 3] = [0.0, 0.9, 2.0];

fn frame<'a>(plan: &'a embed::Plan, sources: SourceInput<'a>) -> Frame<'a> {
    Frame::new(plan, sources, Reader::COPY).with_points(0)
}

impl Stage {
    /// Returns the map from points that begin `offset` bytes later.
    fn map_at(&self, offset: u64, sources: SourceInput, plan: &embed::Plan) -> Vec<f32> {
        self.run(|recording| recording.points_at(offset).frame(&frame(plan, sources)));
        self.finish(plan);
        self.read()
    }
}

/// Returns the map of each phase, from a surface whose points never change.
fn maps_of_phases(sources: &[PointSource], wavefront: Wavefront) -> Vec<Vec<f32>> {
    let mut host = Kept::watched();
    let buffers = PHASES.map(|phase| host.buffer_of(&vertices(CHART, phase)));
    let points = buffers.each_ref().map(|buffer| Points::positions(buffer.handle, STRIDE));
    let info = SurfaceInfo::new(CHART).with_points(&points);
    let stage = Stage::new(host, &RASTER, &info);
    let plan = stage.plan(Schedule::Raster, wavefront, 12);
    let map = |number| stage.map(number, SourceInput::Inline(sources), &plan);
    let maps = (0..PHASES.len()).map(map).collect();
    stage.end(buffers);
    maps
}

#[test]
fn each_frame_reads_its_part_of_a_ring() {
    let place = source(7.25, 20.5);
    let expected = maps_of_phases(&place, Wavefront::Curved);
    let mut host = Kept::watched();
    // The surface's points begin 48 bytes after the buffer's start.
    let parts = PHASES.map(|phase| vertices(CHART, phase)).concat();
    let points = host.buffer_of(&[vec![f32::NAN; 12], parts].concat());
    let ring: Vec<_> = [[2.0, 3.0], [7.25, 20.5], [19.0, 5.0]]
        .into_iter()
        .flat_map(|[row, col]| [row, col, 0.0, 0.0])
        .collect();
    let ring = host.buffer_of(&ring);
    let memory = PointMemory::Buffer { buffer: points.handle, offset: 48, stride: STRIDE };
    let inputs = [Points { memory, ..Points::positions(points.handle, STRIDE) }];
    let sources = [SourceBuffer { buffer: ring.handle, offset: 0, count: 1 }];
    let info = SurfaceInfo::new(CHART).with_points(&inputs).with_sources(&sources);
    let stage = Stage::new(host, &RASTER, &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 12);
    for turn in [0, 2, 1, 0] {
        let offset = PART * turn as u64;
        let inline = stage.map_at(offset, SourceInput::Inline(&place), &plan);
        assert!(inline == expected[turn], "part {turn}");
        let from_ring =
            stage.map_at(offset, SourceInput::BufferAt { number: 0, offset: 16 }, &plan);
        assert!(from_ring == expected[turn], "part {turn}, sources in a ring");
    }
    let first = stage.map_at(0, SourceInput::Buffer(0), &plan);
    assert!(first != expected[0] && first[CHART.index(2, 3)] == 0.0);

    let inline = SourceInput::Inline(&place);
    let of_points =
        |offset| stage.attempt(|r| r.points_at(offset).frame(&frame(&plan, inline)).unwrap_err());
    let of_sources = |offset| {
        let beyond = SourceInput::BufferAt { number: 0, offset };
        stage.attempt(|r| r.frame(&frame(&plan, beyond)).unwrap_err())
    };
    for (error, what, reason) in [
        (of_points(3 * PART), "points", "is beyond the"),
        (of_points(u64::MAX - 3), "points", "is beyond the"),
        (of_points(PART + 2), "points", "no multiple of 4"),
        (of_sources(1 << 20), "sources", "is beyond the"),
        (of_sources(1), "sources", "no multiple of 4"),
    ] {
        let VulkanError::HostBuffer { what: of, reason: said } = &error else { panic!("{error}") };
        assert!(*of == what && said.contains(reason), "{error}");
    }
    let none = SourceInput::BufferAt { number: 1, offset: 0 };
    let error = stage.attempt(|r| r.frame(&frame(&plan, none)).unwrap_err());
    assert!(matches!(error, VulkanError::NoSuch { what: "source buffers", number: 1, .. }));
    stage.end([points, ring]);
}

/// Points are replaced without waiting for earlier frames. The validation layers would report a hazard.
#[test]
fn points_are_replaced_while_frames_are_in_flight() {
    let place = source(7.25, 20.5);
    let expected = maps_of_phases(&place, Wavefront::Planar);
    let mut host = Kept::watched();
    let device = host.device.clone();
    let buffers = [0, 1].map(|phase| host.buffer_of(&vertices(CHART, PHASES[phase])));
    let texels: Vec<_> = vertices(CHART, PHASES[2])
        .chunks_exact(8)
        .flat_map(|vertex| [vertex[0], vertex[1], vertex[2], 0.0])
        .collect();
    let image = host.image_of(CHART.cols as u32, CHART.rows as u32, 4, &texels);
    let memory = PointMemory::Image { view: image.view, layout: vk::ImageLayout::GENERAL };
    let of_image = Points { memory, kind: PointKind::Positions, slowness: None };
    let [first, second] = buffers.each_ref().map(|of| Points::positions(of.handle, STRIDE));
    let all = [first, second, of_image];
    let info = SurfaceInfo::new(CHART).with_slots(2).with_points(&all[..1]);
    let mut stage = Stage::new(host, &RASTER[..1], &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Planar, 12);
    let bytes = 4 * CHART.points() as u64;
    let to = [(); 6].map(|()| stage.host.buffer(bytes, true));
    let mut fences: Vec<vk::Fence> = Vec::new();
    for (turn, to) in to.iter().enumerate() {
        if turn >= 2 {
            // Waits for the frame before the last one, as in a renderer with two frames in flight.
            unsafe { device.wait_for_fences(&fences[turn - 2..=turn - 2], true, u64::MAX) }
                .unwrap();
        }
        stage.surface.set_points(&device, &stage.solver, 0, &all[turn % 3]).unwrap();
        let commands = stage.host.commands();
        stage.host.begin(commands);
        let recording = stage.solver.record(&device, commands, &stage.surface);
        let frame = frame(&plan, SourceInput::Inline(&place)).with_slot(turn % 2);
        let map = recording.frame(&frame).unwrap();
        stage.host.copy_image(commands, map, to);
        stage.host.end(commands);
        let fence = unsafe { device.create_fence(&Default::default(), None) }.unwrap();
        stage.host.submit(commands, fence);
        fences.push(fence);
    }
    unsafe { device.device_wait_idle() }.unwrap();
    for (turn, to) in to.iter().enumerate() {
        assert!(to.floats()[..CHART.points()] == expected[turn % 3], "frame {turn}");
    }
    fences.into_iter().for_each(|fence| unsafe { device.destroy_fence(fence, None) });

    // The next recordings are not submitted. They are one more than there are slots.
    for (turn, points) in all.iter().enumerate() {
        stage.surface.set_points(&device, &stage.solver, 0, points).unwrap();
        let commands = stage.host.commands();
        stage.host.begin(commands);
        let recording = stage.solver.record(&device, commands, &stage.surface);
        let frame = frame(&plan, SourceInput::Inline(&place)).with_slot(turn % 2);
        recording.frame(&frame).unwrap();
        stage.host.end(commands);
        assert!(stage.surface.points_in_flight(0).unwrap());
    }
    let refused = stage.surface.set_points(&device, &stage.solver, 0, &first).unwrap_err();
    let in_flight = VulkanError::InputInFlight { what: "points", number: 0 };
    assert_eq!(refused.to_string(), in_flight.to_string());
    (0..2).for_each(|slot| stage.surface.discard(slot).unwrap());
    stage.surface.set_points(&device, &stage.solver, 0, &first).unwrap_err();
    assert!(stage.surface.is_in_flight(), "slot 0 was recorded twice");
    stage.map(0, SourceInput::Inline(&place), &plan);
    assert!(!stage.surface.is_in_flight() && !stage.surface.points_in_flight(0).unwrap());
    stage.surface.set_points(&device, &stage.solver, 0, &first).unwrap();
    let again = stage.map(0, SourceInput::Inline(&place), &plan);
    assert!(again == expected[0]);

    let slow = Points { slowness: Some(4), ..first };
    let refused = stage.surface.set_points(&device, &stage.solver, 0, &slow).unwrap_err();
    assert!(refused.to_string().contains("they have a slowness"), "{refused}");
    let refused = stage.surface.set_points(&device, &stage.solver, 1, &first).unwrap_err();
    assert!(matches!(refused, VulkanError::NoSuch { number: 1, count: 1, .. }), "{refused}");
    let wide = Points::positions(buffers[0].handle, 1 << 16);
    let refused = stage.surface.set_points(&device, &stage.solver, 0, &wide).unwrap_err();
    assert!(refused.to_string().contains("but has"), "{refused}");
    let again = stage.map(0, SourceInput::Inline(&place), &plan);
    assert!(again == expected[0], "what is refused changes nothing");
    stage.host.free_image(image);
    stage.end(buffers.into_iter().chain(to));
}

/// Contours and paths are lifted to the measured part of a ring. Once they are rebound, they are lifted to
/// points that have replaced the ring. Paths and regions find sources in the same way.
#[test]
fn curves_and_regions_follow_points_and_sources() {
    let mut host = Kept::watched();
    let device = host.device.clone();
    let high = |by: f32| -> Vec<f32> {
        let mut all = vertices(CHART, 0.4);
        all.chunks_exact_mut(8).for_each(|vertex| vertex[2] += by);
        all
    };
    let ring = host.buffer_of(&[high(0.0), high(100.0)].concat());
    let other = host.buffer_of(&high(200.0));
    let entries = host.buffer_of(&[2.0, 3.0, 0.0, 0.0, 18.0, 30.0, 0.0, 0.0]);
    let inputs = [Points::positions(ring.handle, STRIDE)];
    let sources = [SourceBuffer { buffer: entries.handle, offset: 0, count: 1 }];
    let info = SurfaceInfo::new(CHART).with_points(&inputs).with_sources(&sources);
    let mut stage = Stage::new(host, &RASTER, &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 12);
    let (solver, surface) = (&stage.solver, &stage.surface);
    let allocator = stage.host.allocator();
    let mut contours = solver.contours(&device, allocator, surface, 4000).unwrap();
    let room = PathsInfo::new(1, 200);
    let mut paths = solver.paths(&device, allocator, surface, room).unwrap();
    let mut regions = solver.regions(&device, allocator, surface, Wavefront::Curved).unwrap();
    let to = [(); 2].map(|()| stage.host.buffer(1 << 17, true));

    // Returns the heights of contours and of the path, and the end of the path.
    let draw = |stage: &Stage, contours: &embed::Contours, paths: &embed::Paths, at, sources| {
        stage.host.run(|commands| {
            let recording = stage.solver.record(&device, commands, &stage.surface).points_at(at);
            recording.frame(&frame(&plan, sources)).unwrap();
            let reader = Access::TRANSFER_READ;
            let levels = LevelInput::Spacing { step: 2.0, count: 20 };
            let lines = ContourFrame::new(levels, reader);
            let lines = recording.contours(contours, &lines)?;
            let starts = StartInput::Inline(&[[10.0, 16.5]]);
            let before = Access::NONE;
            let way = PathFrame::new(starts, sources, reader).with_before(before);
            let way = recording.paths(paths, &way)?;
            for (from, to) in [lines, way].into_iter().zip(&to) {
                let size = from.vertices_offset
                    + u64::from(from.curves * from.capacity * CurveVertex::BYTES);
                stage.host.copy_buffer(commands, from.buffer, to, size.min(1 << 17));
            }
            Ok::<_, VulkanError>([lines, way])
        })
    };
    let read = |[lines, way]: [embed::CurveBuffer; 2]| {
        let vertices = |of: embed::CurveBuffer, from: &HostBuffer| -> Vec<CurveVertex> {
            let record: &CurveRecord =
                bytemuck::from_bytes(&from.bytes()[..CurveRecord::BYTES as usize]);
            let bytes = &from.bytes()[of.vertices_offset as usize..];
            let size = (record.vertex_count * CurveVertex::BYTES) as usize;
            bytemuck::cast_slice(&bytes[..size]).to_vec()
        };
        [vertices(lines, &to[0]), vertices(way, &to[1])]
    };
    let heights = |curves: &[Vec<CurveVertex>; 2]| {
        let mean = |of: &Vec<CurveVertex>| {
            assert!(of.len() > 10);
            of.iter().map(|vertex| vertex.position[2]).sum::<f32>() / of.len() as f32
        };
        [mean(&curves[0]), mean(&curves[1])]
    };
    let near = |found: [f32; 2], height: f32| {
        assert!(found.iter().all(|z| (z - height).abs() < 3.0), "{found:?}, not {height}");
    };
    let (here, there) = (SourceInput::Buffer(0), SourceInput::BufferAt { number: 0, offset: 16 });
    for (at, height, sources, end) in
        [(0, 0.0, here, [2.0, 3.0]), (PART, 100.0, there, [18.0, 30.0])]
    {
        let curves = read(draw(&stage, &contours, &paths, at, sources).unwrap());
        near(heights(&curves), height);
        let last = curves[1].last().unwrap();
        assert!((last.row - end[0]).abs() + (last.col - end[1]).abs() < 1e-4, "{last:?}");
    }

    let replaced = Points::positions(other.handle, STRIDE);
    stage.surface.set_points(&device, &stage.solver, 0, &replaced).unwrap();
    let old = |error: VulkanError, wanted: &str| {
        assert!(matches!(error, VulkanError::OldInput { what, number: 0 } if what == wanted));
    };
    old(draw(&stage, &contours, &paths, 0, here).unwrap_err(), "points");
    contours.rebind(&device, &stage.solver, &stage.surface).unwrap();
    old(draw(&stage, &contours, &paths, 0, here).unwrap_err(), "points");
    paths.rebind(&device, &stage.solver, &stage.surface).unwrap();
    near(heights(&read(draw(&stage, &contours, &paths, 0, here).unwrap())), 200.0);

    let sources = SourceBuffer { offset: 16, ..sources[0] };
    stage.surface.set_sources(&device, &stage.solver, 0, &sources).unwrap();
    old(draw(&stage, &contours, &paths, 0, here).unwrap_err(), "sources");
    let label = RegionFrame::new(here, Access::HOST_READ);
    old(stage.attempt(|r| r.regions(&regions, &label).unwrap_err()), "sources");
    paths.rebind(&device, &stage.solver, &stage.surface).unwrap();
    regions.rebind(&device, &stage.solver, &stage.surface).unwrap();
    let curves = read(draw(&stage, &contours, &paths, 0, here).unwrap());
    let last = curves[1].last().unwrap();
    assert!((last.row - 18.0).abs() + (last.col - 30.0).abs() < 1e-4, "{last:?}");
    let labels = regions.labels();
    stage.host.run(|commands| {
        let recording = stage.solver.record(&device, commands, &stage.surface);
        let label = label.with_reader(Access::TRANSFER_READ);
        recording.regions(&regions, &label).unwrap();
        stage.host.copy_buffer(commands, labels.buffer, &to[0], labels.bytes);
    });
    assert!(to[0].bytes()[..labels.bytes as usize].iter().all(|&byte| byte == 0));

    let allocator = stage.host.allocator();
    contours.destroy(&device, allocator);
    paths.destroy(&device, allocator);
    regions.destroy(&device, allocator);
    let gone = contours.rebind(&device, &stage.solver, &stage.surface);
    assert!(matches!(gone, Err(VulkanError::Destroyed)));
    stage.end([ring, other, entries].into_iter().chain(to));
}

/// Zeroed vertices make edges of length 0, which the outcome counts. Edges at holes do not count.
#[test]
fn edges_without_length_are_counted() {
    let edges = |rows: usize, cols: usize| {
        rows * (cols - 1) + (rows - 1) * cols + 2 * (rows - 1) * (cols - 1)
    };
    let mut patch = vertices(CHART, 0.4);
    for index in 0..CHART.points() {
        let (row, col) = CHART.position(index);
        if row < 5 && col >= 30 {
            patch[8 * index..][..3].fill(0.0);
        }
    }
    let mut holed = patch.clone();
    // Eight points inside the patch have an edge to this hole.
    holed[8 * CHART.index(2, 32)] = f32::NAN;
    for (points, without) in [
        (vertices(CHART, 0.4), 0),
        (vec![0.0; 8 * CHART.points()], edges(CHART.rows, CHART.cols)),
        (patch, edges(5, 4)),
        (holed, edges(5, 4) - 8),
    ] {
        let mut host = Kept::watched();
        let buffer = host.buffer_of(&points);
        let inputs = [Points::positions(buffer.handle, STRIDE)];
        let info = SurfaceInfo::new(CHART).with_points(&inputs);
        let stage = Stage::new(host, &RASTER[..1], &info);
        let plan = stage.plan(Schedule::Raster, Wavefront::Planar, 8);
        stage.map(0, SourceInput::Inline(&source(12.0, 4.0)), &plan);
        let outcome = stage.surface.outcome(0).unwrap();
        assert_eq!(outcome.edges_without_length as usize, without, "{outcome:?}");
        stage.end([buffer]);
    }
}
