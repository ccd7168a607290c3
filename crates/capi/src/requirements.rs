//! Requirements that a device must meet, known before it is created.

use std::ffi::c_char;

use ash::vk;

use super::arguments::{Output, chart, write};
use super::choices::{ScheduleNumber, number};
use super::loader::{self, GetInstanceProcAddr};
use super::status::{Failure, calls};
use geosweep::vulkan::{Schedule, requirements};

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

const _: () = assert!(requirements::DEVICE_EXTENSIONS.is_empty(), "list them for C");

calls! {
    /// Returns the requirements for the instance and the device.
    fn geosweep_requirements(requirements: *mut GeosweepRequirements) {
        let needed = GeosweepRequirements {
            api_version: requirements::API_VERSION,
            device_extension_count: 0,
            device_extensions: std::ptr::null(),
            features: requirements::features(),
        };
        write(requirements, "requirements", needed)?;
    }

    /// Checks whether a physical device can be used, before a device is created on it. If not, the status is
    /// `GEOSWEEP_STATUS_UNSUPPORTED`, and the message lists all that is missing. An instance that was created for
    /// Vulkan 1.0 cannot be used either. Only a device shows the version for which its instance was created, so
    /// this call creates a device and destroys it.
    fn geosweep_check_device(
        get_instance_proc_addr: GetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
    ) {
        let instance = loader::instance(get_instance_proc_addr, instance, physical_device)?;
        let mut unmet = requirements::unmet(&instance, physical_device);
        if unmet.is_empty() && is_for_vulkan_1_0(&instance, physical_device) {
            unmet.push(requirements::FOR_VULKAN_1_0.into());
        }
        if !unmet.is_empty() {
            return Err(Failure::unsupported(unmet.join("; ")));
        }
    }

    /// Finds a queue family for compute. Prefers a family without graphics, which is the one for asynchronous
    /// compute on large GPUs. Any family with `VK_QUEUE_COMPUTE_BIT` can be used.
    fn geosweep_compute_queue_family(
        get_instance_proc_addr: GetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        family: *mut u32,
    ) {
        let output = Output::new(family, "family")?;
        let instance = loader::instance(get_instance_proc_addr, instance, physical_device)?;
        let found = requirements::compute_queue_family(&instance, physical_device);
        let none = || Failure::unsupported("the device has no queue for compute".into());
        output.write(found.ok_or_else(none)?);
    }

    /// Returns the schedule that `GEOSWEEP_SCHEDULE_BEST` stands for on a device, for grids of `rows` rows and
    /// `cols` columns. It tells which schedule to create a solver for.
    fn geosweep_best_schedule(
        get_instance_proc_addr: GetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        rows: u32,
        cols: u32,
        schedule: *mut ScheduleNumber,
    ) {
        let output = Output::new(schedule, "schedule")?;
        let instance = loader::instance(get_instance_proc_addr, instance, physical_device)?;
        let properties = instance.get_physical_device_properties(physical_device);
        let best = Schedule::best_on(properties.device_type, chart(rows, cols)?);
        output.write(number(Some(best)));
    }
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
