//! Lists the passes over a batch as plain values that need no device.

use super::schedule::PairwiseSchedule;
use crate::vulkan::device::barrier::{
    Access, HOST_READ, PASS, SHADER_WRITE, TRANSFER_READ, TRANSFER_WRITE,
};
use crate::vulkan::schedules::plan;

/// Step of a recording.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// Copies the progress of the maps, as the host has initialized it, to the buffer that shaders read.
    Begin,
    /// Fills both images, so that no point but the sources is reached.
    Start,
    /// Gives all copies of each source its front.
    ExchangeSources,
    /// Runs iterations of all maps in shared memory.
    Workgroups,
    /// Runs a step of the raster schedule over all maps.
    Raster(plan::Step),
    /// Unpacks the distances from the images.
    Unpack,
    /// Copies the distances to a half of the staging buffer, where the host reads them.
    Bring(usize),
    /// Copies the progress of the maps to the buffer that the host reads.
    Report,
}

impl Step {
    /// Returns the barriers before the step.
    pub(super) fn barriers_before(&self) -> &'static [(Access, Access)] {
        match self {
            Self::Begin => &[(TRANSFER_READ, TRANSFER_WRITE), (PASS, TRANSFER_WRITE)],
            Self::Report | Self::Bring(_) => &[(PASS, TRANSFER_READ)],
            _ => &[],
        }
    }

    /// Returns the barrier after the step.
    pub(super) fn barrier_after(&self) -> (Access, Access) {
        match self {
            Self::Begin => (TRANSFER_WRITE, PASS),
            Self::Start | Self::ExchangeSources | Self::Raster(_) => (PASS, PASS),
            Self::Workgroups | Self::Unpack => (SHADER_WRITE, HOST_READ),
            Self::Report | Self::Bring(_) => (TRANSFER_WRITE, HOST_READ),
        }
    }
}

/// Returns the steps that start a batch and iterate it. For maps in images, `scans` are the steps of the raster
/// schedule. `bring` is the half of the staging buffer to which the distances of maps in shared memory are copied, or
/// `None` if the host reads them in place. For maps in images, [`last`] copies the distances. On a glued surface,
/// `exchanges` is set.
pub(super) fn first(
    schedule: PairwiseSchedule,
    scans: Vec<plan::Step>,
    bring: Option<usize>,
    exchanges: bool,
) -> Vec<Step> {
    let start = (schedule == PairwiseSchedule::Images).then_some(Step::Start);
    let exchange = exchanges.then_some(Step::ExchangeSources);
    let before = [Step::Begin].into_iter().chain(start).chain(exchange);
    before.chain(further(schedule, scans, bring)).collect()
}

/// Returns the steps that continue maps that are not done. A map in shared memory writes its distances at the end of
/// the dispatch in which it is done.
pub(super) fn further(
    schedule: PairwiseSchedule,
    scans: Vec<plan::Step>,
    bring: Option<usize>,
) -> Vec<Step> {
    let mut steps: Vec<_> = match schedule {
        PairwiseSchedule::SharedMemory => {
            [Step::Workgroups].into_iter().chain(bring.map(Step::Bring)).collect()
        }
        PairwiseSchedule::Images => scans.into_iter().map(Step::Raster).collect(),
    };
    steps.push(Step::Report);
    steps
}

/// Returns the steps that unpack the distances of maps in images.
pub(super) fn last(bring: Option<usize>) -> Vec<Step> {
    [Step::Unpack].into_iter().chain(bring.map(Step::Bring)).collect()
}
