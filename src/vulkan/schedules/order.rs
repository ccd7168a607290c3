//! Defines the interface of a schedule, and the functions with which all schedules record.

use ash::vk;
use bytemuck::{Pod, bytes_of};

#[cfg(doc)]
use super::plan;
use super::plan::{Portions, Reached, Step};
use super::progress::{Progress, offset};
use crate::vulkan::TexelChart;
use crate::vulkan::device::passes::{Pass, Variant};
use crate::vulkan::record::{Groups, Recorder};

/// Interface of a schedule: its passes, plan and recording.
pub(super) trait ScheduleKind: Sync {
    /// Returns the numbers of the schedule's passes in the table, without the common passes. Each wavefront
    /// has pipelines of its own for them.
    fn passes(&self) -> &'static [usize];

    /// Returns the steps of a recording; see [`crate::vulkan::Schedule::plan`].
    fn plan(
        &self,
        texels: TexelChart,
        portions: Portions,
        reached: Option<Reached>,
        most: u32,
    ) -> Vec<Step>;

    /// Returns whether the schedule runs rounds over lists that the device makes. A recording contains one
    /// sequence of rounds.
    fn has_rounds(&self) -> bool;

    /// Returns the largest number of iterations or rounds in a headless submission. It matters for schedules whose
    /// plans cannot be cut ([`plan::parts`]).
    fn together(&self, _: TexelChart, _: Portions) -> u32 {
        u32::MAX
    }

    /// Returns whether solving the surroundings of sources between grid points first saves iterations of the map.
    fn gains_by_surroundings(&self) -> bool {
        false
    }

    /// Returns the number of words that [`ScheduleKind::start`] writes.
    fn start_words(&self, _: &Recorder) -> u64 {
        0
    }

    /// Writes the schedule's own state, before the seeds of a map or of sources that are added to one.
    fn start(&self, _: &Recorder, _is_added: bool) {}

    /// Records the passes that must precede further steps of a map, if there are any.
    fn go_on(&self, _: &Recorder) {}

    /// Records a step of the schedule.
    fn record(&self, recording: &mut Steps, step: &Step);
}

/// Recording of steps.
pub(super) struct Steps<'r, 'a> {
    pub(super) recorder: &'r Recorder<'a>,
    pub(super) variant: Variant,
    pub(super) bound: Option<(vk::Pipeline, usize)>,
    /// Number of blocks of scans, counted from the first, for which the device notes whether it visited them.
    pub(super) notes: u32,
    /// Number of blocks of scans so far.
    pub(super) scans: u32,
}

impl Steps<'_, '_> {
    /// Dispatches a pass that writes one of the two images of fronts and reads the other.
    pub(super) fn dispatch<P: Pod>(
        &mut self,
        pass: Pass<P>,
        writes: usize,
        constants: &P,
        groups: Groups,
    ) {
        let pipeline = self.recorder.pipelines.made(pass, self.variant);
        let pipeline = pipeline.expect("plans are only recorded once their pipelines are made");
        if self.bound != Some((pipeline.handle, writes)) {
            self.recorder.bind_writing(pipeline, writes);
            self.bound = Some((pipeline.handle, writes));
        }
        self.recorder.dispatch(pipeline, constants, groups);
    }
}

impl Recorder<'_> {
    /// Writes the progress from the offset `from` up to the visits.
    pub(super) fn write_progress(&self, progress: &Progress, from: u64) {
        let bytes = &bytes_of(progress)[from as usize..offset::VISITS as usize];
        self.update(self.grid.progress.buffer, from, bytes);
    }

    /// Returns the number of points on a side of a tile.
    pub(in crate::vulkan) fn tile(&self) -> u32 {
        self.pipelines.tuning.on_grid(self.grid.texels).tile
    }

    /// Returns the number of tiles.
    pub(super) fn tiles(&self) -> u32 {
        self.grid.texels.tiles(self.tile()).iter().product()
    }

    /// Returns the bytes of one number for each tile.
    pub(super) fn tile_bytes(&self) -> u64 {
        u64::from(self.tiles()) * size_of::<u32>() as u64
    }
}
