//! What every schedule says of itself, and what all of them record with.

use ash::vk;
use bytemuck::{Pod, bytes_of};

use crate::vulkan::TexelChart;
use crate::vulkan::barrier::{COPY, PASS, PASS_AND_HOST, TRANSFER};
use crate::vulkan::passes::{Pass, Variant};
#[cfg(doc)]
use crate::vulkan::plan;
use crate::vulkan::plan::{Portions, Reached, Step};
use crate::vulkan::profile::{PassRecord, Presence, StepCounter};
use crate::vulkan::progress::{Progress, offset};
use crate::vulkan::record::{Groups, Recorder};

/// What a schedule is.
pub(super) trait Order: Sync {
    /// The numbers of its passes in the table: those of which each wavefront has its own.
    fn passes(&self) -> &'static [usize];

    /// What `glsl/seed.comp` does for it beside setting the sources' texels.
    fn follows(&self) -> u32;

    /// Steps of a recording; see [`crate::vulkan::Schedule::plan`].
    fn plan(
        &self,
        texels: TexelChart,
        portions: Portions,
        reached: Option<Reached>,
        most: u32,
    ) -> Vec<Step>;

    /// Whether it goes by rounds over lists that the device makes. A recording holds one sequence of them.
    fn has_rounds(&self) -> bool;

    /// Iterations or rounds in a submission of our own, at most, where a plan cannot be cut ([`plan::parts`]).
    fn together(&self, _: TexelChart, _: Portions) -> u32 {
        u32::MAX
    }

    /// Whether maps from between grid points take fewer iterations if the surroundings of sources are
    /// solved first.
    fn gains_by_surroundings(&self) -> bool {
        false
    }

    /// Numbers that [`Order::start`] writes.
    fn start_words(&self, _: &Recorder) -> u64 {
        0
    }

    /// Writes what it keeps beside the progress, before the seeds of a map or of what is added to one.
    fn start(&self, _: &Recorder, _is_added: bool) {}

    /// Before more steps of a map, by a recording as long as the last.
    fn go_on(&self, _: &Recorder, _: &[Step]) {}

    /// Records one of its steps.
    fn record(&self, recording: &mut Steps, step: &Step);

    /// The record of one of its steps, and what decides whether it visits anything.
    fn account(&self, counter: &mut StepCounter, step: &Step) -> (PassRecord, Presence);
}

/// A recording of steps.
pub(super) struct Steps<'r, 'a> {
    pub(super) recorder: &'r Recorder<'a>,
    pub(super) variant: Variant,
    pub(super) bound: Option<(vk::Pipeline, usize)>,
    /// How many dispatches of scans, the first ones, note whether they have visited something.
    pub(super) notes: u32,
    /// Dispatches of scans so far.
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
    /// Writes the progress from an offset up to the visits.
    pub(super) fn write_progress(&self, progress: &Progress, from: u64) {
        let bytes = &bytes_of(progress)[from as usize..offset::VISITS as usize];
        self.update(self.grid.progress.buffer, from, bytes);
    }

    /// How many tiles there are.
    pub(super) fn tiles(&self) -> u32 {
        self.grid.texels.tiles(self.pipelines.tuning.tile).iter().product()
    }

    /// Bytes of one number for each tile.
    pub(super) fn tile_bytes(&self) -> u64 {
        u64::from(self.tiles()) * size_of::<u32>() as u64
    }

    /// Copies what passes have written to where the host reads it while the map goes on.
    pub(super) fn copy_for_host(
        &self,
        from: vk::Buffer,
        start: u64,
        to: (vk::Buffer, u64),
        size: u64,
    ) {
        self.barrier(PASS, COPY);
        self.copy((from, start), to, size);
        self.barrier(TRANSFER, PASS_AND_HOST);
    }
}
