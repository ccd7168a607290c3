//! Holds an image with two numbers for each grid point, and the buffer in which passes compute it.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::access::{Access, Reader};
use super::bound_sets::BoundSets;
use super::curves;
use super::host_sets::{self, Content, HostSet, Part};
use super::inputs::{PointSource, SourceInput};
use super::outputs::HostImage;
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::{FrameSurface, ResultImage};
use crate::constants::WAYS_HEADER;
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::{
    SHADER, SHADER_WRITE, TRANSFER, TRANSFER_READ, TRANSFER_WRITE,
};
use crate::vulkan::device::device_memory::DeviceMemory;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::{Buffer, BufferInfo, Image, ImageInfo};
use crate::vulkan::device::passes::SHARE_STARTS;
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::share_starts::Push as Share;
use crate::vulkan::device::shaders::way_starts::Push;
use crate::vulkan::profile::PassKind;
use crate::vulkan::record::Moved;

const WORD: u64 = size_of::<u32>() as u64;

/// Image and buffer of directions or a log map of a surface.
#[derive(Debug)]
pub(crate) struct WayImage {
    kind: WayKind,
    chart: Chart,
    buffer: Option<Buffer>,
    image: Option<Image>,
    /// Host's image; `None` if `image` is used.
    hosts: Option<HostImage>,
    /// Descriptor sets of the inline sources, followed by those of the surface's source buffers.
    sets: Option<BoundSets>,
    /// Pass over the copies of points of a glued surface.
    share: Option<Pipeline<Share>>,
}

/// The contents of the image, and their place in the buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct WayKind {
    pub(super) what: &'static str,
    pub(super) format: vk::Format,
    pub(super) pass: PassKind,
    /// Number of words of the buffer for each grid point, after the header.
    pub(super) point_words: u64,
    /// Number of these words that precede the words copied to the image.
    pub(super) words_before: u64,
}

impl WayKind {
    fn buffer(self, limits: &Limits, chart: Chart) -> Result<BufferInfo, VulkanError> {
        let words = self.point_words.saturating_mul(chart.points() as u64);
        let size = WORD.saturating_mul(words.saturating_add(WAYS_HEADER.into()));
        curves::check_bytes(self.what, limits, size)?;
        Ok(BufferInfo { name: self.what, size, location: MemoryLocation::GpuOnly })
    }

    fn image(self, chart: Chart) -> ImageInfo<'static> {
        let extent = extent(chart);
        ImageInfo { name: self.what, format: self.format, extent, layers: 1, families: &[] }
    }

    /// Returns the number of bytes that the buffer, and an image that does not belong to the host, take from
    /// the allocator.
    pub(super) fn bytes_for(
        self,
        device: &ash::Device,
        limits: &Limits,
        chart: Chart,
    ) -> Result<u64, VulkanError> {
        limits.texels(chart)?;
        Ok(self.buffer(limits, chart)?.bytes(device)? + self.image(chart).bytes(device)?)
    }
}

fn extent(chart: Chart) -> vk::Extent3D {
    vk::Extent3D { width: chart.cols as u32, height: chart.rows as u32, depth: 1 }
}

