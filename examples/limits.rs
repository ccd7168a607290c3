//! What Vulkan devices say of themselves, as far as it bears on maps. Prints Markdown.
//!
//! `cargo run --release --example limits -- [PART_OF_A_NAME]`

use std::error::Error;

use geosweep::ash::{self, vk};
use geosweep::vulkan::requirements;

fn main() -> Result<(), Box<dyn Error>> {
    let wanted = std::env::args().nth(1).unwrap_or_default().to_lowercase();
    // SAFETY: the loader's functions are called as they are meant to be; the entry outlives the instance.
    unsafe {
        let entry = ash::Entry::load()?;
        let application = vk::ApplicationInfo::default().api_version(requirements::API_VERSION);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        let instance = entry.create_instance(&info, None)?;
        for device in instance.enumerate_physical_devices()? {
            let text = about(&instance, device);
            if text.lines().any(|line| line.to_lowercase().contains(&wanted)) {
                println!("{text}");
            }
        }
        instance.destroy_instance(None);
    }
    Ok(())
}

fn about(instance: &ash::Instance, device: vk::PhysicalDevice) -> String {
    // SAFETY: the physical device is from this instance.
    let (properties, subgroup, memory, families) = unsafe {
        let mut subgroups = vk::PhysicalDeviceSubgroupProperties::default();
        let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut subgroups);
        instance.get_physical_device_properties2(device, &mut all);
        let properties = all.properties;
        let memory = instance.get_physical_device_memory_properties(device);
        let families = instance.get_physical_device_queue_family_properties(device);
        (properties, subgroups.subgroup_size, memory, families)
    };
    let limits = properties.limits;
    let version = |v: u32| {
        let (major, minor) = (vk::api_version_major(v), vk::api_version_minor(v));
        format!("{major}.{minor}.{}", vk::api_version_patch(v))
    };
    let heap = |heap: &vk::MemoryHeap| {
        let is_own = heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
        let gib = heap.size as f64 / (1u64 << 30) as f64;
        format!("{gib:.1} GiB ({})", if is_own { "the device's" } else { "the host's" })
    };
    let family = |family: &vk::QueueFamilyProperties| {
        let (count, bits) = (family.queue_count, family.timestamp_valid_bits);
        format!("{count} of {:?}, timestamps of {bits} bits", family.queue_flags)
    };
    let [heaps, queues] = [
        memory.memory_heaps_as_slice().iter().map(heap).collect::<Vec<_>>(),
        families.iter().map(family).collect(),
    ];
    let unmet = match requirements::unmet(instance, device) {
        none if none.is_empty() => "nothing".into(),
        some => some.join("; "),
    };
    let name = properties.device_name_as_c_str().unwrap_or(c"").to_string_lossy();
    let lines = [
        ("device", name.into_owned()),
        ("kind", format!("{:?}", properties.device_type)),
        ("vendor, device", format!("{:#06x}, {:#06x}", properties.vendor_id, properties.device_id)),
        ("Vulkan", version(properties.api_version)),
        ("driver's version", format!("{:#010x}", properties.driver_version)),
        ("what it lacks", unmet),
        ("invocations of a subgroup", subgroup.to_string()),
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
