//! Recording: each function appends commands to a command buffer that the caller has begun, and
//! ends with a barrier after which the next function may be recorded. None submits or waits.

mod commands;
mod map;
mod steps;
mod surface;

use ash::vk;

use super::grid_images::GridImages;
use super::pipelines::Pipelines;
use super::profile::{PassKind, PassRecord, Presence, Profile, Scope, Watch, Work};
use crate::constants::WORKGROUP;
pub(super) use map::UnpackBand;
pub(super) use steps::{Block, pipeline_index};
pub(crate) use surface::{EdgeSource, HALO, rows_around};

/// A command buffer that is being recorded for one surface.
#[derive(Clone, Copy)]
pub(crate) struct Recorder<'a> {
    /// The device of everything else.
    pub(crate) device: &'a ash::Device,
    /// Begun, on a queue family for compute, outside a render pass.
    pub(crate) commands: vk::CommandBuffer,
    /// Alive until the commands have run.
    pub(crate) pipelines: &'a Pipelines,
    /// The surface's.
    pub(crate) grid: &'a GridImages,
    /// Takes the passes down, if anyone looks on.
    pub(crate) profile: Option<&'a Profile>,
}

impl<'a> Recorder<'a> {
    /// To be kept while a pass is recorded: its label, and its place in the profile with what is
    /// known of it.
    pub(crate) fn pass_with(&self, record: PassRecord) -> Option<Scope<'a>> {
        Scope::open(self.watch(), || (record, Presence::Always))
    }

    /// The same of a copy of so many bytes.
    fn pass_of_copy(&self, kind: PassKind, bytes: u64) -> Option<Scope<'a>> {
        let work = Work::of_bytes(bytes, bytes);
        self.pass_with(PassRecord { work, ..PassRecord::new(kind) })
    }

    /// The same of a dispatch of so many invocations wide and high, with bytes read and written for
    /// each of them.
    pub(crate) fn pass_of_each(
        &self,
        kind: PassKind,
        invocations: [u32; 2],
        [read, written]: [u64; 2],
    ) -> Option<Scope<'a>> {
        let count = invocations.map(u64::from).iter().product::<u64>();
        let work = Work::of_bytes(count * read, count * written);
        self.pass_with(PassRecord { work, ..dispatched(kind, invocations) })
    }

    fn watch(&self) -> Watch<'a> {
        let Self { device, commands, pipelines, profile, .. } = *self;
        Watch { device, commands, profile, labels: pipelines.labels.as_ref() }
    }

    /// The same, with bytes read and written for each texel of the images, border included.
    fn pass_over_images(&self, kind: PassKind, read: u64, written: u64) -> Option<Scope<'a>> {
        let extent = self.grid.texels.fronts_extent();
        let texels = u64::from(extent.width) * u64::from(extent.height);
        let work = Work::of_bytes(texels * read, texels * written);
        self.pass_with(PassRecord { work, ..PassRecord::new(kind) })
    }
}

/// The record of a dispatch of so many invocations wide and high, in groups along the width.
pub(crate) fn dispatched(kind: PassKind, invocations: [u32; 2]) -> PassRecord {
    PassRecord { groups: Some(groups(invocations)), ..PassRecord::new(kind) }
}

/// Groups of so many invocations wide and high.
fn groups([width, height]: [u32; 2]) -> [u32; 3] {
    [width.div_ceil(WORKGROUP), height, 1]
}