impl WayImage {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        (solver, surface): (&Solver, &FrameSurface),
        kind: WayKind,
        hosts: Option<HostImage>,
    ) -> Result<Self, VulkanError> {
        let chart = surface.grid.chart;
        if let Some(image) = hosts {
            image.check(kind.what)?;
        }
        let (buffer, image, sets, share) = (None, None, None, None);
        let mut new = Self { kind, chart, buffer, image, hosts, sets, share };
        match new.fill(device, allocator, solver, surface) {
            Ok(()) => Ok(new),
            Err(error) => {
                new.destroy(device, allocator);
                Err(error)
            }
        }
    }

    fn fill(
        &mut self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        solver: &Solver,
        surface: &FrameSurface,
    ) -> Result<(), VulkanError> {
        let (kind, pipelines) = (self.kind, &solver.pipelines);
        let buffer = Buffer::new(device, allocator, kind.buffer(&solver.limits, self.chart)?)?;
        pipelines.name(kind.what, buffer.buffer);
        self.buffer = Some(buffer);
        if self.hosts.is_none() {
            let image = Image::new(device, allocator, kind.image(self.chart))?;
            pipelines.name_image(kind.what, &image);
            self.image = Some(image);
        }
        let contents = self.contents((device, &solver.limits), surface)?;
        self.sets = Some(BoundSets::new(device, pipelines, surface, &contents)?);
        if surface.is_glued() {
            self.share = Some(pipelines.make(device, SHARE_STARTS, Wavefront::Planar)?);
        }
        Ok(())
    }

    fn contents(
        &self,
        on: (&ash::Device, &Limits),
        surface: &FrameSurface,
    ) -> Result<Vec<Content>, VulkanError> {
        let bytes = self.kind.buffer(on.1, self.chart)?.size;
        let output = Part::new(on, self.kind.what, self.output(), 0, bytes)?;
        let sources = host_sets::all_sources(on, &surface.grid, &surface.sources)?;
        Ok(sources.into_iter().map(|input| input.and_output(output)).collect())
    }

    fn output(&self) -> vk::Buffer {
        self.buffer.as_ref().map_or(vk::Buffer::null(), |buffer| buffer.buffer)
    }

    pub(crate) fn image(&self, layout: vk::ImageLayout) -> ResultImage {
        let (image, view) = match (&self.hosts, &self.image) {
            (Some(HostImage { image, view }), _) => (*image, *view),
            (None, Some(image)) => (image.image, image.view),
            (None, None) => (vk::Image::null(), vk::ImageView::null()),
        };
        let vk::Extent3D { width, height, .. } = extent(self.chart);
        let extent = vk::Extent2D { width, height };
        ResultImage { image, view, format: self.kind.format, extent, layout }
    }

    /// Returns the number of passes over copies of points.
    pub(super) fn passes_over_copies(&self) -> u32 {
        if self.share.is_some() { 2 } else { 0 }
    }

    pub(crate) fn bytes(&self) -> u64 {
        let buffer = self.buffer.as_ref().map_or(0, Buffer::bytes);
        buffer + self.image.as_ref().map_or(0, Image::bytes)
    }

    pub(crate) fn rebind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
    ) -> Result<(), VulkanError> {
        self.sets.as_ref().ok_or(VulkanError::Destroyed)?.check_surface(surface)?;
        let contents = self.contents((device, &solver.limits), surface)?;
        let sets = self.sets.as_mut().ok_or(VulkanError::Destroyed)?;
        sets.rebind(device, surface, &contents)
    }

    pub(crate) fn set_image(&mut self, image: HostImage) -> Result<(), VulkanError> {
        self.sets.as_ref().ok_or(VulkanError::Destroyed)?;
        let what = self.kind.what;
        if self.hosts.is_none() {
            let reason = format!(
                "the image belongs to the library: create the {what} with an image of yours"
            );
            return Err(VulkanError::HostBuffer { what, reason });
        }
        image.check(what)?;
        self.hosts = Some(image);
        Ok(())
    }

    pub(crate) fn is_in_flight(&self) -> bool {
        self.sets.as_ref().is_some_and(BoundSets::are_in_flight)
    }

    pub(crate) fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        if let Some(mut sets) = self.sets.take() {
            sets.destroy(device);
        }
        if let Some(mut buffer) = self.buffer.take() {
            buffer.destroy(device, allocator);
        }
        if let Some(mut image) = self.image.take() {
            image.destroy(device, allocator);
        }
        self.hosts = None;
    }

    /// Records the passes that find the sources beside each grid point. `starts` is the pipeline of these
    /// passes. Returns a recorder for the passes that follow.
    pub(super) fn start<'a>(
        &'a self,
        recording: &'a Recording<'a>,
        sources: SourceInput,
        before: Access,
        starts: Pipeline<Push>,
    ) -> Result<WayPasses<'a>, VulkanError> {
        let surface = recording.surface;
        let sets = self.sets.as_ref().ok_or(VulkanError::Destroyed)?;
        sets.check_surface(surface)?;
        recording.check_sources(sources)?;
        sets.check_sources(surface, sources)?;
        surface.state.check_map()?;
        let recorder = &recording.recorder;
        let (stages, access) = before.side();
        let ours = (TRANSFER.0 | SHADER.0, TRANSFER.1 | SHADER.1);
        recorder.barrier((stages | ours.0, access | ours.1), ours);
        // Sources beside points, and their arrival times, follow the header.
        let cleared = WORD * (u64::from(WAYS_HEADER) + 2 * self.chart.points() as u64);
        let pass = recorder.pass(self.kind.pass);
        recorder.fill(self.output(), 0, cleared);
        drop(pass);
        recorder.barrier(TRANSFER_WRITE, SHADER);
        if let SourceInput::Inline(sources) = sources {
            recorder.write_sources(bytemuck::cast_slice(sources));
        }
        let (inline, of_buffer) = (sets.sets()[0], |number| sets.sets()[1 + number]);
        let (set, count) = recording.sources_in(sources, inline, of_buffer);
        let push = Push {
            grid: grid_size(self.chart),
            lattice: surface.grid.lattice.codes(),
            first_word: set.first_word,
            count: count as i32,
            turn: 0,
            radius: f32::INFINITY,
            unreached: 0.0,
            slowed: surface.grid.is_slowed().into(),
        };
        let passes = WayPasses { recording, of: self, set, push };
        for turn in [0, 1] {
            let bytes = size_of::<PointSource>() as u64 * u64::from(count);
            // The number of points accessed around the sources depends on the sources' places, and is not
            // counted.
            passes.run(starts, [count, 1], Push { turn, ..push }, [Some(bytes), None]);
            passes.share_starts(1 - turn as u64);
        }
        Ok(passes)
    }
}

/// Recorder of the passes of an image, once the sources beside each point are known.
pub(super) struct WayPasses<'a> {
    recording: &'a Recording<'a>,
    of: &'a WayImage,
    set: HostSet,
    pub(super) push: Push,
}

