//! Records passes over one surface.

use std::ops::Deref;

use ash::vk;
use bytemuck::Pod;

use super::commands::{Commands, Groups};
use super::observer::OpenPass;
use super::pass_kind::PassKind;
use crate::vulkan::device::descriptors::Sets;
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::grid_images::GridImages;

/// Recorder of one surface.
#[derive(Clone, Copy)]
pub(crate) struct Recorder<'a> {
    pub(crate) commands: Commands<'a>,
    /// Images of the surface.
    pub(crate) grid: &'a GridImages,
}

impl<'a> Deref for Recorder<'a> {
    type Target = Commands<'a>;

    fn deref(&self) -> &Self::Target {
        &self.commands
    }
}

impl<'a> Recorder<'a> {
    /// Begins a pass that is this many invocations wide and high, with bytes read and written for each
    /// invocation. The pass ends when the returned value is dropped.
    pub(crate) fn pass_of_each(
        &self,
        kind: PassKind,
        invocations: [u32; 2],
        each: [u64; 2],
    ) -> Option<OpenPass<'a>> {
        let count = invocations.map(u64::from).iter().product::<u64>();
        self.pass_moving(kind, each.map(|bytes| Some(count * bytes)))
    }

    /// Begins a pass with bytes written for each texel of the images, with the border.
    pub(super) fn pass_over_images(&self, kind: PassKind, written: u64) -> Option<OpenPass<'a>> {
        let extent = self.grid.texels.fronts_extent();
        let texels = u64::from(extent.width) * u64::from(extent.height);
        self.pass_moving(kind, [Some(0), Some(texels * written)])
    }

    /// Binds a pass that writes one of the two images of fronts and reads the other.
    pub(crate) fn bind_writing<P: Pod>(&self, pipeline: Pipeline<P>, writes: usize) {
        self.bind(pipeline, self.grid.sets.writing[writes]);
    }

    /// Records a pass that is this many invocations wide and high. The pass may write the image of fronts `writes` and
    /// read the other one.
    pub(crate) fn run<P: Pod>(
        &self,
        pipeline: Pipeline<P>,
        writes: usize,
        constants: &P,
        invocations: [u32; 2],
    ) {
        self.bind_writing(pipeline, writes);
        self.dispatch(pipeline, constants, Groups::of(invocations));
    }

    /// Records a pass that also uses a set of the host.
    pub(crate) fn host_pass<P: Pod>(
        &self,
        pipeline: Pipeline<P>,
        set: vk::DescriptorSet,
        constants: &P,
        invocations: [u32; 2],
    ) {
        self.bind(pipeline, self.with_host(set));
        self.dispatch(pipeline, constants, Groups::of(invocations));
    }

    /// Records a pass over a finished map that also uses a set of the host. On a glued surface it can find copies of
    /// points.
    pub(crate) fn map_pass<P: Pod>(
        &self,
        pipeline: Pipeline<P>,
        set: vk::DescriptorSet,
        constants: &P,
        invocations: [u32; 2],
    ) {
        let with_copies = self.grid.copies.as_ref().and_then(|copies| copies.with_host(set));
        self.bind(pipeline, with_copies.unwrap_or_else(|| self.with_host(set)));
        self.dispatch(pipeline, constants, Groups::of(invocations));
    }

    /// Records a pass of `kind` with one invocation for each group of copies.
    pub(crate) fn pass_over_groups<P: Pod>(
        &self,
        kind: PassKind,
        pipeline: Pipeline<P>,
        set: vk::DescriptorSet,
        constants: &P,
        groups: u32,
    ) {
        // The number of words accessed depends on the gluing, and is not counted.
        let _pass = self.pass(kind);
        self.map_pass(pipeline, set, constants, [groups, 1]);
    }

    /// Returns the sets of a pass that also uses a set of the host. The first set is that of a pass that writes
    /// image 1, so the pass reads the fronts of image 0.
    pub(crate) fn with_host(&self, set: vk::DescriptorSet) -> Sets {
        self.grid.sets.writing[1].with_host(set)
    }
}
