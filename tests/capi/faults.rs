//! Devices and loaders that lack something, and Vulkan calls that fail.

use std::ffi::{CStr, c_char};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};

use geosweep::ash::vk;
use geosweep_capi::*;

use crate::host::Host;
use crate::session::{
    Replacement, Session, get_instance_proc_addr, height_points, last_error, ok, refused, replaced,
    solver_info, surface_info, wrong, zero,
};

/// Result that the failing functions return.
static RESULT: AtomicI32 = AtomicI32::new(0);

extern "system" fn fail() -> vk::Result {
    vk::Result::from_raw(RESULT.load(Ordering::SeqCst))
}

unsafe extern "system" fn finds_nothing(
    _: vk::Instance,
    _: *const c_char,
) -> vk::PFN_vkVoidFunction {
    None
}

static PROPERTIES: OnceLock<vk::PFN_vkGetPhysicalDeviceProperties> = OnceLock::new();

/// A device for Vulkan 1.0 with small limits.
struct Little;

impl Replacement for Little {
    fn of_instance(name: &CStr) -> Option<vk::PFN_vkVoidFunction> {
        unsafe extern "system" fn properties(
            physical_device: vk::PhysicalDevice,
            properties: *mut vk::PhysicalDeviceProperties,
        ) {
            unsafe {
                (PROPERTIES.get().unwrap())(physical_device, properties);
                (*properties).api_version = vk::API_VERSION_1_0;
                (*properties).limits.max_push_constants_size = 4;
            }
        }
        // SAFETY: the function is called with the type of its name.
        (name == c"vkGetPhysicalDeviceProperties").then(|| unsafe {
            std::mem::transmute::<vk::PFN_vkGetPhysicalDeviceProperties, vk::PFN_vkVoidFunction>(
                properties,
            )
        })
    }
}

static PROPERTIES_2: OnceLock<vk::PFN_vkGetPhysicalDeviceProperties2> = OnceLock::new();

/// A device whose driver is known to leave out parts of maps.
struct Wrong;

impl Replacement for Wrong {
    fn of_instance(name: &CStr) -> Option<vk::PFN_vkVoidFunction> {
        unsafe extern "system" fn properties(
            physical_device: vk::PhysicalDevice,
            properties: *mut vk::PhysicalDeviceProperties2,
        ) {
            unsafe {
                (PROPERTIES_2.get().unwrap())(physical_device, properties);
                let mut next = (*properties).p_next.cast::<vk::BaseOutStructure>();
                while let Some(of) = next.as_mut() {
                    if of.s_type == vk::StructureType::PHYSICAL_DEVICE_DRIVER_PROPERTIES {
                        let driver = &mut *next.cast::<vk::PhysicalDeviceDriverProperties>();
                        let text = |text: &[u8]| {
                            std::array::from_fn(|at| text.get(at).map_or(0, |&byte| byte as c_char))
                        };
                        driver.driver_name = text(b"llvmpipe");
                        driver.driver_info = text(b"Mesa 24.0.9-0ubuntu0.3 (LLVM 17.0.6)");
                    }
                    next = of.p_next;
                }
            }
        }
        // SAFETY: the function is called with the type of its name.
        (name == c"vkGetPhysicalDeviceProperties2").then(|| unsafe {
            std::mem::transmute::<vk::PFN_vkGetPhysicalDeviceProperties2, vk::PFN_vkVoidFunction>(
                properties,
            )
        })
    }
}

/// A device without functions.
struct Bare;

impl Replacement for Bare {
    fn of_device(_name: &CStr) -> Option<vk::PFN_vkVoidFunction> {
        Some(None)
    }
}

/// Makes `vkCreateComputePipelines` fail for solvers that are created while [`PIPELINES_FAIL`] is set, and
/// `vkBindImageMemory` for later solvers.
struct Failing;
static PIPELINES_FAIL: AtomicBool = AtomicBool::new(true);

