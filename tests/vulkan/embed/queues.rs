//! Maps from a queue for compute beside the main queue, which moves vertices and draws maps. Semaphores order the work
//! of the queues. The queue families share the resources of both queues, or transfer their ownership.
//!
//! On a device with a single family, the tests use two queues of that family, or a single queue. Semaphores are needed
//! between two queues there too, and barriers between equal families transfer nothing.

use geosweep::ash::vk;
use geosweep::vulkan::embed::{
    self, Access, ContourFrame, Contours, CurveRecord, CurveStatus, CurveVertex, Frame, LevelInput,
    PointSource, Points, Reader, ResultImage, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{HeadlessSolver, Method};
use geosweep::{DeviceChoice, Sources, Wavefront};

use crate::embed::curves::contours::{SAME, difference};
use crate::embed::curves::map_of;
use crate::embed::frames::{CHART, DEFORM, DRAW, IN_FLIGHT, PASSES, STRIDE, assert_same, place};
use crate::embed::stage::STOP;
use crate::host::{self, Host, HostBuffer, HostPass};

pub mod handover {
    // docs/async-compute.md contains this file.
    include!("handover.rs");
}

const FRAMES: usize = 12;
/// Returns the access by which maps and vertices are read where they are drawn.
fn read() -> Access {
    Access::COMPUTE_READ.and(Access::TRANSFER_READ)
}
const LEVELS: [f32; 5] = [3.0, 6.5, 10.0, 15.0, 24.0];
const ROOM: u32 = 8192;

/// The way in which queue families access the resources of both queues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
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
    frames: Vec<InFlight>,
}

