//! Creates the pipelines of all schedules and wavefronts on a device and prints the driver's statistics of
//! them: registers, spills, instructions. Nothing is run, so that a driver which only compiles is enough,
//! such as Mesa's for AMD without a GPU:
//!
//! ```sh
//! VK_DRIVER_FILES=/usr/share/vulkan/icd.d/radeon_icd.x86_64.json RADV_FORCE_FAMILY=navi21 \
//!     cargo run --release --example compile
//! ```
//!
//! An argument is a part of the name of the wanted device.

use std::collections::BTreeMap;
use std::error::Error;
use std::time::Instant;

use geosweep::Wavefront;
use geosweep::ash::{self, khr, vk};
use geosweep::vulkan::embed::{Solver, Tools};
use geosweep::vulkan::{Schedule, requirements};

fn main() -> Result<(), Box<dyn Error>> {
    let wanted = std::env::args().nth(1).unwrap_or_default().to_lowercase();
    // SAFETY: the loader is the system's own.
    let entry = unsafe { ash::Entry::load()? };
    let application = vk::ApplicationInfo::default().api_version(requirements::API_VERSION);
    let info = vk::InstanceCreateInfo::default().application_info(&application);
    // SAFETY: everything that the info points to is alive.
    let instance = unsafe { entry.create_instance(&info, None)? };
    let result = on_instance(&instance, &wanted);
    // SAFETY: the device was destroyed.
    unsafe { instance.destroy_instance(None) };
    result
}

fn on_instance(instance: &ash::Instance, wanted: &str) -> Result<(), Box<dyn Error>> {
    let name_of = |device| {
        // SAFETY: the device is of this instance.
        let properties = unsafe { instance.get_physical_device_properties(device) };
        properties.device_name_as_c_str().unwrap_or(c"unnamed").to_string_lossy().into_owned()
    };
    // SAFETY: the instance is alive.
    let all = unsafe { instance.enumerate_physical_devices()? };
    let found = all.into_iter().find(|&device| name_of(device).to_lowercase().contains(wanted));
    let physical_device = found.ok_or("no such device")?;
    println!("{}", name_of(physical_device));
    let family = requirements::compute_queue_family(instance, physical_device)
        .ok_or("the device has no queue for compute")?;
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
    // SAFETY: the device is of this instance.
    let offered = unsafe { instance.enumerate_device_extension_properties(physical_device)? };
    let name = khr::pipeline_executable_properties::NAME;
    let tells = offered.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name));
    let extensions: Vec<_> = tells.then_some(name.as_ptr()).into_iter().collect();
    let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
        .pipeline_executable_info(true);
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions);
    if tells {
        info = info.push_next(&mut executables);
    }
    // SAFETY: the device has this queue family and offers the extension.
    let device = unsafe { instance.create_device(physical_device, &info, None)? };
    let result = compile(instance, physical_device, &device, tells);
    // SAFETY: the pipelines were destroyed.
    unsafe { device.destroy_device(None) };
    result
}

fn compile(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
    device: &ash::Device,
    tells: bool,
) -> Result<(), Box<dyn Error>> {
    let tools = Tools { executables: tells, ..Tools::default() };
    let begin = Instant::now();
    let mut solver = Solver::with_tools(instance, physical_device, device, &[], tools)?;
    println!("{:>6.2} s  those of every surface", begin.elapsed().as_secs_f64());
    let mut result = Ok(());
    for schedule in Schedule::ALL {
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let begin = Instant::now();
            result = result.and_then(|()| solver.add_passes(device, schedule, wavefront));
            println!("{:>6.2} s  {schedule}, {wavefront}", begin.elapsed().as_secs_f64());
        }
    }
    let told = match (&result, tells) {
        (Ok(()), true) => solver.executables(instance, device),
        _ => Ok(Vec::new()),
    };
    solver.destroy(device);
    result?;
    for executable in told? {
        let numbers: BTreeMap<_, _> = executable
            .statistics
            .iter()
            .filter(|statistic| is_of_interest(&statistic.name))
            .map(|statistic| (statistic.name.as_str(), statistic.value))
            .collect();
        let numbers: Vec<_> =
            numbers.iter().map(|(name, value)| format!("{name} {value}")).collect();
        println!("{}: {}", executable.pipeline, numbers.join(", "));
    }
    Ok(())
}

/// Returns whether a statistic is printed. Drivers report many more.
fn is_of_interest(statistic: &str) -> bool {
    let words =
        ["gpr", "spill", "scratch", "instructions", "instruction count", "code size", "lds"];
    words.iter().any(|word| statistic.to_lowercase().contains(word))
}
