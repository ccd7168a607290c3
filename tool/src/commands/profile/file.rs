//! Defines the JSON format of a profile.

use std::collections::BTreeMap;
use std::time::Duration;

use geosweep::vulkan::profile::{Capability, Grain, SolveProfile};
use serde::{Deserialize, Serialize};

use super::kinds::{Kind, kinds, median};
use super::measure::Measured;
use crate::ceilings::{DeviceCeilings, Shares};

/// A profile.
#[derive(Serialize)]
pub struct Summary {
    #[serde(flatten)]
    pub setting: Setting,
    pub iterations: u32,
    pub residual: f64,
    pub converged: bool,
    /// The capabilities by name: whether each is available, or why not.
    pub capabilities: BTreeMap<&'static str, Offered>,
    pub ceilings: DeviceCeilings,
    pub executables: Vec<Executable>,
    pub runs: usize,
    pub kinds: Vec<KindRow>,
    pub total: Total,
}

/// The settings that two profiles must share to be comparable.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setting {
    pub device: String,
    pub driver: String,
    pub rows: usize,
    pub cols: usize,
    /// The number of maps computed at once. Older profiles have neither this field nor `grain`.
    #[serde(default = "one")]
    pub maps: usize,
    pub schedule: String,
    pub wavefront: String,
    /// The grain of the timestamps.
    #[serde(default = "scans")]
    pub grain: String,
}

fn one() -> usize {
    1
}

fn scans() -> String {
    Grain::Scans.name().into()
}

#[derive(Serialize)]
#[serde(untagged)]
pub enum Offered {
    Is(bool),
    Not(String),
}

/// A pipeline as compiled by its driver.
#[derive(Serialize)]
pub struct Executable {
    pub pipeline: String,
    pub name: String,
    pub subgroup_size: u32,
    pub statistics: BTreeMap<String, f64>,
}

/// All passes of one kind.
#[derive(Serialize)]
pub struct KindRow {
    pub name: &'static str,
    pub count: usize,
    pub dispatches: u64,
    pub seconds: Vec<f64>,
    pub median_seconds: Option<f64>,
    pub median_pass_seconds: Option<f64>,
    /// The share of the time of all passes.
    pub share: Option<f64>,
    pub texels: Option<u64>,
    pub skipped: Option<u64>,
    pub bytes_read: Option<u64>,
    pub bytes_written: Option<u64>,
    pub triangles: Option<u64>,
    pub invocations: Option<u64>,
    pub shares: Shares,
}

/// The times of each run, in seconds.
#[derive(Serialize)]
pub struct Total {
    /// The time of all passes on the device.
    pub passes: Vec<f64>,
    /// The time of the passes divided by that of the command buffers, from a run in which both were measured.
    pub share_of_command_buffers: Option<f64>,
    /// The time on the host's clock.
    pub host: Vec<f64>,
    /// The time on the host's clock without profiling.
    pub host_without_profiling: Vec<f64>,
}

impl Summary {
    pub fn new(measured: &Measured) -> Self {
        let passes = measured.runs.iter().filter_map(SolveProfile::pass_nanoseconds);
        let passes: Vec<_> = passes.map(|nanoseconds| 1e-9 * nanoseconds as f64).collect();
        let all = median(&passes);
        let offered = |capability| match measured.capabilities.reason(capability) {
            None => Offered::Is(true),
            Some(reason) => Offered::Not(reason.to_string()),
        };
        let host = measured.runs.iter().map(|run| run.time);
        Self {
            setting: Setting {
                device: measured.device.clone(),
                driver: measured.driver.clone(),
                rows: measured.chart.rows,
                cols: measured.chart.cols,
                maps: measured.solved.maps(),
                schedule: measured.solved.schedule(),
                wavefront: measured.wavefront.name().into(),
                grain: measured.grain.name().into(),
            },
            iterations: measured.iterations,
            residual: measured.residual,
            converged: measured.converged,
            capabilities: Capability::ALL.map(|one| (one.name(), offered(one))).into(),
            ceilings: measured.ceilings.into(),
            executables: measured.executables.iter().map(Executable::from).collect(),
            runs: measured.runs.len(),
            kinds: kinds(measured).into_iter().map(|kind| KindRow::new(kind, all)).collect(),
            total: Total {
                passes,
                share_of_command_buffers: measured
                    .counted
                    .pass_nanoseconds()
                    .zip(measured.counted.nanoseconds().filter(|&whole| whole > 0))
                    .map(|(passes, whole)| passes as f64 / whole as f64),
                host: host.map(|time| time.as_secs_f64()).collect(),
                host_without_profiling: measured.plain.iter().map(Duration::as_secs_f64).collect(),
            },
        }
    }
}

impl KindRow {
    fn new(kind: Kind, all: Option<f64>) -> Self {
        let Kind { name, count, dispatches, work, invocations, seconds, median_pass, shares } =
            kind;
        let median_seconds = median(&seconds);
        Self {
            name,
            count,
            dispatches,
            seconds,
            median_seconds,
            median_pass_seconds: median_pass,
            share: median_seconds.zip(all).map(|(seconds, all)| seconds / all),
            texels: work.texels,
            skipped: work.skipped,
            bytes_read: work.bytes_read,
            bytes_written: work.bytes_written,
            triangles: work.triangles,
            invocations,
            shares,
        }
    }

    /// Returns the share of the texels that were not visited, thanks to bounds, lists and convergence.
    pub fn skipped_share(&self) -> Option<f64> {
        let (texels, skipped) = (self.texels? as f64, self.skipped? as f64);
        (texels + skipped > 0.0).then(|| skipped / (texels + skipped))
    }
}

impl From<&geosweep::vulkan::profile::Executable> for Executable {
    fn from(found: &geosweep::vulkan::profile::Executable) -> Self {
        let statistic = |one: &geosweep::vulkan::profile::Statistic| (one.name.clone(), one.value);
        Self {
            pipeline: found.pipeline.clone(),
            name: found.name.clone(),
            subgroup_size: found.subgroup_size,
            statistics: found.statistics.iter().map(statistic).collect(),
        }
    }
}
