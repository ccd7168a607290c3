//! Implements `geosweep devices`, which lists Vulkan devices and measures the peak rates of devices and
//! processor.

use std::process::ExitCode;

use geosweep::vulkan::{self, DeviceInfo};
use geosweep::{DeviceChoice, cpu};
use serde::Serialize;

use super::limits;
use crate::ceilings::{CpuCeilings, DeviceCeilings};
use crate::terminal::{List, Outcome, Spinner, print, print_json};

/// The arguments of `geosweep devices`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Measure the peak rates of each usable device and of the processor, which takes some seconds
    #[arg(long)]
    measure: bool,
    /// Print, as Markdown, the properties of each device that matter for maps: its limits, queues and memory
    #[arg(long, conflicts_with_all = ["measure", "json"])]
    limits: bool,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
The index, or any part of the name, selects a device for `geosweep distance --device`.

With --measure: the rate at which bytes are copied (read plus written), and by wavefront
the rate of updates from single triangles whose inputs are in registers. For a device
these follow: the times of an empty dispatch with its barrier, direct and indirect, of
an indirect dispatch of no groups with its barrier, of a barrier alone, of a timestamp
(null or nothing if there are none) and of an empty submission; and the rate of reading
back.

Examples:
  geosweep devices
  geosweep devices --measure
  geosweep devices --json";

#[derive(Serialize)]
struct Device<'a> {
    index: usize,
    name: &'a str,
    kind: &'a str,
    api_version: &'a str,
    driver: &'a str,
    /// The requirements that the device does not meet; empty for a usable device.
    unmet: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    ceilings: Option<DeviceCeilings>,
}

#[derive(Serialize)]
struct Measured<'a> {
    devices: Vec<Device<'a>>,
    cpu: Vec<CpuCeilings>,
}

pub fn run(args: &Args) -> Outcome {
    if args.limits {
        print(limits::of_devices()?.join("\n").trim_end())?;
        return Ok(ExitCode::SUCCESS);
    }
    let found = match vulkan::devices() {
        Err(error) if args.measure => {
            note!("no Vulkan device: {error}");
            Vec::new()
        }
        other => other?,
    };
    let mut devices: Vec<_> = found.iter().map(Device::from).collect();
    if !args.measure {
        if args.json {
            print_json("devices", &List("devices", &devices))?;
        } else {
            devices.iter().try_for_each(print)?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let cpu = {
        let _spinner = Spinner::new("measuring");
        for device in devices.iter_mut().filter(|device| device.unmet.is_empty()) {
            let choice = DeviceChoice::Index(device.index);
            device.ceilings = Some(vulkan::DeviceCeilings::measure(&choice)?.into());
        }
        thread_counts().map(cpu::CpuCeilings::measure).map(CpuCeilings::from).collect()
    };
    let measured = Measured { devices, cpu };
    if args.json {
        print_json("devices", &measured)?;
    } else {
        print(&measured)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the powers of two below the number of hardware threads, and that number.
fn thread_counts() -> impl Iterator<Item = usize> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let powers = std::iter::successors(Some(1), |count| Some(2 * count));
    powers.take_while(move |&count| count < all).chain([all])
}

impl<'a> From<&'a DeviceInfo> for Device<'a> {
    fn from(info: &'a DeviceInfo) -> Self {
        let DeviceInfo { index, name, kind, api_version, driver, unmet } = info;
        Self { index: *index, name, kind, api_version, driver, unmet, ceilings: None }
    }
}

impl std::fmt::Display for Device<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { index, name, kind, api_version, driver, unmet, ceilings } = self;
        write!(f, "{index}: {name} ({kind}, Vulkan {api_version}, {driver})")?;
        if !unmet.is_empty() {
            write!(f, "\n   not usable: {}", unmet.join("; "))?;
        }
        match ceilings {
            Some(ceilings) => write!(f, "\n   {ceilings}"),
            None => Ok(()),
        }
    }
}

impl std::fmt::Display for Measured<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for device in &self.devices {
            writeln!(f, "{device}")?;
        }
        write!(f, "CPU ({}):", cpu::Instructions::best())?;
        self.cpu.iter().try_for_each(|ceilings| write!(f, "\n   {ceilings}"))
    }
}
