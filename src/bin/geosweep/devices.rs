//! `geosweep devices`: what Vulkan offers.

use std::process::ExitCode;

use geosweep::vulkan::{self, DeviceInfo};
use serde::Serialize;

use crate::{Outcome, print};

/// The arguments of `geosweep devices`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Print one JSON array: index, name, kind, api_version, driver, unmet (requirements)
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
The index, or any part of the name, selects a device for `geosweep distance --device`.

Examples:
  geosweep devices
  geosweep devices --json";

#[derive(Serialize)]
struct Device<'a> {
    index: usize,
    name: &'a str,
    kind: &'a str,
    api_version: &'a str,
    driver: &'a str,
    /// What it lacks; empty for a usable device.
    unmet: &'a [String],
}

pub fn run(args: &Args) -> Outcome {
    let found = vulkan::devices()?;
    let devices: Vec<_> = found.iter().map(Device::from).collect();
    if args.json {
        print(serde_json::to_string_pretty(&devices)?)?;
    } else if devices.is_empty() {
        print("Vulkan offers no device")?;
    } else {
        devices.iter().try_for_each(print)?;
    }
    Ok(ExitCode::SUCCESS)
}

impl<'a> From<&'a DeviceInfo> for Device<'a> {
    fn from(info: &'a DeviceInfo) -> Self {
        let DeviceInfo { index, name, kind, api_version, driver, unmet } = info;
        Self { index: *index, name, kind, api_version, driver, unmet }
    }
}

impl std::fmt::Display for Device<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { index, name, kind, api_version, driver, unmet } = self;
        write!(f, "{index}: {name} ({kind}, Vulkan {api_version}, {driver})")?;
        match unmet {
            [] => Ok(()),
            _ => write!(f, "\n   not usable: {}", unmet.join("; ")),
        }
    }
}
