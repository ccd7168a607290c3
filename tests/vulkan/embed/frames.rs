//! Frames: a surface that a pass of the host deforms, and a pass that reads the map.

use geosweep::ash::vk;
use geosweep::glam::DVec3;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Access, Frame, PointSource, Points, Reader, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{HeadlessSolver, Method, Schedule};
use geosweep::{DeviceChoice, Sources, Surface, Wavefront};

use crate::common::difference;
use crate::embed::stage::STOP;
use crate::host::{Host, HostBuffer, HostPass};

pub const CHART: Chart = Chart { rows: 40, cols: 48 };
/// Floats of a vertex: position, normal and texture coordinates.
pub const STRIDE: usize = 8;
pub const IN_FLIGHT: usize = 2;
pub const PASSES: [(Schedule, Wavefront); 1] = [(Schedule::Raster, Wavefront::Curved)];

/// Moves the vertices.
pub const DEFORM: &str = "
    @group(0) @binding(0) var<storage, read> phase: array<f32>;
    @group(0) @binding(1) var<storage, read_write> vertices: array<f32>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        let col = id.x % 48u;
        let row = id.x / 48u;
        if (row >= 40u) { return; }
        let x = f32(col);
        let y = 1.2 * f32(row);
        vertices[8u * id.x] = x;
        vertices[8u * id.x + 1u] = y;
        vertices[8u * id.x + 2u] = 2.0 * sin(0.3 * x + phase[0]) * cos(0.2 * y);
    }";

/// Reads the map, as a shader that draws would.
pub const DRAW: &str = "
    @group(0) @binding(0) var<storage, read_write> picture: array<f32>;
    @group(0) @binding(1) var distances: texture_2d<f32>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        let col = id.x % 48u;
        let row = id.x / 48u;
        if (row >= 40u) { return; }
        picture[id.x] = textureLoad(distances, vec2<u32>(col, row), 0).r;
    }";

struct Renderer {
    host: Host,
    solver: embed::Solver,
    surface: embed::FrameSurface,
    plan: embed::Plan,
    vertices: HostBuffer,
    frames: Vec<InFlight>,
}

struct InFlight {
    /// Amount by which the vertices are moved.
    phase: HostBuffer,
    deform: HostPass,
    /// The map as it is drawn, and the vertices for which it was computed.
    picture: HostBuffer,
    copy: HostBuffer,
    draw: HostPass,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
}

impl Renderer {
    fn new() -> Self {
        let mut host = Host::new();
        let device = host.device.clone();
        let bytes = 4 * (STRIDE * CHART.points()) as u64;
        let vertices = host.buffer(bytes, false);
        let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &PASSES);
        let solver = solver.unwrap();
        let points = [Points::positions(vertices.handle, 4 * STRIDE as u64)];
        let info = SurfaceInfo::new(CHART).with_slots(IN_FLIGHT).with_points(&points);
        let surface = solver.surface(&device, host.allocator(), &info).unwrap();
        let method = Method::new(Wavefront::Curved, STOP);
        let plan = solver.plan(CHART, method, 8).unwrap();
        let frames = (0..IN_FLIGHT)
            .map(|slot| {
                let phase = host.buffer_of(&[0.0]);
                let deform = host.pass(DEFORM, &[phase.handle, vertices.handle], None);
                let picture = host.buffer(4 * CHART.points() as u64, true);
                let copy = host.buffer(bytes, true);
                let image = surface.result(slot, Reader::COMPUTE.layout).unwrap();
                let draw = host.pass(DRAW, &[picture.handle], Some(image.view));
                let info = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
                let fence = unsafe { device.create_fence(&info, None) }.unwrap();
                let commands = host.commands();
                InFlight { phase, deform, picture, copy, draw, commands, fence }
            })
            .collect();
        host.run(|commands| solver.record(&device, commands, &surface).prepare());
        Self { host, solver, surface, plan, vertices, frames }
    }

    /// Records a frame: moves the vertices, computes the map and draws it.
    fn record(&self, commands: vk::CommandBuffer, number: usize, slot: usize, reader: Reader) {
        let Self { host, vertices, .. } = self;
        let InFlight { deform, copy, draw, .. } = &self.frames[slot];
        let groups = CHART.points().div_ceil(64) as u32;
        // The recording no longer uses the vertices, but the host's own copy of them still does.
        host.barrier(commands, Access::TRANSFER_READ, Access::COMPUTE_WRITE);
        host.dispatch(commands, deform, groups);

        let (row, col) = place(number);
        self.solver
            .record(&host.device, commands, &self.surface)
            .frame(
                &Frame::new(&self.plan, SourceInput::Inline(&[PointSource::at(row, col)]), reader)
                    .with_before(Access::COMPUTE_WRITE)
                    .with_points(0)
                    .with_slot(slot),
            )
            .unwrap();

        host.dispatch(commands, draw, groups);
        host.barrier(commands, Access::COMPUTE_WRITE, Access::HOST_READ.and(Access::TRANSFER_READ));
        let all = [vk::BufferCopy::default().size(4 * (STRIDE * CHART.points()) as u64)];
        unsafe {
            let (from, to) = (vertices.handle, copy.handle);
            host.device.cmd_copy_buffer(commands, from, to, &all);
        }
        host.barrier(
            commands,
            Access::TRANSFER_WRITE,
            Access::HOST_READ.and(Access::TRANSFER_WRITE),
        );
    }

    fn end(self) -> Vec<String> {
        let Self { mut host, mut solver, mut surface, vertices, frames, .. } = self;
        let device = host.device.clone();
        unsafe { device.device_wait_idle() }.unwrap();
        for frame in frames {
            for buffer in [frame.phase, frame.picture, frame.copy] {
                host.free(buffer);
            }
            host.destroy_pass(frame.deform);
            host.destroy_pass(frame.draw);
            unsafe { device.destroy_fence(frame.fence, None) };
        }
        host.free(vertices);
        surface.destroy(&device, host.allocator());
        surface.destroy(&device, host.allocator());
        solver.destroy(&device);
        assert_eq!(host.allocations(), 0);
        host.messages()
    }
}

