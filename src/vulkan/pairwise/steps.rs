//! Lists the passes over a batch as plain values that need no device.

use super::schedule::PairwiseSchedule;
use crate::vulkan::device::barrier::{Access, CLEAR, COPY, HOST_READ, PASS, SHADER_WRITE};
use crate::vulkan::schedules::plan;

/// Step of a recording.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// Copies what the host has written about the maps to where shaders read it.
    Begin,
    /// Fills both images, so that no point but the sources is reached.
    Start,
    /// Runs iterations of all maps in shared memory.
    Workgroups,
    /// Runs a step of the raster schedule over all maps.
    Raster(plan::Step),
    /// Unpacks the distances from the images.
    Unpack,
    /// Copies the progress of the maps to where the host reads it.
    Report,
}

impl Step {
    /// Returns the barriers before the step.
    pub(super) fn waits(&self) -> &'static [(Access, Access)] {
        match self {
            Self::Begin => &[(COPY, CLEAR), (PASS, CLEAR)],
            Self::Report => &[(PASS, COPY)],
            _ => &[],
        }
    }

    /// Returns the barrier after the step.
    pub(super) fn ends(&self) -> (Access, Access) {
        match self {
            Self::Begin => (CLEAR, PASS),
            Self::Start | Self::Raster(_) => (PASS, PASS),
            Self::Workgroups | Self::Unpack => (SHADER_WRITE, HOST_READ),
            Self::Report => (CLEAR, HOST_READ),
        }
    }
}

/// Returns the steps that start a batch and iterate it. `scans` are those of the raster schedule, for maps in
/// images.
pub(super) fn first(schedule: PairwiseSchedule, scans: Vec<plan::Step>) -> Vec<Step> {
    let start = (schedule == PairwiseSchedule::Images).then_some(Step::Start);
    [Step::Begin].into_iter().chain(start).chain(further(schedule, scans)).collect()
}

/// Returns the steps that continue maps that are not done.
pub(super) fn further(schedule: PairwiseSchedule, scans: Vec<plan::Step>) -> Vec<Step> {
    let mut steps = match schedule {
        PairwiseSchedule::SharedMemory => vec![Step::Workgroups],
        PairwiseSchedule::Images => scans.into_iter().map(Step::Raster).collect(),
    };
    steps.push(Step::Report);
    steps
}