/// Resources of one frame in flight. Frames in flight share none, so that fences alone keep frames apart.
struct InFlight {
    phase: HostBuffer,
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
    fence: vk::Fence,
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
        let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &PASSES);
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

    /// Records for the other queue: computes the map.
    pub fn map(&self, commands: vk::CommandBuffer, number: usize, slot: usize) {
        let Self { way, host, solver, surface, plan, .. } = self;
        let InFlight { vertices, .. } = &self.frames[slot];
        let (device, families) = (&host.device, self.families);
        let recording = solver.record(device, commands, surface);
        if number == 0 {
            recording.prepare();
        }
        if *way == Way::HandedOver {
            let (read, buffers) = (Access::COMPUTE_READ, [vertices.handle]);
            handover::hand_over(device, commands, false, read, families, [], buffers);
        }
        let (row, col) = place(number);
        let places = [PointSource::at(row, col)];
        let frame = Frame::new(plan, SourceInput::Inline(&places), Reader::OTHER_QUEUE)
            .with_points(slot)
            .with_slot(slot);
        let distances = recording.frame(&frame).unwrap();
        assert_eq!(distances, self.distances(slot));
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
        if self.way == Way::HandedOver {
            let buffers = [contours, vertices.handle];
            handover::hand_over(device, commands, false, read(), families, images, buffers);
        } else {
            handover::hand_over(device, commands, false, read(), families, [], [contours]);
        }
        self.host.dispatch(commands, draw, groups());
        let vertices_bytes = 4 * (STRIDE * CHART.points()) as u64;
        for (from, to, bytes) in [
            (vertices.handle, copy.handle, vertices_bytes),
            (contours, lines.handle, contours_bytes),
        ] {
            let all = [vk::BufferCopy::default().size(bytes)];
            unsafe { device.cmd_copy_buffer(commands, from, to, &all) };
        }
        let written = Access::COMPUTE_WRITE.and(Access::TRANSFER_WRITE);
        self.host.barrier(commands, written, Access::HOST_READ);
    }

    fn submit(&self, number: usize, slot: usize) {
        let InFlight { commands, semaphores, fence, .. } = &self.frames[slot];
        let (host, device) = (&self.host, &self.host.device);
        let record = |commands, record: &dyn Fn(vk::CommandBuffer)| {
            host.begin(commands);
            record(commands);
            host.end(commands);
        };
        record(commands[0], &|commands| self.deform(commands, slot));
        record(commands[1], &|commands| {
            self.map(commands, number, slot);
            self.contour(commands, slot);
        });
        record(commands[2], &|commands| self.draw(commands, slot));
        unsafe { device.reset_fences(&[*fence]) }.unwrap();
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
        let apart = difference(&map_of(CHART, picture.to_vec()), &sources, &LEVELS, &drawn);
        assert!(apart < SAME, "frame {number}: contours {apart} cells apart");
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

/// Draws with two frames in flight: while the main queue draws one, the other queue computes the next.
fn draw_frames(way: Way) {
    let host = Host::new();
    let families = [host::family(&host.instance, host.physical_device), host.compute.family];
    let one = host.queue == host.compute.handle;
    println!("{way:?}: main queue and the other of families {families:?}, one and the same: {one}");
    let mut renderer = Renderer::new(host, way, families);
    let device = renderer.host.device.clone();
    let mut headless = HeadlessSolver::new(&DeviceChoice::Any).unwrap();
    for number in 0..FRAMES + IN_FLIGHT {
        let slot = number % IN_FLIGHT;
        let fences = [renderer.frames[slot].fence];
        unsafe { device.wait_for_fences(&fences, true, u64::MAX) }.unwrap();
        if number >= IN_FLIGHT {
            renderer.check(&mut headless, number - IN_FLIGHT, slot);
        }
        if number < FRAMES {
            renderer.frames[slot].phase.floats_mut()[0] = 0.3 * number as f32;
            renderer.submit(number, slot);
        }
    }
    assert_eq!(renderer.end(), Vec::<String>::new());
}

#[test]
fn maps_of_another_queue_are_drawn_when_families_share_images() {
    draw_frames(Way::Shared);
}

#[test]
fn maps_of_another_queue_are_drawn_when_images_are_handed_over() {
    draw_frames(Way::HandedOver);
}

/// Returns the messages for two frames in one command buffer, since older layers do not check across
/// submissions. Barriers replace the semaphores: the stages that wait for a semaphore wait for all earlier commands.
/// Unless `waits` is set, the wait before drawing is left out. Contours are then left out too, since their own barriers
/// would suffice.
fn messages_of_one_queue(way: Way, waits: bool) -> Vec<String> {
    let host = Host::new();
    let main = host::family(&host.instance, host.physical_device);
    let renderer = Renderer::new(host, way, [main; 2]);
    let all = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
    let done = Access::new(vk::PipelineStageFlags::ALL_COMMANDS, vk::AccessFlags::MEMORY_WRITE);
    renderer.host.run(|commands| {
        let semaphore = |stages| renderer.host.barrier(commands, done, Access::new(stages, all));
        for slot in 0..IN_FLIGHT {
            renderer.deform(commands, slot);
            semaphore(vk::PipelineStageFlags::COMPUTE_SHADER);
            renderer.map(commands, slot, slot);
            if waits {
                renderer.contour(commands, slot);
                semaphore(read().stages);
            }
            renderer.draw(commands, slot);
        }
    });
    renderer.end()
}

#[test]
fn the_stages_that_wait_for_semaphores_are_enough() {
    for way in [Way::Shared, Way::HandedOver] {
        assert_eq!(messages_of_one_queue(way, true), Vec::<String>::new(), "{way:?}");
    }
}

/// A hazard must be reported, or a clean log would prove nothing.
#[test]
fn a_semaphore_left_out_is_reported() {
    let messages = messages_of_one_queue(Way::Shared, false);
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD-READ-AFTER-WRITE")), "{messages:?}");
}

#[test]
fn the_guide_shows_the_code_that_runs() {
    let guide = include_str!("../../../docs/async-compute.md");
    let copy = include_str!("handover.rs");
    assert!(guide.contains(copy), "copy tests/vulkan/embed/handover.rs into docs/async-compute.md");
}
