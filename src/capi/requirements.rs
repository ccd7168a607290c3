//! Requirements that a device must meet, known before it is created.

use std::ffi::c_char;
use std::sync::LazyLock;

use ash::vk;

use super::arguments::{Output, chart};
use super::choices::{ScheduleNumber, schedule_number};
use super::loader::{self, GetInstanceProcAddr};
use super::status::{Failure, GeosweepStatus, guard};
use crate::vulkan::Schedule;
use crate::vulkan::device::requirements;

/// Requirements for the instance and the device, to be merged with those of the program.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepRequirements {
    /// Lowest version for `VkApplicationInfo::apiVersion`. The program may use a higher one.
    pub api_version: u32,
    /// Number of extensions for `VkDeviceCreateInfo::enabledExtensionCount`. It is 0 so far.
    pub device_extension_count: u32,
    /// Names for `VkDeviceCreateInfo::ppEnabledExtensionNames`, which are never freed. Null if there are
    /// none.
    pub device_extensions: *const *const c_char,
    /// Features for `VkDeviceCreateInfo::pEnabledFeatures` or for the features of a
    /// `VkPhysicalDeviceFeatures2`. None are needed so far.
    pub features: vk::PhysicalDeviceFeatures,
}

/// Names that are never freed.
struct Names(Vec<*const c_char>);

// SAFETY: the pointers point to constants.
unsafe impl Send for Names {}
// SAFETY: as above.
unsafe impl Sync for Names {}

static EXTENSIONS: LazyLock<Names> = LazyLock::new(|| {
    Names(requirements::DEVICE_EXTENSIONS.iter().map(|name| name.as_ptr()).collect())
});

/// Returns the requirements for the instance and the device.
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

/// Checks whether a physical device can be used, before a device is created on it. If not, the status is
/// `GEOSWEEP_STATUS_UNSUPPORTED`, and the message lists all that is missing. An instance that was created for
/// Vulkan 1.0 cannot be used either. Only a device shows the version for which its instance was created, so
/// this call creates a device and destroys it.
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

/// Returns whether the instance was created for Vulkan 1.0, so that its devices know no function of Vulkan
/// 1.1. The instance's own functions do not show this version: loaders return them whatever version the
/// instance was created for.
fn is_for_vulkan_1_0(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> bool {
    let Some(family) = requirements::compute_queue_family(instance, physical_device) else {
        return false;
    };
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
    let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
    // SAFETY: the physical device is from this instance, and has the family.
    let Ok(device) = (unsafe { instance.create_device(physical_device, &info, None) }) else {
        // The program's own call will fail in the same way.
        return false;
    };
    let is_old = requirements::is_for_vulkan_1_0(instance, &device);
    // SAFETY: nothing was created from the device.
    unsafe { device.destroy_device(None) };
    is_old
}

/// Finds a queue family for compute. Prefers a family without graphics, which is the one for asynchronous
/// compute on large GPUs. Any family with `VK_QUEUE_COMPUTE_BIT` can be used.
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

/// Returns the schedule that `GEOSWEEP_SCHEDULE_BEST` stands for on a device, for grids of `rows` rows and
/// `cols` columns. It tells which schedule to create a solver for.
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
