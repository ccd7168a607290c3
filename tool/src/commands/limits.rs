//! Reports the limits of Vulkan devices that matter for maps.

use std::error::Error;

use geosweep::ash::{self, vk};
use geosweep::vulkan::requirements;

/// Returns one table per device, in the order of `geosweep devices`.
pub fn of_devices() -> Result<Vec<String>, Box<dyn Error>> {
    let application = vk::ApplicationInfo::default().api_version(requirements::API_VERSION);
    let info = vk::InstanceCreateInfo::default().application_info(&application);
    // SAFETY: the loader is Vulkan's. The instance is destroyed after its last use, and before `entry` is
    // dropped.
    unsafe {
        let entry = ash::Entry::load()?;
        let instance = entry.create_instance(&info, None)?;
        let found = instance.enumerate_physical_devices();
        let tables =
            found.map(|found| found.into_iter().map(|one| table(&instance, one)).collect());
        instance.destroy_instance(None);
        Ok(tables?)
    }
}

fn table(instance: &ash::Instance, device: vk::PhysicalDevice) -> String {
    let mut subgroups = vk::PhysicalDeviceSubgroupProperties::default();
    // SAFETY: the physical device is from this instance.
    let (properties, memory, families) = unsafe {
        let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut subgroups);
        instance.get_physical_device_properties2(device, &mut all);
        (
            all.properties,
            instance.get_physical_device_memory_properties(device),
            instance.get_physical_device_queue_family_properties(device),
        )
    };
    let limits = properties.limits;
    let heap = |heap: &vk::MemoryHeap| {
        let is_own = heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
        let gib = heap.size as f64 / f64::from(1 << 30);
        format!("{gib:.1} GiB ({})", if is_own { "the device's" } else { "the host's" })
    };
    let family = |family: &vk::QueueFamilyProperties| {
        let (count, bits) = (family.queue_count, family.timestamp_valid_bits);
        // A vertical bar would end the cell of the table.
        let flags = format!("{:?}", family.queue_flags).replace(" | ", ", ");
        format!("{count} of {flags} with timestamps of {bits} bits")
    };
    let heaps: Vec<_> = memory.memory_heaps_as_slice().iter().map(heap).collect();
    let queues: Vec<_> = families.iter().map(family).collect();
    let name = properties.device_name_as_c_str().unwrap_or(c"").to_string_lossy();
    let lines = [
        ("device", name.into_owned()),
        ("vendor, device", format!("{:#06x}, {:#06x}", properties.vendor_id, properties.device_id)),
        ("driver's version", format!("{:#010x}", properties.driver_version)),
        ("invocations of a subgroup", subgroups.subgroup_size.to_string()),
        ("of a workgroup", limits.max_compute_work_group_invocations.to_string()),
        ("size of a workgroup", format!("{:?}", limits.max_compute_work_group_size)),
        ("workgroups of a dispatch", format!("{:?}", limits.max_compute_work_group_count)),
        ("shared memory", format!("{} bytes", limits.max_compute_shared_memory_size)),
        ("texels on a side of an image", limits.max_image_dimension2_d.to_string()),
        ("storage images a stage", limits.max_per_stage_descriptor_storage_images.to_string()),
        ("storage buffers a stage", limits.max_per_stage_descriptor_storage_buffers.to_string()),
        ("descriptor sets", limits.max_bound_descriptor_sets.to_string()),
        ("push constants", format!("{} bytes", limits.max_push_constants_size)),
        ("tick of a timestamp", format!("{} ns", limits.timestamp_period)),
        ("queues", queues.join("; ")),
        ("memory", heaps.join(", ")),
    ];
    let lines = lines.map(|(what, value)| format!("| {what} | {value} |\n"));
    format!("| | |\n|---|---|\n{}", lines.concat())
}