/// Returns the source of a frame. It moves over the grid, and is between grid points in two of four frames.
pub fn place(number: usize) -> (f32, f32) {
    let turn = 0.1 * number as f32;
    let (row, col) = (19.5 + 15.0 * turn.sin(), 23.5 + 18.0 * (0.7 * turn).cos());
    if number % 4 < 2 { (row.round(), col.round()) } else { (row, col) }
}

/// With two frames in flight, 200 frames run. Some of their maps are compared with those of the headless
/// solver on the same vertices.
#[test]
fn a_deforming_surface_is_drawn_for_200_frames_without_a_message() {
    let mut renderer = Renderer::new();
    let device = renderer.host.device.clone();
    let mut headless = HeadlessSolver::new(&DeviceChoice::Any).unwrap();
    let mut drawn = [None; IN_FLIGHT];
    let mut compared = 0;
    for number in 0..200 {
        let slot = number % IN_FLIGHT;
        let InFlight { phase, picture, copy, commands, fence, .. } = &mut renderer.frames[slot];
        let (commands, fence) = (*commands, *fence);
        unsafe { device.wait_for_fences(&[fence], true, u64::MAX) }.unwrap();
        if let Some(number) = drawn[slot].replace(number) {
            let outcome = renderer.surface.outcome(slot).unwrap();
            assert!(outcome.converged && outcome.iterations <= 8, "{outcome:?}");
            if number % 40 < 4 {
                let picture = &picture.floats()[..CHART.points()];
                assert_same(&mut headless, copy.floats(), number, picture);
                compared += 1;
            }
        }
        phase.floats_mut()[0] = 0.05 * number as f32;
        unsafe { device.reset_fences(&[fence]) }.unwrap();
        renderer.host.begin(commands);
        renderer.record(commands, number, slot, Reader::COMPUTE);
        renderer.host.end(commands);
        renderer.host.submit(commands, fence);
    }
    assert_eq!(compared, 20);
    assert_eq!(renderer.end(), Vec::<String>::new());
}

/// Asserts that the picture equals the headless solver's map of the same vertices, within 1e-5 of the largest
/// distance. The sources are grid points and places between them.
pub fn assert_same(
    headless: &mut HeadlessSolver,
    vertices: &[f32],
    number: usize,
    picture: &[f32],
) {
    let position = |index: usize| {
        let vertex = &vertices[STRIDE * index..];
        DVec3::new(vertex[0].into(), vertex[1].into(), vertex[2].into())
    };
    let positions = (0..CHART.points()).map(position).collect();
    let surface = Surface::from_positions(CHART.rows, CHART.cols, positions).unwrap();
    let (row, col) = place(number);
    let seeds = Sources::point(row.into(), col.into()).seeds(&surface).unwrap();
    let method = Method::new(Wavefront::Curved, STOP);
    let mut on_device = headless.upload(&surface).unwrap();
    let map = headless.solve(&mut on_device, &seeds, method).unwrap();
    let difference = difference(&map.distances, picture);
    println!("frame {number}: {difference:e}");
    assert!(difference < 1e-5, "frame {number}: {difference}");
}

/// Returns the messages for two frames in one command buffer, since older layers do not check across
/// submissions.
fn messages_of_two_frames(reader: Reader) -> Vec<String> {
    let renderer = Renderer::new();
    renderer.host.run(|commands| {
        for number in 0..2 {
            renderer.record(commands, number, 0, reader);
        }
    });
    renderer.end()
}

#[test]
fn frames_in_one_submission_share_a_slot_and_all_images() {
    assert_eq!(messages_of_two_frames(Reader::COMPUTE), Vec::<String>::new());
}

/// A hazard must be reported, or a clean log would prove nothing.
#[test]
fn a_reader_that_is_not_named_is_reported() {
    let layout = Reader::COMPUTE.layout;
    let messages = messages_of_two_frames(Reader { access: Access::TRANSFER_READ, layout });
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD-READ-AFTER-WRITE")), "{messages:?}");
}
