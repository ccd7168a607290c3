//! Defines the JSON format of a profile.

use std::time::Duration;

use geosweep::vulkan::profile::{Capability, Executable, Grain, SolveProfile, Statistic};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::kinds::{Kind, kinds, median};
use super::measure::Measured;
use crate::ceilings::DeviceCeilings;

/// A profile.
#[derive(Serialize)]
pub struct Summary {
    #[serde(flatten)]
    pub setting: Setting,
    pub iterations: u32,
    pub residual: f64,
    pub converged: bool,
    /// The capabilities by name: whether each is available, or why not.
    pub capabilities: Map<String, Value>,
    pub ceilings: DeviceCeilings,
    pub executables: Vec<Value>,
    pub runs: usize,
    pub kinds: Vec<Kind>,
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
        let offered = |capability| match measured.capabilities.reason(capability) {
            None => true.into(),
            Some(reason) => reason.to_string().into(),
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
            capabilities: Capability::ALL
                .map(|one| (one.name().into(), offered(one)))
                .into_iter()
                .collect(),
            ceilings: measured.ceilings.into(),
            executables: measured.executables.iter().map(executable).collect(),
            runs: measured.runs.len(),
            kinds: kinds(measured, median(&passes)),
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

/// Returns a pipeline, as compiled by its driver, as JSON.
fn executable(found: &Executable) -> Value {
    let statistic = |one: &Statistic| (one.name.clone(), one.value.into());
    json!({
        "pipeline": found.pipeline,
        "name": found.name,
        "subgroup_size": found.subgroup_size,
        "statistics": found.statistics.iter().map(statistic).collect::<Map<_, _>>(),
    })
}
