//! Frames: a surface that a pass of the host deforms, and a pass that reads the map; on one queue, or with the map on a
//! second queue.

use geosweep::ash::vk;
use geosweep::glam::DVec3;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Access, ContourFrame, Contours, CurveRecord, CurveStatus, CurveVertex, Frame, LevelInput,
    PointSource, Points, Reader, ResultImage, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{HeadlessSolver, Method, Schedule};
use geosweep::{Sources, Surface, Wavefront};

use crate::common::{difference, vulkan_solver};
use crate::embed::curves::{contours, map_of};
use crate::embed::stage::STOP;
use crate::host::{self, Host, HostBuffer, HostPass};

pub mod handover {
    // docs/async-compute.md contains this file.
    include!("handover.rs");
}

const CHART: Chart = Chart { rows: 40, cols: 48 };
/// Floats of a vertex: position, normal and texture coordinates.
const STRIDE: usize = 8;
pub const IN_FLIGHT: usize = 2;

/// Moves the vertices.
const DEFORM: &str = "
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
const DRAW: &str = "
    @group(0) @binding(0) var<storage, read_write> picture: array<f32>;
    @group(0) @binding(1) var distances: texture_2d<f32>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        let col = id.x % 48u;
        let row = id.x / 48u;
        if (row >= 40u) { return; }
        picture[id.x] = textureLoad(distances, vec2<u32>(col, row), 0).r;
    }";

/// Returns the access by which drawing reads maps and vertices.
pub fn read() -> Access {
    Access::COMPUTE_READ.and(Access::TRANSFER_READ)
}
const LEVELS: [f32; 5] = [3.0, 6.5, 10.0, 15.0, 24.0];
const ROOM: u32 = 8192;

/// Mode in which queue families access the resources of both queues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// One queue, and one command buffer per frame. Contours are found only with two queues.
    OneQueue,
    /// Images and the host's buffers are created for both families.
    Shared,
    /// Images and buffers belong to one family at a time.
    HandedOver,
}

pub struct Renderer {
    way: Way,
    /// Family of the main queue, and family of the other queue.
    families: [u32; 2],
    pub host: Host,
    solver: embed::Solver,
    surface: embed::FrameSurface,
    plan: embed::Plan,
    pub frames: Vec<InFlight>,
}

/// Resources of one frame in flight. Frames in flight share none, so fences alone separate frames.
pub struct InFlight {
    pub phase: HostBuffer,
    vertices: HostBuffer,
    deform: HostPass,
    contours: Contours,
    draw: HostPass,
    /// Data that the main queue has read: the map, the vertices and the contours.
    picture: HostBuffer,
    copy: HostBuffer,
    lines: HostBuffer,
    /// Command buffers for the main queue, the other queue, and the main queue again.
    commands: [vk::CommandBuffer; 3],
    semaphores: [vk::Semaphore; 2],
    pub fence: vk::Fence,
}

