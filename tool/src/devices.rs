//! `geosweep devices`: what Vulkan offers, and what devices and processor can do at best.

use std::process::ExitCode;

use geosweep::vulkan::{self, DeviceInfo};
use geosweep::{DeviceChoice, Wavefront, cpu};
use serde::Serialize;

use crate::spinner::Spinner;
use crate::study::label;
use crate::{Outcome, print, say};

/// The arguments of `geosweep devices`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Measure what each usable device and the processor can do at best, in some seconds
    #[arg(long)]
    measure: bool,
    /// Print one JSON array: index, name, kind, api_version, driver, unmet (requirements). With
    /// --measure one object: devices, that array, each usable device with its ceilings; and cpu, an
    /// array of ceilings by number of threads. Rates are per second, times in seconds
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
The index, or any part of the name, selects a device for `geosweep distance --device`.

With --measure: the rate at which bytes are copied (read plus written), the rate of
updates from single triangles with everything at hand, by wavefront; of a device also
the time of an empty dispatch with its barrier, direct and indirect, of an indirect
dispatch of nothing with its barrier, of a barrier alone, of what a timestamp adds
(null or nothing where there are none) and of an empty submission, and the rate of
reading back.

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
    /// What it lacks; empty for a usable device.
    unmet: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    ceilings: Option<DeviceCeilings>,
}

#[derive(Serialize)]
struct Measured<'a> {
    devices: Vec<Device<'a>>,
    cpu: Vec<CpuCeilings>,
}

/// What a device can do at best, in bytes, triangles and seconds.
#[derive(Clone, Copy, Serialize)]
pub struct DeviceCeilings {
    copy: f64,
    triangles: Triangles,
    dispatch: f64,
    indirect_dispatch: f64,
    skipped_dispatch: f64,
    barrier: f64,
    timestamp: Option<f64>,
    submission: f64,
    read_back: f64,
}

/// What some threads can do at best.
#[derive(Clone, Copy, Serialize)]
pub struct CpuCeilings {
    threads: usize,
    copy: f64,
    triangles: Triangles,
}

/// Updates from one triangle a second.
#[derive(Clone, Copy, Serialize)]
struct Triangles {
    planar: f64,
    point: f64,
    curved: f64,
}

pub fn run(args: &Args) -> Outcome {
    let found = match vulkan::devices() {
        Err(error) if args.measure => {
            say("note", format_args!("no Vulkan device: {error}"));
            Vec::new()
        }
        other => other?,
    };
    let mut devices: Vec<_> = found.iter().map(Device::from).collect();
    if !args.measure {
        if args.json {
            print(serde_json::to_string_pretty(&devices)?)?;
        } else {
            devices.iter().try_for_each(print)?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let cpu = {
        let _spinner = Spinner::new("measuring");
        for device in devices.iter_mut().filter(|device| device.unmet.is_empty()) {
            let choice = DeviceChoice::Index(device.index);
            device.ceilings = Some(vulkan::Ceilings::measure(&choice)?.into());
        }
        thread_counts().map(cpu::Ceilings::measure).map(CpuCeilings::from).collect()
    };
    let measured = Measured { devices, cpu };
    print(if args.json { serde_json::to_string_pretty(&measured)? } else { measured.to_string() })?;
    Ok(ExitCode::SUCCESS)
}

/// Powers of two, and all that the machine has.
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

impl From<[f64; 3]> for Triangles {
    fn from([planar, point, curved]: [f64; 3]) -> Self {
        Self { planar, point, curved }
    }
}

impl From<vulkan::Ceilings> for DeviceCeilings {
    fn from(ceilings: vulkan::Ceilings) -> Self {
        Self {
            copy: ceilings.copy,
            triangles: ceilings.triangles.into(),
            dispatch: ceilings.dispatch.as_secs_f64(),
            indirect_dispatch: ceilings.indirect_dispatch.as_secs_f64(),
            skipped_dispatch: ceilings.skipped_dispatch.as_secs_f64(),
            barrier: ceilings.barrier.as_secs_f64(),
            timestamp: ceilings.timestamp.map(|time| time.as_secs_f64()),
            submission: ceilings.submission.as_secs_f64(),
            read_back: ceilings.read_back,
        }
    }
}

impl From<cpu::Ceilings> for CpuCeilings {
    fn from(ceilings: cpu::Ceilings) -> Self {
        let cpu::Ceilings { threads, copy, triangles } = ceilings;
        Self { threads, copy, triangles: triangles.into() }
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

impl std::fmt::Display for DeviceCeilings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { copy, triangles, read_back, .. } = self;
        let [dispatch, indirect, skipped, barrier, submission] = [
            self.dispatch,
            self.indirect_dispatch,
            self.skipped_dispatch,
            self.barrier,
            self.submission,
        ]
        .map(|seconds| 1e6 * seconds);
        write!(
            f,
            "copies {:.1} GB/s; {triangles}; dispatch of one group {dispatch:.2} us, indirect \
             {indirect:.2} us, of none {skipped:.2} us, barrier {barrier:.2} us, ",
            copy / 1e9,
        )?;
        if let Some(timestamp) = self.timestamp {
            write!(f, "timestamp {:.2} us, ", 1e6 * timestamp)?;
        }
        write!(f, "submission {submission:.0} us; reads back {:.1} GB/s", read_back / 1e9)
    }
}

impl std::fmt::Display for CpuCeilings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { threads, copy, triangles } = self;
        let s = if *threads == 1 { "" } else { "s" };
        write!(f, "{threads} thread{s}: copies {:.1} GB/s; {triangles}", copy / 1e9)
    }
}

impl std::fmt::Display for Triangles {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { planar, point, curved } = self;
        f.write_str("triangles a second:")?;
        for (wavefront, rate) in Wavefront::ALL.into_iter().zip([planar, point, curved]) {
            let comma = if wavefront == Wavefront::ALL[0] { "" } else { "," };
            write!(f, "{comma} {} {:.0} M", label(wavefront), rate / 1e6)?;
        }
        Ok(())
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
