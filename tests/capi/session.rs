//! A host that has a solver through the interface for C.

use std::ffi::{CStr, c_char};
use std::sync::OnceLock;

use geosweep::ash::{self, vk};
use geosweep_capi::*;

use crate::host::{Host, HostBuffer};

/// Returns the value of `= {0}` in C.
pub fn zero<T: Copy>() -> T {
    // SAFETY: the tests request only structs of the interface, for which zero is a valid value.
    unsafe { std::mem::zeroed() }
}

pub fn last_error() -> String {
    unsafe { CStr::from_ptr(geosweep_last_error()) }.to_str().unwrap().to_owned()
}

#[track_caller]
pub fn ok(status: GeosweepStatus) {
    assert_eq!(status, GeosweepStatus::Success, "{}", last_error());
}

/// Asserts that a call has failed with this status, and that its message contains these words.
#[track_caller]
pub fn refused(status: GeosweepStatus, expected: GeosweepStatus, words: &str) {
    let message = last_error();
    assert_eq!(status, expected, "{message}");
    assert!(message.contains(words), "{words:?} is not in {message:?}");
}

/// Asserts that a call has refused an argument.
#[track_caller]
pub fn wrong(status: GeosweepStatus, words: &str) {
    refused(status, GeosweepStatus::InvalidArgument, words);
}

/// Asserts that each call is refused with these words.
macro_rules! all_wrong {
    ($($call:expr => $words:literal,)*) => { $($crate::session::wrong($call, $words);)* };
}
pub(crate) use all_wrong;

/// Returns the loader, which stays loaded as long as the tests run.
pub fn entry() -> &'static ash::Entry {
    static ENTRY: OnceLock<ash::Entry> = OnceLock::new();
    ENTRY.get_or_init(|| unsafe { ash::Entry::load() }.unwrap())
}

pub fn get_instance_proc_addr() -> Option<vk::PFN_vkGetInstanceProcAddr> {
    Some(entry().static_fn().get_instance_proc_addr)
}

/// Functions that take the place of Vulkan's. `Some(None)` stands for a function that is missing.
pub trait Replacement {
    /// Returns what replaces a function of an instance.
    fn of_instance(_name: &CStr) -> Option<vk::PFN_vkVoidFunction> {
        None
    }

    /// Returns what replaces a function of a device.
    fn of_device(_name: &CStr) -> Option<vk::PFN_vkVoidFunction> {
        None
    }
}

/// Finds the loader's functions, but for those that are replaced.
pub unsafe extern "system" fn replaced<R: Replacement>(
    instance: vk::Instance,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    static REAL: OnceLock<vk::PFN_vkGetDeviceProcAddr> = OnceLock::new();
    unsafe extern "system" fn of_device<R: Replacement>(
        device: vk::Device,
        name: *const c_char,
    ) -> vk::PFN_vkVoidFunction {
        let real = || unsafe { (REAL.get().unwrap())(device, name) };
        R::of_device(unsafe { CStr::from_ptr(name) }).unwrap_or_else(real)
    }
    let wanted = unsafe { CStr::from_ptr(name) };
    let real = unsafe { entry().get_instance_proc_addr(instance, name) };
    if wanted == c"vkGetDeviceProcAddr" {
        // SAFETY: a function has the type of its name.
        return unsafe {
            REAL.get_or_init(|| {
                std::mem::transmute::<vk::PFN_vkVoidFunction, vk::PFN_vkGetDeviceProcAddr>(real)
            });
            std::mem::transmute::<vk::PFN_vkGetDeviceProcAddr, vk::PFN_vkVoidFunction>(
                of_device::<R>,
            )
        };
    }
    R::of_instance(wanted).unwrap_or(real)
}

const RASTER: [GeosweepPasses; 4] = {
    const fn of(wavefront: GeosweepWavefront) -> GeosweepPasses {
        GeosweepPasses { schedule: GeosweepSchedule::Raster as i32, wavefront: wavefront as i32 }
    }
    use GeosweepWavefront::*;
    [of(Planar), of(Circular), of(Curved), of(Anchored)]
};

pub fn solver_info(host: &Host) -> GeosweepSolverInfo {
    GeosweepSolverInfo {
        header_version: GEOSWEEP_HEADER_VERSION,
        get_instance_proc_addr: get_instance_proc_addr(),
        instance: host.instance.handle(),
        physical_device: host.physical_device,
        device: host.device.handle(),
        passes: RASTER.as_ptr(),
        pass_count: RASTER.len() as u32,
        pipeline_cache: vk::PipelineCache::null(),
        flags: 0,
        allocator: std::ptr::null(),
    }
}

/// Returns the parameters of a grid with one slot and these points.
pub fn surface_info(rows: u32, cols: u32, points: &[GeosweepPoints]) -> GeosweepSurfaceInfo {
    let (points, point_count) = (points.as_ptr(), points.len() as u32);
    GeosweepSurfaceInfo { rows, cols, slots: 1, points, point_count, ..zero() }
}

/// Returns heights in the program's memory, one step apart.
pub fn height_points(data: &[f32]) -> GeosweepPoints {
    let kind = GeosweepPointKind::Heights as i32;
    GeosweepPoints { kind, dx: 1.0, dy: 1.0, data: data.as_ptr(), stride: 4, ..zero() }
}