impl Renderer {
    pub fn new(mut host: Host, way: Way, families: [u32; 2]) -> Self {
        let device = host.device.clone();
        let shared = if way == Way::Shared { &families[..] } else { &[] };
        // This library accepts equal families; Vulkan does not.
        let apart = if families[0] == families[1] { &[] } else { shared };
        let bytes = 4 * (STRIDE * CHART.points()) as u64;
        let vertices: [_; IN_FLIGHT] =
            std::array::from_fn(|_| host.shared_buffer(bytes, false, apart));
        let points =
            [0, 1].map(|k: usize| Points::positions(vertices[k].handle, 4 * STRIDE as u64));
        let passes = [(Schedule::Raster, Wavefront::Curved)];
        let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &passes);
        let solver = solver.unwrap();
        let info = SurfaceInfo::new(CHART)
            .with_slots(IN_FLIGHT)
            .with_points(&points)
            .with_queue_families(shared);
        let surface = solver.surface(&device, host.allocator(), &info).unwrap();
        let method = Method::new(Wavefront::Curved, STOP);
        let plan = solver.plan(CHART, method, 8).unwrap();
        let frames = vertices.into_iter().enumerate().map(|(slot, vertices)| {
            let phase = host.buffer_of(&[0.0]);
            let deform = host.pass(DEFORM, &[phase.handle, vertices.handle], None);
            let allocator = host.allocator();
            let contours = solver.contours(&device, allocator, &surface, ROOM).unwrap();
            let picture = host.buffer(4 * CHART.points() as u64, true);
            let copy = host.buffer(bytes, true);
            let lines = host.buffer(bytes_of(&contours), true);
            let image = surface.result(slot, Reader::OTHER_QUEUE.layout).unwrap();
            let draw = host.pass(DRAW, &[picture.handle], Some(image.view));
            let pools = [host.pool, host.compute.pool, host.pool];
            let commands = pools.map(|pool| host.commands_from(pool));
            let signaled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
            let (fence, semaphores) = unsafe {
                let semaphore = || device.create_semaphore(&Default::default(), None).unwrap();
                (device.create_fence(&signaled, None).unwrap(), [semaphore(), semaphore()])
            };
            InFlight {
                phase,
                vertices,
                deform,
                contours,
                draw,
                picture,
                copy,
                lines,
                commands,
                semaphores,
                fence,
            }
        });
        let frames = frames.collect();
        Self { way, families, host, solver, surface, plan, frames }
    }

    /// Prepares the surface on the main queue. With two queues, the first map does.
    fn prepare(&self) {
        let Self { host, solver, surface, .. } = self;
        if self.way == Way::OneQueue {
            host.run(|commands| solver.record(&host.device, commands, surface).prepare());
        }
    }

    fn distances(&self, slot: usize) -> ResultImage {
        self.surface.result(slot, Reader::OTHER_QUEUE.layout).unwrap()
    }

    /// Records for the main queue: moves the vertices.
    pub fn deform(&self, commands: vk::CommandBuffer, slot: usize) {
        let InFlight { deform, vertices, .. } = &self.frames[slot];
        self.host.dispatch(commands, deform, groups());
        if self.way == Way::HandedOver {
            let (device, families) = (&self.host.device, self.families);
            let (written, buffers) = (Access::COMPUTE_WRITE, [vertices.handle]);
            handover::hand_over(device, commands, true, written, families, [], buffers);
        }
    }

    /// Records a frame of one queue: moves the vertices, computes the map and draws it.
    fn record(&self, commands: vk::CommandBuffer, number: usize, slot: usize, reader: Reader) {
        // The recording no longer uses the vertices, but the host's own copy of them still does.
        self.host.barrier(commands, Access::TRANSFER_READ, Access::COMPUTE_WRITE);
        self.deform(commands, slot);
        self.frame(commands, number, slot, (Access::COMPUTE_WRITE, reader));
        self.draw(commands, slot);
    }

    /// Records for the other queue: computes the map.
    pub fn map(&self, commands: vk::CommandBuffer, number: usize, slot: usize) {
        if number == 0 {
            self.solver.record(&self.host.device, commands, &self.surface).prepare();
        }
        if self.way == Way::HandedOver {
            let (device, families) = (&self.host.device, self.families);
            let (read, buffers) = (Access::COMPUTE_READ, [self.frames[slot].vertices.handle]);
            handover::hand_over(device, commands, false, read, families, [], buffers);
        }
        self.frame(commands, number, slot, (Access::NONE, Reader::OTHER_QUEUE));
    }

    fn frame(
        &self,
        commands: vk::CommandBuffer,
        number: usize,
        slot: usize,
        (before, reader): (Access, Reader),
    ) {
        let (row, col) = place(number);
        let places = [PointSource::at(row, col)];
        let frame = Frame::new(&self.plan, SourceInput::Inline(&places), reader)
            .with_before(before)
            .with_points(slot)
            .with_slot(slot);
        let recording = self.solver.record(&self.host.device, commands, &self.surface);
        assert_eq!(recording.frame(&frame).unwrap(), self.distances(slot));
    }

    /// Records for the other queue, after the map: finds its contours, and transfers everything to the main
    /// queue's family.
    pub fn contour(&self, commands: vk::CommandBuffer, slot: usize) {
        let Self { way, host, solver, surface, .. } = self;
        let InFlight { vertices, contours, .. } = &self.frames[slot];
        let (device, [main, other]) = (&host.device, self.families);
        let levels = LevelInput::List(&LEVELS);
        let frame = ContourFrame::new(levels, Access::NONE).with_points(slot);
        let recording = solver.record(device, commands, surface);
        let lines = recording.contours(contours, &frame).unwrap().buffer;
        let (written, families) = (Access::COMPUTE_WRITE, [other, main]);
        if *way == Way::HandedOver {
            let (images, buffers) = ([self.distances(slot)], [lines, vertices.handle]);
            handover::hand_over(device, commands, true, written, families, images, buffers);
        } else {
            handover::hand_over(device, commands, true, written, families, [], [lines]);
        }
    }

    /// Records for the main queue: reads the map, the vertices and the contours.
    pub fn draw(&self, commands: vk::CommandBuffer, slot: usize) {
        let InFlight { vertices, contours, draw, copy, lines, .. } = &self.frames[slot];
        let (device, [main, other]) = (&self.host.device, self.families);
        let (families, contours_bytes) = ([other, main], bytes_of(contours));
        let (contours, images) = (contours.curves().buffer, [self.distances(slot)]);
        let hand_over = handover::hand_over::<0, 1>;
        match self.way {
            Way::OneQueue => {}
            Way::Shared => hand_over(device, commands, false, read(), families, [], [contours]),
            Way::HandedOver => {
                let buffers = [contours, vertices.handle];
                handover::hand_over(device, commands, false, read(), families, images, buffers);
            }
        }
        self.host.dispatch(commands, draw, groups());
        let vertices_bytes = 4 * (STRIDE * CHART.points()) as u64;
        self.host.copy_buffer(commands, vertices.handle, copy, vertices_bytes);
        if self.way != Way::OneQueue {
            self.host.copy_buffer(commands, contours, lines, contours_bytes);
        }
        let written = Access::COMPUTE_WRITE.and(Access::TRANSFER_WRITE);
        self.host.barrier(commands, written, Access::HOST_READ.and(Access::TRANSFER_WRITE));
    }

    fn submit(&self, number: usize, slot: usize) {
        let InFlight { commands, semaphores, fence, .. } = &self.frames[slot];
        let (host, device) = (&self.host, &self.host.device);
        let record = |commands, record: &dyn Fn(vk::CommandBuffer)| {
            host.begin(commands);
            record(commands);
            host.end(commands);
        };
        unsafe { device.reset_fences(&[*fence]) }.unwrap();
        if self.way == Way::OneQueue {
            record(commands[0], &|commands| self.record(commands, number, slot, Reader::COMPUTE));
            return host.submit(commands[0], *fence);
        }
        record(commands[0], &|commands| self.deform(commands, slot));
        record(commands[1], &|commands| {
            self.map(commands, number, slot);
            self.contour(commands, slot);
        });
        record(commands[2], &|commands| self.draw(commands, slot));
        let queues = [host.queue, host.compute.handle];
        handover::submit(device, queues, *commands, *semaphores, read().stages, *fence).unwrap();
    }

    /// Compares the map with the headless solver's and the contours with the CPU's, after the fence.
    fn check(&self, headless: &mut HeadlessSolver, number: usize, slot: usize) {
        let InFlight { contours, picture, copy, lines, .. } = &self.frames[slot];
        let outcome = self.surface.outcome(slot).unwrap();
        assert!(outcome.converged && outcome.iterations <= 8, "{outcome:?}");
        let picture = &picture.floats()[..CHART.points()];
        assert_same(headless, copy.floats(), number, picture);
        if self.way == Way::OneQueue {
            return;
        }
        let (records, vertices) =
            lines.bytes().split_at(contours.curves().vertices_offset as usize);
        let record: CurveRecord =
            bytemuck::pod_read_unaligned(&records[..CurveRecord::BYTES as usize]);
        assert_eq!(record.status(), CurveStatus::Complete);
        let vertices = vertices.chunks_exact(size_of::<CurveVertex>());
        let drawn: Vec<_> = vertices
            .take(record.vertex_count as usize)
            .map(bytemuck::pod_read_unaligned::<CurveVertex>)
            .collect();
        let (row, col) = place(number);
        let sources = Sources::point(row.into(), col.into());
        let apart =
            contours::difference(&map_of(CHART, picture.to_vec()), &sources, &LEVELS, &drawn);
        assert!(apart < contours::SAME, "frame {number}: contours {apart} cells apart");
    }

    pub fn end(self) -> Vec<String> {
        let Self { mut host, mut solver, mut surface, frames, .. } = self;
        let device = host.device.clone();
        unsafe { device.device_wait_idle() }.unwrap();
        for mut frame in frames {
            frame.contours.destroy(&device, host.allocator());
            for buffer in [frame.phase, frame.vertices, frame.picture, frame.copy, frame.lines] {
                host.free(buffer);
            }
            host.destroy_pass(frame.deform);
            host.destroy_pass(frame.draw);
            unsafe {
                for semaphore in frame.semaphores {
                    device.destroy_semaphore(semaphore, None);
                }
                device.destroy_fence(frame.fence, None);
            }
        }
        surface.destroy(&device, host.allocator());
        solver.destroy(&device);
        assert_eq!(host.allocations(), 0);
        host.messages()
    }
}

