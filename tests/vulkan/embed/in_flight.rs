//! Reports about recordings that have not run: outcomes, slots and preparations, and with checks every recording.

use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::vulkan::embed::{
    self, Access, ContourFrame, LevelInput, Lookup, Outcome, PathFrame, PathsInfo, Points, Reader,
    Recording, RegionFrame, SourceInput, StartInput, SurfaceInfo, Tools,
};
use geosweep::vulkan::profile::{Grain, Profile, Slots};
use geosweep::vulkan::{Schedule, VulkanError};

use crate::embed::misuse::{CHART, frame, stage};
use crate::embed::stage::{Kept, RASTER, Stage, source, vertices};
use crate::host::{Host, HostBuffer};

#[test]
fn an_outcome_before_the_fence_is_absent() {
    let stage = stage(2);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 8);
    let sources = source(3.0, 4.0);
    let not_run = |slot| {
        let asked = stage.surface.outcome(slot);
        assert!(matches!(asked, Err(VulkanError::NotRun { slot: of }) if of == slot), "{asked:?}");
    };
    not_run(0);
    for _ in 0..2 {
        // This recording is not submitted yet, so its outcome is absent, even after an earlier frame has run.
        let commands = stage.host.commands();
        stage.host.begin(commands);
        let recording = stage.solver.record(&stage.host.device, commands, &stage.surface);
        recording.frame(&frame(&plan, &sources)).unwrap();
        stage.host.end(commands);
        not_run(0);
        not_run(1);
        assert_eq!(stage.surface.in_flight(), Some(0));
        stage.host.submit(commands, vk::Fence::null());
        unsafe { stage.host.device.device_wait_idle() }.unwrap();
        assert_eq!(stage.surface.in_flight(), None);
        let outcome = stage.surface.outcome(0).unwrap();
        assert!(outcome.converged && outcome.measured, "{outcome:?}");
        assert_eq!((outcome.holes, outcome.passed_over), (0, 0));
    }
    // A recording that is discarded.
    stage.attempt(|r| r.frame(&frame(&plan, &sources).with_slot(1)).map(drop)).unwrap();
    assert_eq!(stage.surface.in_flight(), Some(1));
    stage.surface.discard(1).unwrap();
    assert_eq!(stage.surface.in_flight(), None);
    assert!(stage.surface.discard(2).is_err());
    stage.end([]);
}

