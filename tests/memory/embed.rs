//! Recording a frame allocates nothing on the heap, and calls no function of the device except commands.

use std::sync::atomic::{AtomicU32, Ordering};

use geosweep::Stop;
use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Access, ContourFrame, DirectionFrame, Frame, LevelInput, LogMapFrame, Lookup, MapLimit,
    PathFrame, PathsInfo, PointSource, Points, Reader, RegionFrame, SourceBuffer, SourceInput,
    StartInput, SurfaceFrame, SurfaceInfo, TargetPoint,
};
use geosweep::vulkan::profile::{Grain, Profile, Slots};
use geosweep::vulkan::{Method, Schedule};

use crate::ALONE;
use crate::heap::allocations;
use crate::host::Host;

static DEVICE_CALLS: AtomicU32 = AtomicU32::new(0);

/// Replaces every function of the device except commands.
extern "system" fn counted() -> vk::Result {
    DEVICE_CALLS.fetch_add(1, Ordering::Relaxed);
    vk::Result::ERROR_DEVICE_LOST
}

#[test]
fn recording_a_frame_allocates_nothing_and_calls_nothing_but_commands() {
    let _alone = ALONE.lock();
    let mut host = Host::without_validation();
    let device = host.device.clone();
    let chart = Chart { rows: 40, cols: 48 };
    let positions: Vec<f32> = (0..chart.points())
        .flat_map(|index| {
            let (row, col) = chart.position(index);
            [col as f32, row as f32, (0.2 * col as f32).sin()]
        })
        .collect();
    let points = host.buffer_of(&positions);
    let sources = host.buffer_of(bytemuck::cast_slice(&[PointSource::at(3.0, 4.5); 300]));
    let places = host.buffer_of(&[1.0, 2.0, 30.5, 20.25]);
    let found = host.buffer(8, true);
    let lookup = Lookup {
        places: places.handle,
        places_offset: 0,
        distances: found.handle,
        distances_offset: 0,
        count: 2,
    };
    let passes = Schedule::ALL.map(|schedule| (schedule, Wavefront::Curved));
    let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &passes);
    let mut solver = solver.unwrap();
    let lookup_buffers = [lookup];
    let source_buffers = [SourceBuffer { buffer: sources.handle, offset: 0, count: 300 }];
    let inputs = [Points::positions(points.handle, 12)];
    let info = SurfaceInfo::new(chart)
        .with_slots(2)
        .with_points(&inputs)
        .with_sources(&source_buffers)
        .with_lookups(&lookup_buffers);
    let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
    let allocator = host.allocator();
    let mut contours = solver.contours(&device, allocator, &surface, 1000).unwrap();
    let info = PathsInfo::new(3, 600);
    let mut paths = solver.paths(&device, allocator, &surface, info).unwrap();
    let regions = solver.regions(&device, allocator, &surface, Wavefront::Curved);
    let mut regions = regions.unwrap();
    let mut directions = solver.directions(&device, allocator, &surface).unwrap();
    let mut log_map = solver.log_map(&device, allocator, &surface).unwrap();
    host.run(|commands| solver.record(&device, commands, &surface).prepare());

    // With this device, only commands reach the real one.
    let recording_device =
        host.device_with(|name| (!name.to_bytes().starts_with(b"vkCmd")).then_some(counted as _));
    let inline: Vec<_> = (0..100).map(|i| PointSource::at(i as f32 / 3.0, 7.0)).collect();
    for (schedule, wavefront) in passes {
        let stop = Stop::within(1e-4).or_after(100);
        let method = Method::new(wavefront, stop).with_schedule(schedule);
        let plan = solver.plan(chart, method, 4).unwrap();
        let profile = Profile::new(1000, Grain::Blocks, Slots::default());
        for number in 0..50 {
            let inputs = [SourceInput::Inline(&inline), SourceInput::Buffer(0)];
            let commands = host.commands();
            host.begin(commands);
            let targets = [TargetPoint::at(number as u32 % 40, 11), TargetPoint::at(7, 3)];
            let limit = MapLimit::to(&targets[..number % 3]).with_radius(1.0 + number as f32);
            let before = allocations();
            let recording = solver.record(&recording_device, commands, &surface);
            let watched = number % 5 == 0;
            let recording = if watched { recording.profiled(&profile).unwrap() } else { recording };
            recording
                .frame(
                    &Frame::new(&plan, inputs[number % 2], Reader::COMPUTE)
                        .with_before(Access::COMPUTE_WRITE)
                        .with_points(0)
                        .with_slot(number % 2)
                        .with_limit(limit)
                        .with_unreached(-1.0),
                )
                .unwrap();
            let frame = Frame::new(&plan, inputs[number % 2], Reader::COMPUTE)
                .with_points(0)
                .with_slot(number % 2)
                .with_limit(limit)
                .with_unreached(-1.0);
            let frames = [SurfaceFrame::new(&surface, frame)];
            solver.record_frames(&recording_device, commands, &frames).unwrap();
            recording.resume(&plan).unwrap();
            recording.add(inputs[1 - number % 2], &plan).unwrap();
            recording.outcome(number % 2).unwrap();
            recording.lookup(0, -1.0, Access::NONE, Access::HOST_READ).unwrap();
            let levels = [
                LevelInput::List(&[1.0, 2.0, 30.0]),
                LevelInput::Spacing { step: 0.5, count: 1000 },
            ];
            let levels = levels[number % 2];
            let frame = ContourFrame::new(levels, Access::DRAW);
            recording.contours(&contours, &frame).unwrap();
            let frame = PathFrame::new(
                StartInput::Inline(&[[1.0, 2.0], [30.0, 20.5]]),
                inputs[1 - number % 2],
                Access::DRAW,
            );
            recording.paths(&paths, &frame).unwrap();
            let frame = RegionFrame::new(inputs[1 - number % 2], Access::VERTEX_READ);
            recording.regions(&regions, &frame).unwrap();
            let frame = DirectionFrame::new(inputs[1 - number % 2], Reader::COMPUTE);
            recording.directions(&directions, &frame).unwrap();
            let frame = LogMapFrame::new(inputs[1 - number % 2], Reader::COMPUTE);
            recording.log_map(&log_map, &frame).unwrap();
            recording.end(Access::TRANSFER_READ);
            assert_eq!(allocations() - before, 0, "{schedule}, frame {number}");
            assert_eq!(DEVICE_CALLS.load(Ordering::Relaxed), 0, "{schedule}, frame {number}");
            host.end(commands);
            host.submit(commands, vk::Fence::null());
            unsafe { device.queue_wait_idle(host.queue) }.unwrap();
        }
    }

    // The counters work.
    let before = allocations();
    drop(std::hint::black_box(vec![1u8; 100]));
    assert_eq!(allocations() - before, 1);
    let none = unsafe { recording_device.create_fence(&vk::FenceCreateInfo::default(), None) };
    assert_eq!(none, Err(vk::Result::ERROR_DEVICE_LOST));
    assert_eq!(DEVICE_CALLS.load(Ordering::Relaxed), 1);

    contours.destroy(&device, host.allocator());
    paths.destroy(&device, host.allocator());
    regions.destroy(&device, host.allocator());
    directions.destroy(&device, host.allocator());
    log_map.destroy(&device, host.allocator());
    surface.destroy(&device, host.allocator());
    solver.destroy(&device);
    [points, sources, places, found].into_iter().for_each(|buffer| host.free(buffer));
    assert_eq!(host.allocations(), 0);
}
