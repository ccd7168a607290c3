//! Commands of frames, counted while they are recorded, and bytes that their passes have moved. docs/frame-costs.md
//! lists the commands of each label of a frame, as a capture tool shows them, and the costs of whole frames.

use std::ffi::{CStr, c_char, c_void};
use std::fmt::Write;
use std::mem::{take, transmute};
use std::sync::{Mutex, OnceLock, PoisonError};

use geosweep::ash::{self, vk};
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Frame, PointSource, Points, Reader, Recording, SourceInput, SurfaceFrame, SurfaceInfo,
    Tools,
};
use geosweep::vulkan::profile::{Decided, Grain, Profile, Slots};
use geosweep::vulkan::{Method, Schedule, VulkanError};
use geosweep::{Stop, Wavefront};

use crate::embed::stage::vertices;
use crate::host::Host;

/// Path of the guide from the package's root, where tests run.
const GUIDE: &str = "docs/frame-costs.md";

/// A label, and the commands between this label and the next one: dispatches, barriers, and others that do something.
#[derive(Clone, Default)]
struct Pass {
    label: String,
    depth: usize,
    counts: [u32; 3],
}

/// Recorded commands by label, and the number of open labels.
static RECORDED: Mutex<(Vec<Pass>, usize)> = Mutex::new((Vec::new(), 0));
/// Names that were given to objects.
static NAMES: Mutex<Vec<String>> = Mutex::new(Vec::new());
/// Lock that makes tests count one at a time.
static COUNTING: Mutex<()> = Mutex::new(());

fn note(kind: usize) -> vk::Result {
    let passes = &mut RECORDED.lock().unwrap().0;
    if passes.is_empty() {
        passes.push(Pass::default());
    }
    passes.last_mut().unwrap().counts[kind] += 1;
    vk::Result::SUCCESS
}

extern "system" fn dispatch() -> vk::Result {
    note(0)
}

extern "system" fn barrier() -> vk::Result {
    note(1)
}

extern "system" fn clear_or_copy() -> vk::Result {
    note(2)
}

/// Replaces binding and pushing, which cost next to nothing.
extern "system" fn free() -> vk::Result {
    vk::Result::SUCCESS
}

extern "system" fn unknown() -> vk::Result {
    panic!("a command that the guide's table has no column for");
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
        b"vkCmdBindPipeline" | b"vkCmdBindDescriptorSets" | b"vkCmdPushConstants" => free,
        name if name.starts_with(b"vkCmd") => unknown,
        _ => return None,
    })
}

unsafe extern "system" fn begin_label(
    _: vk::CommandBuffer,
    label: *const vk::DebugUtilsLabelEXT<'_>,
) {
    let label = unsafe { CStr::from_ptr((*label).p_label_name) }.to_str().unwrap().to_owned();
    let (passes, depth) = &mut *RECORDED.lock().unwrap();
    passes.push(Pass { label, depth: *depth, ..Pass::default() });
    *depth += 1;
}

unsafe extern "system" fn end_label(_: vk::CommandBuffer) {
    RECORDED.lock().unwrap().1 -= 1;
}

unsafe extern "system" fn name_object(
    _: vk::Device,
    info: *const vk::DebugUtilsObjectNameInfoEXT<'_>,
) -> vk::Result {
    let given = unsafe { &*info };
    let text = unsafe { CStr::from_ptr(given.p_object_name) }.to_str().unwrap();
    NAMES.lock().unwrap().push(format!("{:?} {text}", given.object_type));
    vk::Result::SUCCESS
}

/// Function that finds the device's own functions.
static REAL: OnceLock<vk::PFN_vkGetDeviceProcAddr> = OnceLock::new();

/// Returns replacements for the functions of `VK_EXT_debug_utils`, and the device's own functions otherwise.
unsafe extern "system" fn debug_utils(
    device: vk::Device,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    let own = match unsafe { CStr::from_ptr(name) }.to_bytes() {
        b"vkCmdBeginDebugUtilsLabelEXT" => begin_label as *const c_void,
        b"vkCmdEndDebugUtilsLabelEXT" => end_label as *const c_void,
        b"vkSetDebugUtilsObjectNameEXT" => name_object as *const c_void,
        _ => return unsafe { REAL.get().unwrap()(device, name) },
    };
    // SAFETY: the function is called with the type of its name.
    unsafe { transmute::<*const c_void, vk::PFN_vkVoidFunction>(own) }
}

/// Returns the commands that are recorded with a device that only counts them.
fn counted(host: &Host, record: impl FnOnce(&ash::Device, vk::CommandBuffer)) -> Vec<Pass> {
    let _alone = COUNTING.lock().unwrap_or_else(PoisonError::into_inner);
    record(&host.device_with(counting), vk::CommandBuffer::null());
    take(&mut RECORDED.lock().unwrap().0)
}

/// Returns the numbers of dispatches, barriers and other commands.
fn sum(passes: &[Pass]) -> [u32; 3] {
    [0, 1, 2].map(|kind| passes.iter().map(|pass| pass.counts[kind]).sum())
}

