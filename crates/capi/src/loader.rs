//! Loads the functions of the host's instance and device through the host's loader.

use std::ffi::{CStr, c_void};

use ash::vk;
use ash::vk::Handle;

use super::status::Failure;

/// A `PFN_vkGetInstanceProcAddr`, which may be null.
pub(super) type GetInstanceProcAddr = Option<vk::PFN_vkGetInstanceProcAddr>;

/// Looks up functions, and keeps the name of the first function of Vulkan 1.0 that the loader does not know.
struct Finder<F> {
    find: F,
    missing: Option<String>,
}

impl<F: Fn(&CStr) -> vk::PFN_vkVoidFunction> Finder<F> {
    fn any(&self, name: &CStr) -> *const c_void {
        (self.find)(name).map_or(std::ptr::null(), |function| function as *const c_void)
    }

    /// Finds a function that Vulkan 1.0 promises. For a missing function, ash substitutes one that panics,
    /// and that panic cannot be caught. So the function is looked up here first.
    fn promised(&mut self, name: &CStr) -> *const c_void {
        let function = self.any(name);
        if function.is_null() {
            self.missing.get_or_insert_with(|| name.to_string_lossy().into_owned());
        }
        function
    }

    fn check(&self, through: &str) -> Result<(), Failure> {
        let Some(missing) = &self.missing else { return Ok(()) };
        Err(Failure::argument(through, format!("knows no function {missing} for these handles")))
    }
}

/// Returns the instance and the physical device.
///
/// # Safety
/// The handles are null or alive, and `get` finds their functions.
pub(super) unsafe fn instance(
    get_instance_proc_addr: GetInstanceProcAddr,
    instance: vk::Instance,
    physical_device: vk::PhysicalDevice,
) -> Result<ash::Instance, Failure> {
    const THROUGH: &str = "get_instance_proc_addr";
    let Some(get) = get_instance_proc_addr else {
        return Err(Failure::argument(THROUGH, "is null"));
    };
    if instance.is_null() {
        return Err(Failure::argument("instance", "is the null handle"));
    }
    if physical_device.is_null() {
        return Err(Failure::argument("physical_device", "is the null handle"));
    }
    // SAFETY: required.
    let find = |name: &CStr| unsafe { get(instance, name.as_ptr()) };
    let mut finder = Finder { find, missing: None };
    let first = ash::InstanceFnV1_0::load(|name| finder.promised(name));
    finder.check(THROUGH)?;
    let second = ash::InstanceFnV1_1::load(|name| finder.any(name));
    let third = ash::InstanceFnV1_3::load(|name| finder.any(name));
    Ok(ash::Instance::from_parts_1_3(instance, first, second, third))
}

/// Returns the device.
///
/// # Safety
/// The handle is null or that of a living device of this instance.
pub(super) unsafe fn device(
    instance: &ash::Instance,
    device: vk::Device,
) -> Result<ash::Device, Failure> {
    if device.is_null() {
        return Err(Failure::argument("device", "is the null handle"));
    }
    let get = instance.fp_v1_0().get_device_proc_addr;
    // SAFETY: required.
    let find = |name: &CStr| unsafe { get(device, name.as_ptr()) };
    let mut finder = Finder { find, missing: None };
    let first = ash::DeviceFnV1_0::load(|name| finder.promised(name));
    finder.check("vkGetDeviceProcAddr")?;
    let second = ash::DeviceFnV1_1::load(|name| finder.any(name));
    let third = ash::DeviceFnV1_2::load(|name| finder.any(name));
    let fourth = ash::DeviceFnV1_3::load(|name| finder.any(name));
    Ok(ash::Device::from_parts_1_3(device, first, second, third, fourth))
}

/// Returns whether the program has enabled `VK_EXT_debug_utils`, so that passes can have labels and objects
/// can have names.
///
/// # Safety
/// The handles are alive. `get_instance_proc_addr` is the function through which [`instance`] found the
/// instance's functions.
pub(super) unsafe fn has_labels(
    get_instance_proc_addr: GetInstanceProcAddr,
    instance: &ash::Instance,
    device: &ash::Device,
) -> bool {
    let names = [
        c"vkCmdBeginDebugUtilsLabelEXT",
        c"vkCmdEndDebugUtilsLabelEXT",
        c"vkSetDebugUtilsObjectNameEXT",
    ];
    let of_device = instance.fp_v1_0().get_device_proc_addr;
    get_instance_proc_addr.is_some_and(|get| {
        // SAFETY: required. Some loaders find functions of extensions that are not enabled, so the device is
        // asked too.
        names.iter().all(|name| unsafe {
            get(instance.handle(), name.as_ptr()).is_some()
                && of_device(device.handle(), name.as_ptr()).is_some()
        })
    })
}