/// Result of the calls that [`NoMemory`] makes fail.
static MEMORY_RESULT: AtomicI32 = AtomicI32::new(0);

extern "system" fn no_memory() -> vk::Result {
    vk::Result::from_raw(MEMORY_RESULT.load(Ordering::SeqCst))
}

/// Makes `vkAllocateMemory` or `vkMapMemory` fail.
struct NoMemory<const MAPS: bool>;

impl<const MAPS: bool> Replacement for NoMemory<MAPS> {
    fn of_device(name: &CStr) -> Option<vk::PFN_vkVoidFunction> {
        let fails = if MAPS { c"vkMapMemory" } else { c"vkAllocateMemory" };
        // SAFETY: as for [`Failing`].
        (name == fails).then(|| unsafe {
            std::mem::transmute::<extern "system" fn() -> vk::Result, vk::PFN_vkVoidFunction>(
                no_memory,
            )
        })
    }
}

impl Replacement for Failing {
    fn of_device(name: &CStr) -> Option<vk::PFN_vkVoidFunction> {
        let fails = match PIPELINES_FAIL.load(Ordering::SeqCst) {
            true => c"vkCreateComputePipelines",
            false => c"vkBindImageMemory",
        };
        // `fail` has no parameters. The calling convention allows arguments in a call of such a function.
        // SAFETY: as above.
        (name == fails).then(|| unsafe {
            std::mem::transmute::<extern "system" fn() -> vk::Result, vk::PFN_vkVoidFunction>(fail)
        })
    }
}

fn solver_with<R: Replacement>(host: &Host) -> GeosweepSolverInfo {
    GeosweepSolverInfo { get_instance_proc_addr: Some(replaced::<R>), ..solver_info(host) }
}

#[test]
fn missing_requirements_of_a_device_are_reported() {
    let host = Host::without_validation();
    PROPERTIES.get_or_init(|| host.instance.fp_v1_0().get_physical_device_properties);
    let (instance, device) = (host.instance.handle(), host.physical_device);
    ok(unsafe { geosweep_check_device(get_instance_proc_addr(), instance, device) });
    let status = unsafe { geosweep_check_device(Some(replaced::<Little>), instance, device) };
    for words in ["Vulkan 1.0.0, but 1.1 is needed", "4 bytes of push constants"] {
        refused(status, GeosweepStatus::Unsupported, words);
    }
    let info = solver_with::<Little>(&host);
    let mut solver = std::ptr::null_mut();
    let status = unsafe { geosweep_solver_create(&info, &mut solver) };
    refused(status, GeosweepStatus::Unsupported, "Vulkan 1.0.0");
    assert!(solver.is_null());

    let mut needed = zero::<GeosweepRequirements>();
    ok(unsafe { geosweep_requirements(&mut needed) });
    assert_eq!(needed.api_version, vk::API_VERSION_1_1);
    assert_eq!((needed.device_extension_count, needed.device_extensions.is_null()), (0, true));
    let mut family = u32::MAX;
    let get = self::get_instance_proc_addr();
    ok(unsafe { geosweep_compute_queue_family(get, instance, device, &mut family) });
    let families = unsafe { host.instance.get_physical_device_queue_family_properties(device) };
    assert!(families[family as usize].queue_flags.contains(vk::QueueFlags::COMPUTE));
}

/// A program learns of a driver that computes wrong maps before it creates a device, and cannot make a solver there.
#[test]
fn drivers_known_to_be_wrong_are_refused() {
    let host = Host::without_validation();
    PROPERTIES_2.get_or_init(|| host.instance.fp_v1_1().get_physical_device_properties2);
    let (instance, device) = (host.instance.handle(), host.physical_device);
    let status = unsafe { geosweep_check_device(Some(replaced::<Wrong>), instance, device) };
    refused(status, GeosweepStatus::Unsupported, "lavapipe of Mesa 24.0 leaves out parts of maps");
    let mut solver = std::ptr::null_mut();
    let status = unsafe { geosweep_solver_create(&solver_with::<Wrong>(&host), &mut solver) };
    refused(status, GeosweepStatus::Unsupported, "install a newer Mesa");
    assert!(solver.is_null());
}

