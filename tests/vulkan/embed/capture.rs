//! Labels, commands and names that a tool shows when it captures a frame, as docs/frame-costs.md lists them.

use std::ffi::{CStr, c_char, c_void};
use std::fmt::Write;
use std::sync::{Mutex, OnceLock};

use geosweep::ash::{self, vk};
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Frame, PointSource, Points, Reader, SourceInput, SurfaceInfo, Tools,
};
use geosweep::vulkan::{Method, Schedule};
use geosweep::{Stop, Wavefront};

use crate::embed::stage::vertices;
use crate::host::Host;

/// Path of the guide from the package's root, where tests run.
const GUIDE: &str = "docs/frame-costs.md";

/// A label, and the numbers of commands between this label and the next one.
#[derive(Default)]
struct Pass {
    label: String,
    depth: usize,
    dispatches: usize,
    barriers: usize,
    others: usize,
}

static PASSES: Mutex<Vec<Pass>> = Mutex::new(Vec::new());
static DEPTH: Mutex<usize> = Mutex::new(0);
static NAMES: Mutex<Vec<String>> = Mutex::new(Vec::new());
static REAL: OnceLock<vk::PFN_vkGetDeviceProcAddr> = OnceLock::new();

fn note(count: impl FnOnce(&mut Pass)) {
    let mut passes = PASSES.lock().unwrap();
    if passes.is_empty() {
        passes.push(Pass::default());
    }
    count(passes.last_mut().unwrap());
}

/// Defines a function of the device that counts its calls and then calls the real one.
macro_rules! counting {
    ($(fn $own:ident($($argument:ident: $kind:ty),*) $(-> $result:ty)? as $name:literal: $pointer:ty $count:block)*) => {
        $(unsafe extern "system" fn $own(device: vk::CommandBuffer, $($argument: $kind),*) $(-> $result)? {
            $count
            static FOUND: OnceLock<$pointer> = OnceLock::new();
            let real = FOUND.get_or_init(|| unsafe {
                let found = real($name).expect("the device has the function");
                std::mem::transmute::<unsafe extern "system" fn(), $pointer>(found)
            });
            unsafe { real(device, $($argument),*) }
        })*

        /// Returns the replacement of the function with this name, if there is one.
        fn own(name: &CStr) -> Option<*const c_void> {
            $(if name == $name { return Some($own as *const c_void); })*
            None
        }
    };
}

/// The device that is observed. Functions are found through it.
static DEVICE: OnceLock<u64> = OnceLock::new();

unsafe fn real(name: &CStr) -> vk::PFN_vkVoidFunction {
    let device = vk::Handle::from_raw(*DEVICE.get().unwrap());
    unsafe { REAL.get().unwrap()(device, name.as_ptr()) }
}

type Buffers<'a> = *const vk::BufferMemoryBarrier<'a>;
type Images<'a> = *const vk::ImageMemoryBarrier<'a>;