/// Returns a method whose tolerance is the limit of single precision.
pub fn method(wavefront: GeosweepWavefront, iterations: u32) -> GeosweepMethod {
    let wavefront = wavefront as i32;
    GeosweepMethod { wavefront, tolerance: 1e-6, most_iterations: 400, iterations, ..zero() }
}

pub const COPY: GeosweepReader = GeosweepReader {
    access: GeosweepAccess {
        stages: vk::PipelineStageFlags::TRANSFER,
        access: vk::AccessFlags::TRANSFER_READ,
    },
    layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
};

pub fn frame(plan: *const GeosweepPlan, sources: &[GeosweepSource]) -> GeosweepFrame {
    let (sources, count) = (sources.as_ptr(), sources.len() as u32);
    let sources = GeosweepSources { sources, count, ..zero() };
    GeosweepFrame { sources, plan, reader: COPY, unreached: f32::INFINITY, ..zero() }
}

/// Destroys objects: each function with its object.
macro_rules! destroy {
    ($($function:ident($object:expr)),* $(,)?) => {
        unsafe { $($crate::session::ok($function($object));)* }
    };
}
pub(crate) use destroy;

/// A host with a solver. [`Session::end`] destroys it.
pub struct Session {
    pub host: Host,
    pub solver: *mut GeosweepSolver,
}

impl Session {
    pub fn new(host: Host) -> Self {
        let info = solver_info(&host);
        Self::of(host, &info)
    }

    /// Returns a session whose solver has checks, and passes for curved fronts.
    pub fn with_checks(host: Host) -> Self {
        let (flags, passes) = (GEOSWEEP_SOLVER_CHECKS, RASTER[2..].as_ptr());
        let info = GeosweepSolverInfo { flags, passes, pass_count: 1, ..solver_info(&host) };
        Self::of(host, &info)
    }

    pub fn of(host: Host, info: &GeosweepSolverInfo) -> Self {
        let mut solver = std::ptr::null_mut();
        ok(unsafe { geosweep_solver_create(info, &mut solver) });
        Self { host, solver }
    }

    pub fn plan(&self, rows: u32, cols: u32, method: &GeosweepMethod) -> *mut GeosweepPlan {
        let mut plan = std::ptr::null_mut();
        ok(unsafe { geosweep_plan_create(self.solver, rows, cols, method, &mut plan) });
        plan
    }

    /// Returns a prepared surface.
    pub fn surface(&self, info: &GeosweepSurfaceInfo) -> *mut GeosweepSurface {
        let mut surface = std::ptr::null_mut();
        ok(unsafe { geosweep_surface_create(self.solver, info, &mut surface) });
        self.host.run(|commands| ok(unsafe { geosweep_record_prepare(surface, commands) }));
        surface
    }

    /// Runs commands that write an image, and copies its texels, each of so many floats.
    pub fn read(
        &mut self,
        floats: usize,
        record: impl FnOnce(vk::CommandBuffer, &mut GeosweepImage) -> GeosweepStatus,
    ) -> Vec<f32> {
        let commands = self.host.commands();
        self.host.begin(commands);
        let mut image: GeosweepImage = zero();
        ok(record(commands, &mut image));
        let count = floats * image.extent.width as usize * image.extent.height as usize;
        let to = self.host.buffer(4 * count as u64, true);
        let layers = vk::ImageSubresourceLayers::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .layer_count(1);
        let copy = [vk::BufferImageCopy::default()
            .image_subresource(layers)
            .image_extent(image.extent.into())];
        unsafe {
            let (from, layout) = (image.image, image.layout);
            self.host.device.cmd_copy_image_to_buffer(commands, from, layout, to.handle, &copy);
        }
        self.host.end(commands);
        self.submit(commands);
        let texels = to.floats()[..count].to_vec();
        self.host.free(to);
        texels
    }

    /// Runs commands and waits for them.
    pub fn submit(&self, commands: vk::CommandBuffer) {
        self.host.submit(commands, vk::Fence::null());
        unsafe { self.host.device.device_wait_idle() }.unwrap();
    }

    /// Returns the map of a frame.
    pub fn map(&mut self, surface: *const GeosweepSurface, frame: &GeosweepFrame) -> Vec<f32> {
        self.read(1, |commands, image| unsafe {
            geosweep_record_frame(surface, commands, frame, image)
        })
    }

    pub fn outcome(&self, surface: *const GeosweepSurface) -> GeosweepOutcome {
        let mut outcome = zero();
        ok(unsafe { geosweep_surface_outcome(surface, 0, &mut outcome) });
        outcome
    }

    /// Destroys the solver. Asserts that no memory is left and that the validation layers have reported
    /// nothing.
    pub fn end(mut self, buffers: impl IntoIterator<Item = HostBuffer>) {
        ok(unsafe { geosweep_solver_destroy(self.solver) });
        buffers.into_iter().for_each(|buffer| self.host.free(buffer));
        assert_eq!((self.host.messages(), self.host.allocations()), (Vec::new(), 0));
    }
}