fn groups() -> u32 {
    CHART.points().div_ceil(64) as u32
}

fn bytes_of(contours: &Contours) -> u64 {
    contours.curves().vertices_offset + u64::from(ROOM * CurveVertex::BYTES)
}

/// Returns the source of a frame. It moves over the grid, and is between grid points in two of four frames.
fn place(number: usize) -> (f32, f32) {
    let turn = 0.1 * number as f32;
    let (row, col) = (19.5 + 15.0 * turn.sin(), 23.5 + 18.0 * (0.7 * turn).cos());
    if number % 4 < 2 { (row.round(), col.round()) } else { (row, col) }
}

/// Asserts that the picture equals the headless solver's map of the same vertices, within 1e-5 of the largest
/// distance. The sources are grid points and places between them.
fn assert_same(headless: &mut HeadlessSolver, vertices: &[f32], number: usize, picture: &[f32]) {
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

/// Draws with two frames in flight, and compares some of them. With two queues, the second one computes a frame's map
/// while the main queue draws the frame before.
pub fn draw_frames(way: Way, frames: usize) {
    let host = Host::new();
    let main = host::family(&host.instance, host.physical_device);
    let families = [main, if way == Way::OneQueue { main } else { host.compute.family }];
    let one = host.queue == host.compute.handle;
    println!("{way:?}: main queue and the other of families {families:?}, one and the same: {one}");
    let mut renderer = Renderer::new(host, way, families);
    let device = renderer.host.device.clone();
    renderer.prepare();
    let mut headless = vulkan_solver();
    for number in 0..frames + IN_FLIGHT {
        let slot = number % IN_FLIGHT;
        let fences = [renderer.frames[slot].fence];
        unsafe { device.wait_for_fences(&fences, true, u64::MAX) }.unwrap();
        if number >= IN_FLIGHT && number % 20 < 12 {
            renderer.check(&mut headless, number - IN_FLIGHT, slot);
        }
        if number < frames {
            renderer.frames[slot].phase.floats_mut()[0] = 0.05 * number as f32;
            renderer.submit(number, slot);
        }
    }
    assert_eq!(renderer.end(), Vec::<String>::new());
}

#[test]
fn a_deforming_surface_is_drawn_without_a_message() {
    draw_frames(Way::OneQueue, 100);
}

/// Returns the messages for two frames in one command buffer, since older layers do not check across
/// submissions.
fn messages_of_two_frames(reader: Reader) -> Vec<String> {
    let host = Host::new();
    let main = host::family(&host.instance, host.physical_device);
    let renderer = Renderer::new(host, Way::OneQueue, [main; 2]);
    renderer.prepare();
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