impl WayPasses<'_> {
    /// Records the pass that gives all copies of a point the largest of their words in one of the two arrays
    /// of words: the earliest time, or the first source.
    fn share_starts(&self, array: u64) {
        let Self { recording, of, set, push } = self;
        let (Some(pipeline), Some(copies)) = (of.share, &recording.surface.grid.copies) else {
            return;
        };
        let first_word = u64::from(WAYS_HEADER) + array * of.chart.points() as u64;
        let share = Share { grid: push.grid, first_word: first_word as i32 };
        let recorder = &recording.recorder;
        recorder.pass_over_groups(of.kind.pass, pipeline, set.set, &share, copies.groups_by_rows());
        recorder.barrier(SHADER_WRITE, SHADER);
    }

    fn run(&self, pipeline: Pipeline<Push>, size: [u32; 2], push: Push, moved: Moved) {
        let recorder = &self.recording.recorder;
        let _pass = recorder.pass_moving(self.of.kind.pass, moved);
        recorder.map_pass(pipeline, self.set.set, &push, size);
        recorder.barrier(SHADER_WRITE, SHADER);
    }

    /// Records a pass over all grid points. How much it reads depends on the map.
    pub(super) fn over_points(&self, pipeline: Pipeline<Push>, push: Push) {
        let Chart { rows, cols } = self.of.chart;
        self.run(pipeline, [cols as u32, rows as u32], push, [None; 2]);
    }

    /// Records the copy to the image, for `reader`. These are the last commands of a recording.
    pub(super) fn end(self, reader: Reader) -> ResultImage {
        let Self { recording, of, .. } = self;
        let (recorder, kind) = (&recording.recorder, of.kind);
        let result = of.image(reader.layout);
        let points = of.chart.points() as u64;
        let start = WORD * (u64::from(WAYS_HEADER) + kind.words_before * points);
        let texel = if kind.format == vk::Format::R16G16_SFLOAT { WORD } else { 2 * WORD };
        let pass = recorder.pass_moving(kind.pass, [Some(texel * points); 2]);
        recorder.barrier(SHADER_WRITE, TRANSFER_READ);
        let (stages, access) = reader.access.side();
        let before = (stages | TRANSFER_WRITE.0, access | TRANSFER_WRITE.1);
        let layouts = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        recorder.image_barrier(result.image, before, TRANSFER_WRITE, layouts);
        let whole = (vk::Offset3D::default(), extent(of.chart));
        recorder.copy_to_image((of.output(), start), result.image, whole);
        let layouts = (vk::ImageLayout::GENERAL, reader.layout);
        recorder.image_barrier(result.image, TRANSFER_WRITE, reader.access.side(), layouts);
        drop(pass);
        if let Some(sets) = &of.sets {
            sets.are_used(recording.note());
        }
        result
    }
}

/// Defines the methods that all types with a `WayImage` in their field `image` share. It is a macro, since these
/// methods are public and `WayImage` is not.
macro_rules! on_way_image {
    ($kind:ident) => {
        impl $kind {
            /// Returns the image. `layout` is the layout of the [`Reader`] for which the image was last
            /// recorded. The view is valid from the start, for descriptor sets that are written early.
            pub fn image(&self, layout: vk::ImageLayout) -> ResultImage {
                self.image.image(layout)
            }

            /// Returns the number of bytes taken from the allocator's memory blocks.
            pub fn bytes(&self) -> u64 {
                self.image.bytes()
            }

            /// Binds the surface's current sources, after [`FrameSurface::set_sources`] has replaced some of
            /// them. Recordings in flight still read the old ones, which the host keeps alive until these
            /// recordings have run.
            ///
            /// # Errors
            /// If this object was made for another surface or was destroyed, or all of its descriptor sets are in
            /// flight.
            pub fn rebind(
                &mut self,
                device: &ash::Device,
                solver: &Solver,
                surface: &FrameSurface,
            ) -> Result<(), VulkanError> {
                self.image.rebind(device, solver, surface)
            }

            /// Replaces the host's image in all later recordings. Recordings in flight still write the old image,
            /// which the host keeps alive until they have run.
            ///
            /// # Errors
            /// If this object has an image of its own or was destroyed, or a handle is null.
            pub fn set_image(&mut self, image: HostImage) -> Result<(), VulkanError> {
                self.image.set_image(image)
            }

            /// Returns whether a recording of this object may not have run. This is known with
            /// [`super::Tools::checks`] only.
            pub fn is_in_flight(&self) -> bool {
                self.image.is_in_flight()
            }

            /// Frees everything but an image of the host. No submitted work may still use this object. A second
            /// call does nothing.
            pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
                self.image.destroy(device, allocator);
            }

            #[cfg(feature = "capi")]
            pub(crate) fn way_image_mut(&mut self) -> &mut WayImage {
                &mut self.image
            }

            #[cfg(feature = "capi")]
            pub(crate) fn way_image(&self) -> &WayImage {
                &self.image
            }
        }
    };
}
pub(super) use on_way_image;
