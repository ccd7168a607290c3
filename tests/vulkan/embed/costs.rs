//! Costs of frames by count: recorded commands, and bytes that their passes have moved.

use std::ffi::CStr;
use std::fmt::Write;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use geosweep::ash::{self, vk};
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Frame, PointSource, Points, Reader, Recording, SourceInput, SurfaceFrame, SurfaceInfo,
};
use geosweep::vulkan::profile::{Decided, Grain, Profile, Slots};
use geosweep::vulkan::{Method, Schedule, VulkanError};
use geosweep::{Stop, Wavefront};

use crate::embed::capture::compare_with_guide;
use crate::embed::stage::vertices;
use crate::host::Host;

static DISPATCHES: AtomicU32 = AtomicU32::new(0);
static BARRIERS: AtomicU32 = AtomicU32::new(0);
static CLEARS_AND_COPIES: AtomicU32 = AtomicU32::new(0);
static OTHERS: AtomicU32 = AtomicU32::new(0);

fn count(counter: &AtomicU32) -> vk::Result {
    counter.fetch_add(1, Ordering::Relaxed);
    vk::Result::SUCCESS
}

extern "system" fn dispatch() -> vk::Result {
    count(&DISPATCHES)
}

extern "system" fn barrier() -> vk::Result {
    count(&BARRIERS)
}

extern "system" fn clear_or_copy() -> vk::Result {
    count(&CLEARS_AND_COPIES)
}

/// Replaces all other commands, among them binding and pushing, which cost next to nothing.
extern "system" fn other() -> vk::Result {
    count(&OTHERS)
}

/// Returns a replacement that counts a command and does nothing else.
fn counting(name: &CStr) -> Option<extern "system" fn() -> vk::Result> {
    Some(match name.to_bytes() {
        b"vkCmdDispatch" | b"vkCmdDispatchIndirect" => dispatch,
        b"vkCmdPipelineBarrier" => barrier,
        b"vkCmdFillBuffer"
        | b"vkCmdUpdateBuffer"
        | b"vkCmdCopyBuffer"
        | b"vkCmdClearColorImage" => clear_or_copy,
        b"vkCmdBindPipeline" | b"vkCmdBindDescriptorSets" | b"vkCmdPushConstants" => other,
        name if name.starts_with(b"vkCmd") => unknown,
        _ => return None,
    })
}

extern "system" fn unknown() -> vk::Result {
    panic!("a command that the guide's table has no column for");
}

fn taken(counter: &AtomicU32) -> u32 {
    counter.swap(0, Ordering::Relaxed)
}

/// Lock that makes tests count one at a time.
static COUNTING: Mutex<()> = Mutex::new(());

/// Returns the numbers of recorded dispatches, barriers and other commands.
fn counted(host: &Host, record: impl FnOnce(&ash::Device)) -> [u32; 3] {
    let _alone = COUNTING.lock().unwrap_or_else(PoisonError::into_inner);
    record(&host.device_with(counting));
    let [dispatches, barriers, others, _] =
        [&DISPATCHES, &BARRIERS, &CLEARS_AND_COPIES, &OTHERS].map(taken);
    [dispatches, barriers, others]
}

/// Returns a row of the table, for a frame with new points and a source between grid points.
fn row(host: &mut Host, solver: &embed::Solver, schedule: Schedule, side: usize) -> String {
    let device = host.device.clone();
    let chart = Chart { rows: side, cols: side };
    let points = host.buffer_of(&vertices(chart, 0.4));
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(chart).with_points(&inputs);
    let memory = solver.bytes_for(&device, &info).unwrap();
    let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
    let stop = Stop::within(1e-4).or_after(1000);
    let method = Method::new(Wavefront::Curved, stop).with_schedule(schedule);
    let asked = if schedule == Schedule::Tiles { 64 } else { 4 };
    let plan = solver.plan(chart, method, asked).unwrap();
    let source = [PointSource::at(0.32 * side as f32, 0.48 * side as f32)];
    let frame = |recording: Recording<'_>| -> Result<(), VulkanError> {
        recording.frame(
            &Frame::new(&plan, SourceInput::Inline(&source), Reader::FRAGMENT)
                .with_points(0)
                .with_unreached(-1.0),
        )?;
        Ok(())
    };
    host.run(|commands| solver.record(&device, commands, &surface).prepare());

    let decisions = host.buffer(Slots::DECISION_BYTES, true);
    let decided = Decided { buffer: decisions.handle, offset: 0, portions: 1 };
    let slots = Slots::default().with_decisions(decided);
    let passes = solver.passes_of_frame(&surface, &plan, Grain::Blocks);
    let profile = Profile::new(passes, Grain::Blocks, slots);
    host.run(|commands| {
        frame(solver.record(&device, commands, &surface).profiled(&profile)).unwrap();
    });
    let outcome = surface.outcome(0).unwrap();
    let resolved = profile.resolve(&device, None, Some(decisions.bytes())).unwrap().unwrap();
    assert_eq!(resolved.left_out, 0);
    let moved: Option<u64> = resolved.passes.iter().map(|pass| pass.work.bytes()).sum();
    let moved = moved.expect("all passes of a frame are counted");

    let [dispatches, barriers, others] = counted(host, |device| {
        frame(solver.record(device, vk::CommandBuffer::null(), &surface)).unwrap();
    });
    surface.destroy(&device, host.allocator());
    host.free(points);
    host.free(decisions);
    let megabytes = |bytes: u64| bytes as f64 / 1e6;
    format!(
        "{:11} {:8} {dispatches:>10} {barriers:>8} {others:>6} {:>10} {:>4} {:>8.1} {:>9.1}\n",
        format!("{side} x {side}"),
        schedule.to_string(),
        outcome.iterations,
        if outcome.converged { "yes" } else { "no" },
        megabytes(moved),
        megabytes(memory),
    )
}

