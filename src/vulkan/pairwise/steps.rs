//! The list of passes over a batch, as plain values that need no device.

use super::schedule::PairwiseSchedule;
use crate::vulkan::barrier::{Access, CLEAR, COPY, HOST_READ, PASS, SHADER_WRITE};
use crate::vulkan::plan;

/// A step of a recording.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// Copies what the host has written about the maps to where shaders read it.
    Begin,
    /// Fills both images: no point reached but the sources.
    Start,
    /// Iterations of all maps in shared memory.
    Workgroups,
    /// A step of the raster schedule over all maps, and the barrier after it.
    Raster(plan::Step),
    /// Unpacks the distances from the images.
    Unpack,
    /// Copies how the maps have gone to where the host reads it.
    Report,
    /// What was accessed before is complete and visible to what follows. After all steps but those of
    /// the schedule it depends on what comes next.
    Barrier(Access, Access),
}

/// Starts a batch and iterates; `scans` are those of the raster schedule, for maps in images.
pub(super) fn first(schedule: PairwiseSchedule, scans: Vec<plan::Step>) -> Vec<Step> {
    let mut steps = vec![
        Step::Barrier(COPY, CLEAR),
        Step::Barrier(PASS, CLEAR),
        Step::Begin,
        Step::Barrier(CLEAR, PASS),
    ];
    if schedule == PairwiseSchedule::Images {
        steps.extend([Step::Start, Step::Barrier(PASS, PASS)]);
    }
    steps.extend(iterations(schedule, scans));
    steps
}

/// Goes on with maps that are not done.
pub(super) fn further(schedule: PairwiseSchedule, scans: Vec<plan::Step>) -> Vec<Step> {
    let mut steps = vec![Step::Barrier(PASS, PASS)];
    steps.extend(iterations(schedule, scans));
    steps
}

/// Reads maps in images, which are done.
pub(super) fn read() -> Vec<Step> {
    vec![Step::Barrier(PASS, PASS), Step::Unpack, Step::Barrier(SHADER_WRITE, HOST_READ)]
}

fn iterations(schedule: PairwiseSchedule, scans: Vec<plan::Step>) -> Vec<Step> {
    let mut steps = match schedule {
        PairwiseSchedule::SharedMemory => {
            vec![Step::Workgroups, Step::Barrier(SHADER_WRITE, HOST_READ)]
        }
        PairwiseSchedule::Images => scans.into_iter().map(Step::Raster).collect(),
    };
    steps.extend([Step::Barrier(PASS, COPY), Step::Report, Step::Barrier(CLEAR, HOST_READ)]);
    steps
}
