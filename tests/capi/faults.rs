//! Devices and loaders that lack something, and Vulkan calls that fail.

use std::ffi::{CStr, c_char};
use std::sync::atomic::{AtomicI32, Ordering};

use geosweep::ash::vk;
use geosweep::capi::*;

use crate::host::Host;
use crate::session::{
    Session, entry, get_instance_proc_addr, last_error, ok, refused, solver_info, surface_info,
    wrong, zero,
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

unsafe fn really(instance: vk::Instance, name: *const c_char) -> vk::PFN_vkVoidFunction {
    unsafe { entry().get_instance_proc_addr(instance, name) }
}

/// Finds the functions of a device for Vulkan 1.0 with small limits.
unsafe extern "system" fn finds_little(
    instance: vk::Instance,
    name: *const c_char,
) -> vk::PFN_vkVoidFunction {
    unsafe extern "system" fn properties(
        physical_device: vk::PhysicalDevice,
        properties: *mut vk::PhysicalDeviceProperties,
    ) {
        // This function is given no instance, so it finds the real function through the test's instance.
        let host = INSTANCE.get().expect("it was set before this function was installed").0;
        unsafe {
            let ask = really(host, c"vkGetPhysicalDeviceProperties".as_ptr()).unwrap();
            let ask: vk::PFN_vkGetPhysicalDeviceProperties = std::mem::transmute(ask);
            ask(physical_device, properties);
            (*properties).api_version = vk::API_VERSION_1_0;
            (*properties).limits.max_push_constants_size = 4;
        }
    }
    if unsafe { CStr::from_ptr(name) } == c"vkGetPhysicalDeviceProperties" {
        // SAFETY: the function is called with the type of its name.
        return unsafe {
            std::mem::transmute::<vk::PFN_vkGetPhysicalDeviceProperties, vk::PFN_vkVoidFunction>(
                properties,
            )
        };
    }
    unsafe { really(instance, name) }
}

struct Shared(vk::Instance);
// SAFETY: any thread may use an instance.
unsafe impl Send for Shared {}
// SAFETY: as above.
unsafe impl Sync for Shared {}
static INSTANCE: std::sync::OnceLock<Shared> = std::sync::OnceLock::new();

#[test]
fn missing_requirements_of_a_device_are_reported() {
    let host = Host::without_validation();
    assert!(INSTANCE.set(Shared(host.instance.handle())).is_ok());
    let (instance, device) = (host.instance.handle(), host.physical_device);
    ok(unsafe { geosweep_check_device(get_instance_proc_addr(), instance, device) });
    let status = unsafe { geosweep_check_device(Some(finds_little), instance, device) };
    for words in ["Vulkan 1.0.0, but 1.1 is needed", "4 bytes of push constants"] {
        refused(status, GeosweepStatus::Unsupported, words);
    }
    let get_instance_proc_addr = Some(finds_little as vk::PFN_vkGetInstanceProcAddr);
    let info = GeosweepSolverInfo { get_instance_proc_addr, ..solver_info(&host) };
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

/// When a missing function is called, ash would end the process.
#[test]
fn missing_functions_are_named() {
    let host = Host::without_validation();
    let (instance, device) = (host.instance.handle(), host.physical_device);
    let status = unsafe { geosweep_check_device(Some(finds_nothing), instance, device) };
    wrong(status, "knows no function vkDestroyInstance");
    wrong(unsafe { geosweep_check_device(None, instance, device) }, "is null");

    unsafe extern "system" fn no_device_functions(
        instance: vk::Instance,
        name: *const c_char,
    ) -> vk::PFN_vkVoidFunction {
        unsafe extern "system" fn none(_: vk::Device, _: *const c_char) -> vk::PFN_vkVoidFunction {
            None
        }
        if unsafe { CStr::from_ptr(name) } == c"vkGetDeviceProcAddr" {
            // SAFETY: the function is called with the type of its name.
            return unsafe {
                std::mem::transmute::<vk::PFN_vkGetDeviceProcAddr, vk::PFN_vkVoidFunction>(none)
            };
        }
        unsafe { really(instance, name) }
    }
    let get_instance_proc_addr = Some(no_device_functions as vk::PFN_vkGetInstanceProcAddr);
    let info = GeosweepSolverInfo { get_instance_proc_addr, ..solver_info(&host) };
    let mut solver = std::ptr::null_mut();
    wrong(unsafe { geosweep_solver_create(&info, &mut solver) }, "vkGetDeviceProcAddr knows no");
}

/// A Vulkan call that fails gives a status for its result and a message with its name, and leaves nothing behind.
#[test]
fn calls_that_fail_have_a_status_and_a_name() {
    /// Makes `vkCreateComputePipelines` fail for solvers that are created while `PIPELINES` is 1, and
    /// `vkBindImageMemory` for later solvers.
    unsafe extern "system" fn failing(
        instance: vk::Instance,
        name: *const c_char,
    ) -> vk::PFN_vkVoidFunction {
        unsafe extern "system" fn of_device(
            device: vk::Device,
            name: *const c_char,
        ) -> vk::PFN_vkVoidFunction {
            let wanted = unsafe { CStr::from_ptr(name) };
            let fails = if PIPELINES.load(Ordering::SeqCst) == 1 {
                c"vkCreateComputePipelines"
            } else {
                c"vkBindImageMemory"
            };
            if wanted == fails {
                // `fail` has no parameters. The calling convention allows arguments in a call of such a function.
                return unsafe {
                    std::mem::transmute::<extern "system" fn() -> vk::Result, vk::PFN_vkVoidFunction>(
                        fail,
                    )
                };
            }
            let host = FAILING_INSTANCE.get().expect("it was set before").0;
            unsafe {
                let ask = really(host, c"vkGetDeviceProcAddr".as_ptr()).unwrap();
                let ask: vk::PFN_vkGetDeviceProcAddr = std::mem::transmute(ask);
                ask(device, name)
            }
        }
        if unsafe { CStr::from_ptr(name) } == c"vkGetDeviceProcAddr" {
            // SAFETY: the function is called with the type of its name.
            return unsafe {
                std::mem::transmute::<vk::PFN_vkGetDeviceProcAddr, vk::PFN_vkVoidFunction>(
                    of_device,
                )
            };
        }
        unsafe { really(instance, name) }
    }
    static PIPELINES: AtomicI32 = AtomicI32::new(1);
    static FAILING_INSTANCE: std::sync::OnceLock<Shared> = std::sync::OnceLock::new();

    let host = Host::without_validation();
    assert!(FAILING_INSTANCE.set(Shared(host.instance.handle())).is_ok());
    let get_instance_proc_addr = Some(failing as vk::PFN_vkGetInstanceProcAddr);
    let info = GeosweepSolverInfo { get_instance_proc_addr, ..solver_info(&host) };
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

    PIPELINES.store(0, Ordering::SeqCst);
    let mut solver = std::ptr::null_mut();
    ok(unsafe { geosweep_solver_create(&info, &mut solver) });
    let session = Session { host, solver };
    let data = [0.0f32; 12];
    let points =
        [GeosweepPoints { data: data.as_ptr(), stride: 4, kind: 1, dx: 1.0, dy: 1.0, ..zero() }];
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