/// The guide's table of costs equals the measured costs. If `GEOSWEEP_UPDATE_GUIDE` is set, the test writes
/// the table anew.
#[test]
fn frames_cost_what_the_guide_says() {
    let mut host = Host::without_validation();
    let passes = [Schedule::Raster, Schedule::Tiles].map(|of| (of, Wavefront::Curved));
    let device = host.device.clone();
    let (instance, physical_device) = (host.instance.clone(), host.physical_device);
    let mut solver = embed::Solver::new(&instance, physical_device, &device, &passes).unwrap();
    let mut table = String::new();
    writeln!(
        table,
        "{:11} {:8} {:>10} {:>8} {:>6} {:>10} {:>4} {:>8} {:>9}",
        "points",
        "schedule",
        "dispatches",
        "barriers",
        "others",
        "iterations",
        "done",
        "MB moved",
        "MB in all"
    )
    .unwrap();
    for side in [64, 256, 1024] {
        for schedule in [Schedule::Raster, Schedule::Tiles] {
            table += &row(&mut host, &solver, schedule, side);
        }
    }
    compare_with_guide("costs", &table, host.is_processor());
    solver.destroy(&device);
    assert_eq!(host.allocations(), 0);
}

/// Up to 64 surfaces of one size together need as many barriers as one surface, and 65 surfaces need twice as many.
#[test]
fn frames_recorded_together_share_their_barriers() {
    let mut host = Host::without_validation();
    let device = host.device.clone();
    let schedules = [Schedule::Raster, Schedule::Tiles];
    let passes = schedules.map(|of| (of, Wavefront::Curved));
    let (instance, physical_device) = (host.instance.clone(), host.physical_device);
    let mut solver = embed::Solver::new(&instance, physical_device, &device, &passes).unwrap();
    for (side, counts) in [(64, &[1, 2, 8, 65][..]), (256, &[3])] {
        let chart = Chart { rows: side, cols: side };
        let points = host.buffer_of(&vertices(chart, 0.4));
        let inputs = [Points::positions(points.handle, 32)];
        let info = SurfaceInfo::new(chart).with_points(&inputs);
        let most = counts.iter().copied().max().unwrap();
        let mut surfaces: Vec<_> =
            (0..most).map(|_| solver.surface(&device, host.allocator(), &info).unwrap()).collect();
        for surface in &surfaces {
            host.run(|commands| solver.record(&device, commands, surface).prepare());
        }
        let source = [PointSource::at(0.32 * side as f32, 0.48 * side as f32)];
        for schedule in schedules {
            let stop = Stop::within(1e-4).or_after(1000);
            let method = Method::new(Wavefront::Curved, stop).with_schedule(schedule);
            let plan = solver.plan(chart, method, 4).unwrap();
            let frame = Frame::new(&plan, SourceInput::Inline(&source), Reader::FRAGMENT)
                .with_points(0)
                .with_unreached(-1.0);
            let none = vk::CommandBuffer::null();
            let [dispatches, barriers, others] = counted(&host, |device| {
                solver.record(device, none, &surfaces[0]).frame(&frame).unwrap();
            });
            for &count in counts {
                let frames: Vec<_> = surfaces[..count]
                    .iter()
                    .map(|surface| SurfaceFrame::new(surface, frame))
                    .collect();
                let together = counted(&host, |device| {
                    solver.record_frames(device, none, &frames).unwrap();
                });
                let n = count as u32;
                let shared = n.div_ceil(64);
                assert_eq!(
                    together,
                    [n * dispatches, shared * barriers, n * others],
                    "{count} of {side}, {schedule}"
                );
            }
        }
        surfaces.iter_mut().for_each(|surface| surface.destroy(&device, host.allocator()));
        host.free(points);
    }
    solver.destroy(&device);
    assert_eq!(host.allocations(), 0);
}