/// The error requires checks and several slots. With one slot, the device waits for the earlier reader.
#[test]
fn a_slot_in_flight_is_not_recorded_again() {
    let mut host = Host::new();
    let device = host.device.clone();
    let points = host.buffer_of(&vertices(CHART, 0.3));
    let inputs = [Points::positions(points.handle, 32)];
    let (instance, physical) = (host.instance.clone(), host.physical_device);
    for (checks, slots) in [(true, 2), (true, 1), (false, 2)] {
        let tools = Tools { checks, ..Tools::default() };
        let mut solver =
            embed::Solver::with_tools(&instance, physical, &device, &RASTER[..1], tools).unwrap();
        let info = SurfaceInfo::new(CHART).with_slots(slots).with_points(&inputs);
        let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
        let method = geosweep::vulkan::Method::new(Wavefront::Planar, crate::embed::stage::STOP);
        let plan = solver.plan(CHART, method, 4).unwrap();
        let sources = source(3.0, 4.0);
        let frame = frame(&plan, &sources);
        let buffers = [(); 2].map(|()| host.commands());
        let record = |commands, do_it: &dyn Fn(Recording) -> Result<(), VulkanError>| {
            host.begin(commands);
            let done = do_it(solver.record(&device, commands, &surface));
            host.end(commands);
            done
        };
        record(buffers[0], &|r| {
            r.prepare();
            r.frame(&frame).map(drop)
        })
        .unwrap();
        // A recording that continues the same map may use the same slot.
        record(buffers[1], &|r| {
            r.begin(Access::NONE);
            r.resume(&plan).and(r.outcome(0))
        })
        .unwrap();
        host.submit(buffers[0], vk::Fence::null());
        host.submit(buffers[1], vk::Fence::null());
        unsafe { device.device_wait_idle() }.unwrap();
        record(buffers[0], &|r| r.frame(&frame).map(drop)).unwrap();
        let again = record(buffers[1], &|r| r.frame(&frame).map(drop));
        match checks && slots > 1 {
            true => assert!(matches!(again, Err(VulkanError::InFlight { slot: 0 })), "{again:?}"),
            false => again.unwrap(),
        }
        if slots > 1 {
            record(buffers[1], &|r| r.frame(&frame.with_slot(1)).map(drop)).unwrap();
        }
        surface.destroy(&device, host.allocator());
        solver.destroy(&device);
    }
    host.free(points);
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

/// Two frames in flight would write the same queries and entries of one profile. The error requires checks.
#[test]
fn a_profile_in_flight_is_not_used_by_another_recording() {
    let mut host = Host::new();
    let device = host.device.clone();
    let points = host.buffer_of(&vertices(CHART, 0.3));
    let inputs = [Points::positions(points.handle, 32)];
    let (instance, physical) = (host.instance.clone(), host.physical_device);
    for checks in [true, false] {
        let tools = Tools { checks, ..Tools::default() };
        let mut solver =
            embed::Solver::with_tools(&instance, physical, &device, &RASTER[..1], tools).unwrap();
        let info = SurfaceInfo::new(CHART).with_slots(2).with_points(&inputs);
        let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
        let method = geosweep::vulkan::Method::new(Wavefront::Planar, crate::embed::stage::STOP);
        let plan = solver.plan(CHART, method, 4).unwrap();
        let sources = source(3.0, 4.0);
        let buffers = [(); 2].map(|()| host.commands());
        let profiles = [(); 2].map(|()| Profile::new(100, Grain::Blocks, Slots::default()));
        let record = |slot: usize, profile: &Profile, prepare: bool| {
            let commands = buffers[slot];
            host.begin(commands);
            let recording = solver.record(&device, commands, &surface);
            if prepare {
                recording.prepare();
            }
            let frame = frame(&plan, &sources).with_slot(slot);
            let done = recording.profiled(profile).and_then(|r| r.frame(&frame).map(drop));
            host.end(commands);
            done
        };
        record(0, &profiles[0], true).unwrap();
        let taken = record(1, &profiles[0], false);
        match checks {
            // Another profile serves the second recording.
            true => {
                assert!(matches!(taken, Err(VulkanError::ProfileInFlight)), "{taken:?}");
                record(1, &profiles[1], false).unwrap();
            }
            false => taken.unwrap(),
        }
        for commands in buffers {
            host.submit(commands, vk::Fence::null());
        }
        unsafe { device.device_wait_idle() }.unwrap();
        assert!(profiles.iter().all(|profile| !profile.is_in_flight()));
        record(1, &profiles[0], false).unwrap();
        // Recording a command buffer anew ends its earlier recording, so the profile is free again.
        record(1, &profiles[0], false).unwrap();
        surface.destroy(&device, host.allocator());
        solver.destroy(&device);
    }
    host.free(points);
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

/// The test uses no layers, since they would report images that were never given a layout. Data that an earlier surface
/// has left in the memory do not count as a preparation of the new surface.
#[test]
fn a_preparation_that_never_ran_shows() {
    let (mut stage, points) = {
        let mut host = Kept::unwatched();
        let points = host.buffer_of(&vertices(CHART, 0.3));
        let inputs = [Points::positions(points.handle, 32)];
        let info = SurfaceInfo::new(CHART).with_points(&inputs);
        (Stage::new(host, &RASTER[..1], &info), points)
    };
    let device = stage.host.device.clone();
    let record = stage.host.buffer(80, true);
    let plan = stage.plan(Schedule::Raster, Wavefront::Planar, 8);
    let sources = source(3.0, 4.0);
    let bytes =
        |record: &HostBuffer| *record.bytes()[..].first_chunk::<{ Outcome::BYTES }>().unwrap();
    let whole = |stage: &Stage| {
        stage.submit(|r| {
            r.frame(&frame(&plan, &sources)).unwrap();
            r.outcome_to(record.handle, 0, Access::HOST_READ).unwrap();
        });
    };
    let is_lost = |outcome: Result<Outcome, VulkanError>| match outcome {
        Ok(outcome) => {
            assert!(outcome.converged, "{outcome:?}");
            false
        }
        Err(VulkanError::PreparationLost) => true,
        Err(other) => panic!("{other}"),
    };
    let lost = |stage: &Stage| {
        let copied = is_lost(stage.surface.outcome_from(&bytes(&record)));
        assert_eq!(is_lost(stage.surface.outcome(0)), copied);
        copied
    };
    whole(&stage);
    assert!(!lost(&stage));
    let of_first = bytes(&record);
    // Another surface at the same place in memory.
    stage.surface.destroy(&device, stage.host.allocator());
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(CHART).with_points(&inputs);
    stage.surface = stage.solver.surface(&device, stage.host.allocator(), &info).unwrap();
    stage.attempt(|r| r.prepare());
    whole(&stage);
    assert!(lost(&stage));
    assert!(is_lost(stage.surface.outcome_from(&of_first)));
    stage.submit(|r| r.prepare());
    whole(&stage);
    assert!(!lost(&stage));
    // The second preparation is lost. Images are unchanged, but this cannot be known.
    stage.attempt(|r| r.prepare());
    whole(&stage);
    assert!(lost(&stage));
    stage.end([points, record]);
}

/// With checks, every recording is tracked, with or without an outcome.
#[test]
fn every_recording_is_followed_with_checks() {
    let mut host = Host::with_synchronization_validation();
    let device = host.device.clone();
    let points = host.buffer_of(&vertices(CHART, 0.3));
    let (places, to) = (host.buffer_of(&[1.0, 2.0]), host.buffer(80, true));
    let inputs = [Points::positions(points.handle, 32)];
    let (place, distance) = (places.handle, to.handle);
    let lookup = Lookup {
        places: place,
        places_offset: 0,
        distances: distance,
        distances_offset: 0,
        count: 1,
    };
    let lookup_buffers = [lookup];
    let info =
        SurfaceInfo::new(CHART).with_slots(2).with_points(&inputs).with_lookups(&lookup_buffers);
    let tools = Tools { checks: true, ..Tools::default() };
    let (instance, physical) = (host.instance.clone(), host.physical_device);
    let passes = &RASTER[2..];
    let mut solver =
        embed::Solver::with_tools(&instance, physical, &device, passes, tools).unwrap();
    let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
    let room = PathsInfo::new(1, 50);
    let mut contours = solver.contours(&device, host.allocator(), &surface, 100).unwrap();
    let mut paths = solver.paths(&device, host.allocator(), &surface, room).unwrap();
    let curved = Wavefront::Curved;
    let mut regions = solver.regions(&device, host.allocator(), &surface, curved).unwrap();
    let stop = crate::embed::stage::STOP;
    let plan = solver.plan(CHART, geosweep::vulkan::Method::new(curved, stop), 4);
    let plan = plan.unwrap();
    let sources = source(3.0, 4.0);
    let inline = SourceInput::Inline(&sources);
    let (none, read) = (Access::NONE, Access::TRANSFER_READ);
    let levels = LevelInput::Spacing { step: 1.0, count: 3 };
    let contour_frame = ContourFrame::new(levels, read);
    let starts = StartInput::Inline(&[[9.0, 9.0]]);
    let path_frame = PathFrame::new(starts, inline, read).with_before(none);
    let region_frame = RegionFrame::new(inline, read).with_before(none);
    type Step<'a> = (&'a str, &'a dyn Fn(Recording) -> Result<(), VulkanError>);
    let steps: [Step; 12] = [
        ("prepare", &|r| {
            r.prepare();
            Ok(())
        }),
        ("measure", &|r| r.measure(0)),
        ("solve", &|r| r.solve(inline, &plan)),
        ("resume", &|r| r.resume(&plan)),
        ("add", &|r| r.add(inline, &plan)),
        ("outcome", &|r| r.outcome(1)),
        ("outcome_to", &|r| r.outcome_to(to.handle, 0, none)),
        ("result", &|r| r.result(0, Reader::COPY, 1.0).map(drop)),
        ("lookup", &|r| r.lookup(0, 1.0, none, none)),
        ("contours", &|r| r.contours(&contours, &contour_frame).map(drop)),
        ("paths", &|r| r.paths(&paths, &path_frame).map(drop)),
        ("regions", &|r| r.regions(&regions, &region_frame).map(drop)),
    ];
    let seen = |name: &str, waits: bool| {
        assert_eq!(surface.is_in_flight(), waits, "{name}");
        let reads_points = ["measure", "contours", "paths"].contains(&name);
        assert_eq!(surface.points_in_flight(0).unwrap(), waits && reads_points, "{name}");
        assert_eq!(contours.is_in_flight(), waits && name == "contours", "{name}");
        assert_eq!(paths.is_in_flight(), waits && name == "paths", "{name}");
        assert_eq!(regions.is_in_flight(), waits && name == "regions", "{name}");
    };
    for (name, step) in steps {
        let thrown = [(); 2].map(|()| host.commands());
        host.begin(thrown[0]);
        step(solver.record(&device, thrown[0], &surface)).unwrap();
        seen(name, true);
        surface.discard_commands(thrown[1]);
        seen(name, true);
        surface.discard_commands(thrown[0]);
        seen(name, false);
        host.end(thrown[0]);
        let commands = host.commands();
        host.begin(commands);
        let recording = solver.record(&device, commands, &surface);
        recording.begin(none);
        step(recording).unwrap();
        host.end(commands);
        seen(name, true);
        host.submit(commands, vk::Fence::null());
        unsafe { device.device_wait_idle() }.unwrap();
        seen(name, false);
    }
    let allocator = host.allocator();
    contours.destroy(&device, allocator);
    paths.destroy(&device, allocator);
    regions.destroy(&device, allocator);
    surface.destroy(&device, allocator);
    assert!(!contours.is_in_flight() && !surface.is_in_flight());
    solver.destroy(&device);
    [points, places, to].into_iter().for_each(|buffer| host.free(buffer));
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}