/// Returns a list with one line for each run of equal labels.
fn listing(passes: &[Pass]) -> String {
    let mut text = format!(
        "{:28} {:>6} {:>10} {:>8} {:>6}\n",
        "", "passes", "dispatches", "barriers", "others"
    );
    let is_run = |a: &Pass, b: &Pass| a.label == b.label && b.depth > 0;
    for run in passes.chunk_by(is_run) {
        let label = format!("{}{}", "  ".repeat(run[0].depth), run[0].label);
        let [dispatches, barriers, others] = sum(run);
        let count = run.len();
        writeln!(text, "{label:28} {count:>6} {dispatches:>10} {barriers:>8} {others:>6}").unwrap();
    }
    let [dispatches, barriers, others] = sum(passes);
    writeln!(text, "{:35} {dispatches:>10} {barriers:>8} {others:>6}", "in all").unwrap();
    text
}

/// Compares the guide's block of this kind with `found`. If `GEOSWEEP_UPDATE_GUIDE` is set, writes the block
/// anew.
fn compare_with_guide(kind: &str, found: &str, is_same_device: bool) {
    // Lock of the guide, so that one test at a time reads and writes it.
    static GUIDE_IS_OPEN: Mutex<()> = Mutex::new(());
    let _open = GUIDE_IS_OPEN.lock();
    let guide = std::fs::read_to_string(GUIDE).unwrap();
    let fence = format!("```{kind}\n");
    let (before, rest) = guide.split_once(&fence).expect("the guide has such a block");
    let (listed, after) = rest.split_once("```").unwrap();
    if std::env::var_os("GEOSWEEP_UPDATE_GUIDE").is_some() {
        std::fs::write(GUIDE, format!("{before}{fence}{found}```{after}")).unwrap();
    } else if is_same_device {
        assert!(listed == found, "renew it with GEOSWEEP_UPDATE_GUIDE=1\n{listed}\n{found}");
    }
}

/// The guide's listing equals that of a frame. If `GEOSWEEP_UPDATE_GUIDE` is set, the test writes the listing
/// anew. All objects in a capture have names.
#[test]
fn a_capture_of_a_frame_is_as_the_guide_lists_it() {
    let mut host = Host::without_validation();
    let device = host.device.clone();
    REAL.get_or_init(|| host.instance.fp_v1_0().get_device_proc_addr);
    let entry = unsafe { ash::Entry::load() }.unwrap();
    let handle = host.instance.handle();
    let instance = unsafe {
        let load = |name: &CStr| match name == c"vkGetDeviceProcAddr" {
            true => debug_utils as *const c_void,
            false => transmute::<vk::PFN_vkVoidFunction, *const c_void>(
                entry.get_instance_proc_addr(handle, name.as_ptr()),
            ),
        };
        ash::Instance::load_with(load, handle)
    };
    let chart = Chart { rows: 64, cols: 64 };
    let points = host.buffer_of(&vertices(chart, 0.4));
    let passes = [(Schedule::Raster, Wavefront::Curved)];
    let tools = Tools { labels: true, ..Tools::default() };
    let physical_device = host.physical_device;
    let mut solver =
        embed::Solver::with_tools(&instance, physical_device, &device, &passes, tools).unwrap();
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(chart).with_points(&inputs).with_name("sphere");
    let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
    let method = Method::new(Wavefront::Curved, Stop::within(1e-4).or_after(100));
    let plan = solver.plan(chart, method, 4).unwrap();
    let prepared = counted(&host, |device, commands| {
        solver.record(device, commands, &surface).prepare();
    });
    assert_eq!(sum(&prepared)[0], 0, "nothing is dispatched in vain");
    let sources = [PointSource::at(20.5, 31.25)];
    let frame = Frame::new(&plan, SourceInput::Inline(&sources), Reader::FRAGMENT)
        .with_points(0)
        .with_unreached(-1.0);
    let found = counted(&host, |device, commands| {
        solver.record(device, commands, &surface).frame(&frame).unwrap();
    });
    // Devices differ in the number of lines that a dispatch scans.
    compare_with_guide("capture", &listing(&found), host.is_processor());
    let names = NAMES.lock().unwrap().clone();
    for kind in [
        "PIPELINE ",
        "PIPELINE_LAYOUT ",
        "DESCRIPTOR_SET_LAYOUT ",
        "DESCRIPTOR_SET ",
        "IMAGE ",
        "IMAGE_VIEW ",
        "BUFFER ",
    ] {
        assert!(names.iter().any(|name| name.starts_with(kind)), "{kind}: {names:#?}");
    }
    assert!(names.iter().all(|name| name.contains(" geosweep: ")), "{names:#?}");
    surface.destroy(&device, host.allocator());
    solver.destroy(&device);
    host.free(points);
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
        frame(solver.record(&device, commands, &surface).profiled(&profile).unwrap()).unwrap();
    });
    let outcome = surface.outcome(0).unwrap();
    let resolved = profile.resolve(&device, None, Some(decisions.bytes())).unwrap().unwrap();
    assert_eq!(resolved.left_out, 0);
    let moved: Option<u64> = resolved.passes.iter().map(|pass| pass.work.bytes()).sum();
    let moved = moved.expect("all passes of a frame are counted");

    let [dispatches, barriers, others] = sum(&counted(host, |device, commands| {
        frame(solver.record(device, commands, &surface)).unwrap();
    }));
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
            let [dispatches, barriers, others] = sum(&counted(&host, |device, commands| {
                solver.record(device, commands, &surfaces[0]).frame(&frame).unwrap();
            }));
            for &count in counts {
                let frames: Vec<_> = surfaces[..count]
                    .iter()
                    .map(|surface| SurfaceFrame::new(surface, frame))
                    .collect();
                let together = sum(&counted(&host, |device, commands| {
                    solver.record_frames(device, commands, &frames).unwrap();
                }));
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
