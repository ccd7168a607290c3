//! What a device must offer, before it is created.

use std::ffi::c_char;
use std::sync::LazyLock;

use ash::vk;

use super::arguments::Output;
use super::choices::{ScheduleNumber, schedule_number};
use super::loader::{self, GetInstanceProcAddr};
use super::plan::chart;
use super::status::{Failure, GeosweepStatus, guard};
use crate::vulkan::{Schedule, requirements};

/// What instance and device must be created with, for a program to merge with its own wishes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepRequirements {
    /// For `VkApplicationInfo::apiVersion`, which may be higher.
    pub api_version: u32,
    /// For `VkDeviceCreateInfo::enabledExtensionCount`. None are needed so far.
    pub device_extension_count: u32,
    /// For `VkDeviceCreateInfo::ppEnabledExtensionNames`: as many names, which are never freed. Null
    /// if there are none.
    pub device_extensions: *const *const c_char,
    /// For `VkDeviceCreateInfo::pEnabledFeatures`, or for the features of a
    /// `VkPhysicalDeviceFeatures2`. None are needed so far.
    pub features: vk::PhysicalDeviceFeatures,
}

/// Names that are never freed.
struct Names(Vec<*const c_char>);

// SAFETY: the pointers are those of constants.
unsafe impl Send for Names {}
// SAFETY: as above.
unsafe impl Sync for Names {}

static EXTENSIONS: LazyLock<Names> = LazyLock::new(|| {
    Names(requirements::DEVICE_EXTENSIONS.iter().map(|name| name.as_ptr()).collect())
});

/// Says what instance and device must be created with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_requirements(
    requirements: *mut GeosweepRequirements,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let output = unsafe { Output::new(requirements, "requirements") }?;
        let names = &EXTENSIONS.0;
        output.write(GeosweepRequirements {
            api_version: requirements::API_VERSION,
            device_extension_count: names.len() as u32,
            device_extensions: if names.is_empty() { std::ptr::null() } else { names.as_ptr() },
            features: requirements::features(),
        });
        Ok(())
    })
}

/// Asks whether a physical device will do, before a device is created on it. If not, the status is
/// `GEOSWEEP_STATUS_UNSUPPORTED`, and the message names all that is missing. An instance for Vulkan 1.0 will not do
/// either, of which devices alone tell: one is created and destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_check_device(
    get_instance_proc_addr: GetInstanceProcAddr,
    instance: vk::Instance,
    physical_device: vk::PhysicalDevice,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let instance =
            unsafe { loader::instance(get_instance_proc_addr, instance, physical_device) }?;
        let mut unmet = requirements::unmet(&instance, physical_device);
        if unmet.is_empty() && is_for_vulkan_1_0(&instance, physical_device) {
            unmet.push(requirements::FOR_VULKAN_1_0.into());
        }
        if unmet.is_empty() { Ok(()) } else { Err(Failure::unsupported(unmet.join("; "))) }
    })
}

/// Whether devices of the instance know no function of Vulkan 1.1. Loaders hand out functions of instances that these
/// were not created for.
fn is_for_vulkan_1_0(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> bool {
    let Some(family) = requirements::compute_queue_family(instance, physical_device) else {
        return false;
    };
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
    // SAFETY: the physical device is from this instance, and has the family.
    let Ok(device) = (unsafe { instance.create_device(physical_device, &info, None) }) else {
        // The program will be told so too, by its own call.
        return false;
    };
    let is_old = requirements::is_for_vulkan_1_0(instance, &device);
    // SAFETY: nothing was made from it.
    unsafe { device.destroy_device(None) };
    is_old
}

/// Finds a queue family for compute, one without graphics if there is one: on large GPUs that is
/// the asynchronous one. Any family with `VK_QUEUE_COMPUTE_BIT` will do.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_compute_queue_family(
    get_instance_proc_addr: GetInstanceProcAddr,
    instance: vk::Instance,
    physical_device: vk::PhysicalDevice,
    family: *mut u32,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (output, instance) = unsafe {
            let output = Output::new(family, "family")?;
            (output, loader::instance(get_instance_proc_addr, instance, physical_device)?)
        };
        let found = requirements::compute_queue_family(&instance, physical_device);
        output.write(
            found.ok_or_else(|| {
                Failure::unsupported("the device has no queue for compute".into())
            })?,
        );
        Ok(())
    })
}

/// Says which schedule `GEOSWEEP_SCHEDULE_BEST` stands for, for grids of so many rows and columns on a device: what
/// a solver should be made for, before it is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_best_schedule(
    get_instance_proc_addr: GetInstanceProcAddr,
    instance: vk::Instance,
    physical_device: vk::PhysicalDevice,
    rows: u32,
    cols: u32,
    schedule: *mut ScheduleNumber,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (output, instance) = unsafe {
            let output = Output::new(schedule, "schedule")?;
            (output, loader::instance(get_instance_proc_addr, instance, physical_device)?)
        };
        // SAFETY: the physical device is from this instance.
        let properties = unsafe { instance.get_physical_device_properties(physical_device) };
        let best = Schedule::best_on(properties.device_type, chart(rows, cols)?);
        output.write(schedule_number(best));
        Ok(())
    })
}