/// When a missing function is called, ash would end the process.
#[test]
fn missing_functions_are_named() {
    let host = Host::without_validation();
    let (instance, device) = (host.instance.handle(), host.physical_device);
    let status = unsafe { geosweep_check_device(Some(finds_nothing), instance, device) };
    wrong(status, "knows no function vkDestroyInstance");
    wrong(unsafe { geosweep_check_device(None, instance, device) }, "is null");

    let info = solver_with::<Bare>(&host);
    let mut solver = std::ptr::null_mut();
    wrong(unsafe { geosweep_solver_create(&info, &mut solver) }, "vkGetDeviceProcAddr knows no");
}

/// A Vulkan call that fails gives a status for its result and a message with its name, and leaves nothing behind.
#[test]
fn calls_that_fail_have_a_status_and_a_name() {
    let host = Host::without_validation();
    let info = solver_with::<Failing>(&host);
    let cases = [
        (vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, GeosweepStatus::OutOfMemory),
        (vk::Result::ERROR_DEVICE_LOST, GeosweepStatus::DeviceLost),
        (vk::Result::ERROR_UNKNOWN, GeosweepStatus::VulkanError),
    ];
    for (result, status) in cases {
        RESULT.store(result.as_raw(), Ordering::SeqCst);
        let mut solver = std::ptr::null_mut();
        let made = unsafe { geosweep_solver_create(&info, &mut solver) };
        refused(made, status, "vkCreateComputePipelines failed");
        assert!(solver.is_null());
    }

    PIPELINES_FAIL.store(false, Ordering::SeqCst);
    let mut solver = std::ptr::null_mut();
    ok(unsafe { geosweep_solver_create(&info, &mut solver) });
    let session = Session { host, solver };
    let data = [0.0f32; 12];
    let points = [height_points(&data)];
    for (result, status) in cases {
        RESULT.store(result.as_raw(), Ordering::SeqCst);
        let mut surface = std::ptr::null_mut();
        let info = surface_info(3, 4, &points);
        let made = unsafe { geosweep_surface_create(session.solver, &info, &mut surface) };
        refused(made, status, "vkBindImageMemory failed");
        assert!(surface.is_null(), "{}", last_error());
    }
    session.end([]);
}

/// Memory that cannot be had or mapped has the status of memory that has run out, or of a device that is lost.
#[test]
fn memory_that_is_not_given_or_mapped_has_a_status() {
    use vk::Result as R;
    let host = Host::without_validation();
    let infos = [solver_with::<NoMemory<false>>(&host), solver_with::<NoMemory<true>>(&host)];
    let data = [0.0f32; 12];
    let points = [height_points(&data)];
    for (info, mapping) in
        infos.iter().zip([R::ERROR_OUT_OF_DEVICE_MEMORY, R::ERROR_MEMORY_MAP_FAILED])
    {
        let mut solver = std::ptr::null_mut();
        ok(unsafe { geosweep_solver_create(info, &mut solver) });
        for (result, status) in [
            (mapping, GeosweepStatus::OutOfMemory),
            (R::ERROR_OUT_OF_HOST_MEMORY, GeosweepStatus::OutOfMemory),
            (R::ERROR_DEVICE_LOST, GeosweepStatus::DeviceLost),
            (R::ERROR_UNKNOWN, GeosweepStatus::VulkanError),
        ] {
            MEMORY_RESULT.store(result.as_raw(), Ordering::SeqCst);
            let mut surface = std::ptr::null_mut();
            let info = surface_info(3, 4, &points);
            let made = unsafe { geosweep_surface_create(solver, &info, &mut surface) };
            refused(made, status, "cannot allocate");
            assert!(surface.is_null());
        }
        ok(unsafe { geosweep_solver_destroy(solver) });
    }
}