counting! {
    fn dispatch(x: u32, y: u32, z: u32) as c"vkCmdDispatch": vk::PFN_vkCmdDispatch {
        note(|pass| pass.dispatches += 1);
    }
    fn dispatch_indirect(buffer: vk::Buffer, offset: u64)
        as c"vkCmdDispatchIndirect": vk::PFN_vkCmdDispatchIndirect
    {
        note(|pass| pass.dispatches += 1);
    }
    fn barrier(
        before: vk::PipelineStageFlags, after: vk::PipelineStageFlags, flags: vk::DependencyFlags,
        count: u32, memory: *const vk::MemoryBarrier<'_>, buffer_count: u32, buffers: Buffers<'_>,
        image_count: u32, images: Images<'_>
    ) as c"vkCmdPipelineBarrier": vk::PFN_vkCmdPipelineBarrier {
        note(|pass| pass.barriers += 1);
    }
    fn fill(buffer: vk::Buffer, offset: u64, size: u64, number: u32)
        as c"vkCmdFillBuffer": vk::PFN_vkCmdFillBuffer
    {
        note(|pass| pass.others += 1);
    }
    fn update(buffer: vk::Buffer, offset: u64, size: u64, data: *const c_void)
        as c"vkCmdUpdateBuffer": vk::PFN_vkCmdUpdateBuffer
    {
        note(|pass| pass.others += 1);
    }
    fn copy(from: vk::Buffer, to: vk::Buffer, count: u32, parts: *const vk::BufferCopy)
        as c"vkCmdCopyBuffer": vk::PFN_vkCmdCopyBuffer
    {
        note(|pass| pass.others += 1);
    }
    fn clear(
        image: vk::Image, layout: vk::ImageLayout, value: *const vk::ClearColorValue, count: u32,
        ranges: *const vk::ImageSubresourceRange
    ) as c"vkCmdClearColorImage": vk::PFN_vkCmdClearColorImage {
        note(|pass| pass.others += 1);
    }
    fn begin_label(label: *const vk::DebugUtilsLabelEXT<'_>)
        as c"vkCmdBeginDebugUtilsLabelEXT": vk::PFN_vkCmdBeginDebugUtilsLabelEXT
    {
        let label = unsafe { CStr::from_ptr((*label).p_label_name) }.to_str().unwrap().to_owned();
        let mut depth = DEPTH.lock().unwrap();
        PASSES.lock().unwrap().push(Pass { label, depth: *depth, ..Pass::default() });
        *depth += 1;
    }
    fn end_label() as c"vkCmdEndDebugUtilsLabelEXT": vk::PFN_vkCmdEndDebugUtilsLabelEXT {
        *DEPTH.lock().unwrap() -= 1;
    }
}

unsafe extern "system" fn name(
    device: vk::Device,
    info: *const vk::DebugUtilsObjectNameInfoEXT<'_>,
) -> vk::Result {
    let given = unsafe { &*info };
    let text = unsafe { CStr::from_ptr(given.p_object_name) }.to_str().unwrap();
    NAMES.lock().unwrap().push(format!("{:?} {text}", given.object_type));
    unsafe {
        let found = real(c"vkSetDebugUtilsObjectNameEXT").unwrap();
        let real = std::mem::transmute::<
            unsafe extern "system" fn(),
            vk::PFN_vkSetDebugUtilsObjectNameEXT,
        >(found);
        real(device, info)
    }
}

unsafe extern "system" fn of_device(
    device: vk::Device,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    let wanted = unsafe { CStr::from_ptr(name) };
    let own = match wanted == c"vkSetDebugUtilsObjectNameEXT" {
        true => Some(self::name as *const c_void),
        false => own(wanted),
    };
    match own {
        // SAFETY: the function is called with the type of its name.
        Some(own) => unsafe { std::mem::transmute::<*const c_void, vk::PFN_vkVoidFunction>(own) },
        None => unsafe { REAL.get().unwrap()(device, name) },
    }
}

/// Returns a list with one line for each run of equal labels.
fn listing() -> String {
    let mut passes: Vec<Pass> = Vec::new();
    let mut runs: Vec<usize> = Vec::new();
    for pass in PASSES.lock().unwrap().drain(..) {
        match passes.last_mut() {
            Some(last) if last.label == pass.label && pass.depth > 0 => {
                last.dispatches += pass.dispatches;
                last.barriers += pass.barriers;
                last.others += pass.others;
                *runs.last_mut().unwrap() += 1;
            }
            _ => {
                passes.push(pass);
                runs.push(1);
            }
        }
    }
    let mut text = format!(
        "{:24} {:>6} {:>10} {:>8} {:>6}\n",
        "", "passes", "dispatches", "barriers", "others"
    );
    let mut sum = [0; 3];
    for (pass, run) in passes.iter().zip(runs) {
        let Pass { label, depth, dispatches, barriers, others, .. } = pass;
        let label = format!("{}{label}", "  ".repeat(*depth));
        writeln!(text, "{label:24} {run:>6} {dispatches:>10} {barriers:>8} {others:>6}").unwrap();
        sum = [sum[0] + dispatches, sum[1] + barriers, sum[2] + others];
    }
    writeln!(text, "{:31} {:>10} {:>8} {:>6}", "in all", sum[0], sum[1], sum[2]).unwrap();
    text
}

/// Compares the guide's block of this kind with `found`. If `GEOSWEEP_UPDATE_GUIDE` is set, writes the block
/// anew.
pub fn compare_with_guide(kind: &str, found: &str, is_same_device: bool) {
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
    let mut host = Host::new();
    REAL.get_or_init(|| host.instance.fp_v1_0().get_device_proc_addr);
    DEVICE.get_or_init(|| vk::Handle::as_raw(host.device.handle()));
    let entry = unsafe { ash::Entry::load() }.unwrap();
    let handle = host.instance.handle();
    let instance = unsafe {
        let load = |name: &CStr| match name == c"vkGetDeviceProcAddr" {
            true => of_device as *const c_void,
            false => std::mem::transmute::<vk::PFN_vkVoidFunction, *const c_void>(
                entry.get_instance_proc_addr(handle, name.as_ptr()),
            ),
        };
        ash::Instance::load_with(load, handle)
    };
    let device = unsafe { ash::Device::load(instance.fp_v1_0(), host.device.handle()) };
    let chart = Chart { rows: 64, cols: 64 };
    let points = host.buffer_of(&vertices(chart, 0.4));
    let passes = [(Schedule::Raster, Wavefront::Curved)];
    let tools = Tools { labels: true, ..Tools::default() };
    let physical_device = host.physical_device;
    let mut solver =
        embed::Solver::with_tools(&instance, physical_device, &device, &passes, tools).unwrap();
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(chart).with_points(&inputs);
    let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
    let stop = Stop::within(1e-4).or_after(100);
    let method = Method::new(Wavefront::Curved, stop);
    let plan = solver.plan(chart, method, 4).unwrap();
    host.run(|commands| solver.record(&device, commands, &surface).prepare());
    let prepared = std::mem::take(&mut *PASSES.lock().unwrap());
    assert!(prepared.iter().all(|pass| pass.dispatches == 0), "nothing is dispatched in vain");
    host.run(|commands| {
        solver
            .record(&device, commands, &surface)
            .frame(
                &Frame::new(
                    &plan,
                    SourceInput::Inline(&[PointSource::at(20.5, 31.25)]),
                    Reader::FRAGMENT,
                )
                .with_points(0)
                .with_unreached(-1.0),
            )
            .unwrap();
    });
    let found = listing();
    // Devices differ in the number of lines that a dispatch scans.
    compare_with_guide("capture", &found, host.is_processor());
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
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}
