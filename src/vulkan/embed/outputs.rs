//! Outputs of a frame in addition to the image of distances: contours, paths, regions, directions and log maps. Each
//! has a buffer that its passes write, and perhaps an image to which the buffer is copied.

use ash::vk;

use super::access::Access;
use super::bound_sets::BoundSets;
use super::curves::{self, CurveLayout, Lift};
use super::host_sets::{self, BufferRange, Content, HostSet};
use super::inputs::SourceInput;
use super::map_sources::Given;
use super::recording::Recording;
use super::solver::Solver;
use super::surface::{FrameSurface, ResultImage};
use crate::surface::Chart;
use crate::vulkan::VulkanError;
use crate::vulkan::device::device_memory::DeviceMemory;
use crate::vulkan::device::labels::NameOf;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::{Buffer, BufferInfo, Image, ImageInfo};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::setters::setters;

/// Image of the host for the distances of a slot, in place of one that the surface allocates. A render graph
/// can then use its memory for other resources while the distances are not needed.
///
/// The image is 2D, of format R32_SFLOAT, with at least N x M texels (width x height), one sample and one mip
/// level. Its usage is `STORAGE` and whatever its readers need. If the image is smaller than the surface, the
/// distances outside it are not written. For directions and log maps, the function that takes the image states its
/// format and usage.
///
/// [`super::Recording::result`] discards the previous contents. The previous layout does not matter, nor does
/// it matter whether the memory belonged to another resource. Earlier readers and writers of the memory must
/// have finished: name their stages in [`super::Recording::begin`], or record a barrier.
///
/// The host keeps the image and the view alive until all recordings that write them have run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostImage {
    /// Image handle.
    pub image: vk::Image,
    /// View of the image's mip level, in the format of the image.
    pub view: vk::ImageView,
}

impl HostImage {
    pub(super) fn check(&self, what: &'static str) -> Result<(), VulkanError> {
        let refuse = |reason: &str| Err(VulkanError::HostBuffer { what, reason: reason.into() });
        if self.image == vk::Image::null() {
            return refuse("the image is the null handle");
        }
        if self.view == vk::ImageView::null() {
            return refuse("the view is the null handle");
        }
        Ok(())
    }
}

/// Output of a frame: its memory, and the passes that fill it. The kind `K` is that of [`super::Contours`],
/// [`super::Paths`], [`super::Regions`], [`super::Directions`] or [`super::LogMapImage`]. Frames in flight on one queue
/// share an output.
///
/// Record an output after the map: in the same command buffer, or after [`Recording::begin`] in another. The
/// commands wait for the frame's `before`, if it has one, and for earlier reads by its `reader`. Later reads by that
/// reader wait for the commands. The output, and buffers of starts and sources, must stay alive until the commands have
/// run. The same map always gives the same output.
///
/// ```no_run
/// # use geosweep::ash::{self, vk};
/// # use geosweep::gpu_allocator::vulkan::Allocator;
/// # use geosweep::vulkan::{VulkanError, embed::*};
/// # use geosweep::Wavefront;
/// # fn host(
/// #     device: &ash::Device, allocator: &mut Allocator, solver: &Solver, surface: &FrameSurface,
/// #     commands: vk::CommandBuffer,
/// # ) -> Result<(), VulkanError> {
/// // Once: room for 100 000 vertices of contours, and for two paths.
/// let mut contours = solver.contours(device, allocator, surface, 100_000)?;
/// let paths = solver.paths(device, allocator, surface, PathsInfo::new(2, 1000))?;
/// let regions = solver.regions(device, allocator, surface, Wavefront::Curved)?;
/// let directions = solver.directions(device, allocator, surface)?;
/// let log_map = solver.log_map(device, allocator, surface)?;
///
/// // Every frame, after the map of these sources:
/// let recording = solver.record(device, commands, surface);
/// let sources = [PointSource::at(120.5, 80.25), PointSource::at(30.0, 200.0)];
/// let sources = SourceInput::Inline(&sources);
/// let levels = LevelInput::Spacing { step: 10.0, count: 100 };
/// let lines = recording.contours(&contours, &ContourFrame::new(levels, Access::DRAW))?;
/// let starts = StartInput::Inline(&[[20.5, 31.0], [200.0, 5.25]]);
/// let strips = recording.paths(&paths, &PathFrame::new(starts, sources, Access::DRAW))?;
/// let labels = recording.regions(&regions, &RegionFrame::new(sources, Access::FRAGMENT_READ))?;
/// let ways = recording.directions(&directions, &DirectionFrame::new(sources, Reader::COMPUTE))?;
/// let frame = LogMapFrame::new(sources, Reader::FRAGMENT).with_radius(1.5).with_unreached(1e6);
/// let decal = recording.log_map(&log_map, &frame)?;
/// // A fragment shader at row r and column c finds 0 or 1 in the labels at r * N + c, and reads the decal at
/// // 0.5 + 0.5 * (u, v). A shader moves an agent at column x and row y:
/// // place += speed * texture(ways, (place + 0.5) / size).xy
///
/// // In the render pass, with a pipeline for a list of lines, then with one for a strip of lines:
/// for (curves, count) in [(lines, 1), (strips, 2)] {
///     unsafe {
///         device.cmd_bind_vertex_buffers(commands, 0, &[curves.buffer], &[curves.vertices_offset]);
///         for curve in 0..count {
///             let record = curve * u64::from(CurveRecord::BYTES);
///             device.cmd_draw_indirect(commands, curves.buffer, record, 1, CurveRecord::BYTES);
///         }
///     }
/// }
///
/// // At the end, once no frame is in flight, for each output:
/// contours.destroy(device, allocator);
/// # Ok(()) }
/// ```
///
/// Dropping a value of this type frees nothing. The host calls [`Output::destroy`], before or after it
/// destroys the surface.
#[derive(Debug)]
pub struct Output<K> {
    pub(super) kind: K,
    pub(super) chart: Chart,
    pub(super) info: OutputInfo,
    hosts: Option<HostMemory>,
    /// Own buffers. The first is the output, unless the host provides that buffer. The last is the buffer in which
    /// passes count.
    buffers: Vec<Buffer>,
    image: Option<Image>,
    /// Descriptor sets of the passes that fill the output, followed by those of the passes that lift curves.
    sets: Option<BoundSets>,
    /// For each of the surface's points, the pass that lifts curves to them.
    pub(super) lifting: Vec<Pipeline<Lift>>,
}

/// Kind of an output that is a buffer, in memory of its own or of the host.
pub trait BufferKind {}

/// Kind of an output that is an image, in memory of its own or of the host.
pub trait ImageKind {}

/// Parameters of an output that depends on the map and its sources alone. The reader `R` is an [`Access`] of a buffer,
/// or a [`super::Reader`] of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SourceFrame<'a, R> {
    /// Access by which the host has written the sources.
    pub before: Access,
    /// All sources of the map, including those that were added to it.
    pub sources: SourceInput<'a>,
    /// Access by which the host reads the output in this frame and in the previous one, and the layout of an image. It
    /// is [`Access::NONE`] or [`super::Reader::OTHER_QUEUE`] if another queue reads the output after a semaphore. Each
    /// frame in flight then needs an output of its own.
    pub reader: R,
}

impl<'a, R> SourceFrame<'a, R> {
    /// Returns parameters that do not wait for writes of the host.
    pub fn new(sources: SourceInput<'a>, reader: R) -> Self {
        Self { before: Access::NONE, sources, reader }
    }

    setters! {
        with_before(before: Access);
        with_sources(sources: SourceInput<'a>);
        with_reader(reader: R);
    }
}

/// Memory of an output, and inputs of its passes in addition to the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct OutputInfo {
    /// Buffer that the passes write. Its name is that of the output, in errors and debugging tools.
    pub(super) buffer: BufferInfo,
    /// Buffer in which passes count. Passes without counts read sources: the inline ones, followed by those of each of
    /// the surface's buffers.
    pub(super) counts: Option<BufferInfo>,
    /// Image to which the buffer is copied.
    pub(super) image: Option<ImageInfo<'static>>,
    /// Layout of curves, which are lifted to the surface's points.
    pub(super) curves: Option<CurveLayout>,
    /// Largest number of records in a profile.
    pub(super) passes: u32,
}

/// Memory of the host in place of an output's own.
#[derive(Clone, Copy, Debug)]
pub(super) enum HostMemory {
    Buffer(vk::Buffer),
    Image(HostImage),
}

impl HostMemory {
    fn buffer(self) -> Option<vk::Buffer> {
        match self {
            Self::Buffer(buffer) => Some(buffer),
            Self::Image(_) => None,
        }
    }

    fn image(self) -> Option<HostImage> {
        match self {
            Self::Image(image) => Some(image),
            Self::Buffer(_) => None,
        }
    }
}

impl OutputInfo {
    /// Returns the number of bytes that the buffers and the image take from the allocator, without memory of the host.
    pub(super) fn bytes(&self, device: &ash::Device) -> Result<u64, VulkanError> {
        let counts = self.counts.map_or(Ok(0), |info| info.bytes(device))?;
        let image = self.image.map_or(Ok(0), |info| info.bytes(device))?;
        Ok(self.buffer.bytes(device)? + counts + image)
    }
}

impl<K> Output<K> {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        (solver, surface): (&Solver, &FrameSurface),
        (info, kind): (OutputInfo, K),
        hosts: Option<HostMemory>,
    ) -> Result<Self, VulkanError> {
        if let Some(HostMemory::Image(image)) = hosts {
            image.check(info.buffer.name)?;
        }
        let (chart, buffers, lifting) = (surface.grid.chart, Vec::new(), Vec::new());
        let mut new = Self { kind, chart, info, hosts, buffers, image: None, sets: None, lifting };
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
        let OutputInfo { buffer, counts, image, .. } = self.info;
        let pipelines = &solver.pipelines;
        let own = Some(buffer).filter(|_| self.hosts.and_then(HostMemory::buffer).is_none());
        for info in own.into_iter().chain(counts) {
            let buffer = Buffer::new(device, allocator, info)?;
            pipelines.name(NameOf(info.name, &surface.grid.owner), buffer.buffer);
            self.buffers.push(buffer);
        }
        let own = image.filter(|_| self.hosts.is_none());
        if let Some(info) = own {
            let image = self.image.insert(Image::new(device, allocator, info)?);
            pipelines.name_image(NameOf(info.name, &surface.grid.owner), image);
        }
        let contents = self.contents((device, &solver.limits), surface, self.buffer())?;
        self.sets = Some(BoundSets::new(device, pipelines, surface, &contents)?);
        self.lifting = self.lifting(device, solver, surface)?;
        Ok(())
    }

    /// Returns the contents of the descriptor sets, with `buffer` as the output.
    fn contents(
        &self,
        on: (&ash::Device, &Limits),
        surface: &FrameSurface,
        buffer: vk::Buffer,
    ) -> Result<Vec<Content>, VulkanError> {
        let whole =
            |BufferInfo { name, size, .. }, buffer| BufferRange::new(on, name, buffer, 0, size);
        let output = whole(self.info.buffer, buffer)?;
        let mut contents = match self.info.counts {
            Some(counts) => vec![Content::input(whole(counts, self.counts())?)],
            None => host_sets::all_sources(on, &surface.grid, &surface.sources)?,
        };
        let lifted: &[_] = if self.info.curves.is_some() { &surface.points } else { &[] };
        for points in lifted {
            contents.push(host_sets::points_content(on, points, surface.grid.chart)?);
        }
        Ok(contents.into_iter().map(|input| input.and_output(output)).collect())
    }

    fn lifting(
        &self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
    ) -> Result<Vec<Pipeline<Lift>>, VulkanError> {
        match self.info.curves {
            Some(_) => curves::lifting(device, solver, surface),
            None => Ok(Vec::new()),
        }
    }

    /// Binds the surface's current points and sources, and `buffer` as the output, to a version of the descriptor sets
    /// that no tracked recording in flight uses. Also selects the passes that lift curves anew, since the points may
    /// have moved from a buffer to an image.
    fn bind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        self.sets()?.check_surface(surface)?;
        let contents = self.contents((device, &solver.limits), surface, buffer)?;
        let lifting = self.lifting(device, solver, surface)?;
        let sets = self.sets.as_mut().ok_or(VulkanError::Destroyed)?;
        sets.rebind(device, surface, &contents)?;
        self.lifting = lifting;
        Ok(())
    }

    /// Binds the surface's current points and sources, after [`FrameSurface::set_points`] or
    /// [`FrameSurface::set_sources`] has replaced some that this output reads: contours read points, paths read points
    /// and sources, and other outputs read sources. Recordings in flight still read the old ones, which the host keeps
    /// alive until these recordings have run.
    ///
    /// # Errors
    /// If the output was made for another surface or was destroyed, or all of its descriptor sets are in flight.
    pub fn rebind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
    ) -> Result<(), VulkanError> {
        self.bind(device, solver, surface, self.buffer())
    }

    /// Returns the largest number of records that a recording of the output makes in a
    /// [`crate::vulkan::profile::Profile`], in addition to those of [`Solver::passes_of_frame`].
    pub fn passes(&self) -> u32 {
        self.info.passes
    }

    /// Returns the number of bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        let buffers = self.buffers.iter().map(Buffer::bytes).sum::<u64>();
        buffers + self.image.as_ref().map_or(0, Image::bytes)
    }

    /// Returns whether a recording of the output may still be pending. This is known only with
    /// [`super::Tools::checks`].
    pub fn is_in_flight(&self) -> bool {
        self.sets.as_ref().is_some_and(BoundSets::are_in_flight)
    }

    /// Frees everything but memory of the host. No submitted work may still use the output. A second call does
    /// nothing.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        if let Some(mut sets) = self.sets.take() {
            sets.destroy(device);
        }
        self.buffers.drain(..).for_each(|mut buffer| buffer.destroy(device, allocator));
        if let Some(mut image) = self.image.take() {
            image.destroy(device, allocator);
        }
        self.hosts = None;
    }

    /// Returns the descriptor sets, or an error if the output was destroyed.
    pub(super) fn sets(&self) -> Result<&BoundSets, VulkanError> {
        self.sets.as_ref().ok_or(VulkanError::Destroyed)
    }

    /// Returns the buffer that the passes write.
    pub(super) fn buffer(&self) -> vk::Buffer {
        let own = || self.buffers.first().map_or(vk::Buffer::null(), |buffer| buffer.buffer);
        self.hosts.and_then(HostMemory::buffer).unwrap_or_else(own)
    }

    /// Returns the buffer that passes count in.
    pub(super) fn counts(&self) -> vk::Buffer {
        self.buffers.last().map_or(vk::Buffer::null(), |buffer| buffer.buffer)
    }

    /// Returns an error if the recording is for another surface or has no map, or if the sources cannot be read or are
    /// not those of the map.
    pub(super) fn check_sources(
        &self,
        recording: &Recording,
        sources: SourceInput,
    ) -> Result<(), VulkanError> {
        let sets = self.sets()?;
        sets.check_surface(recording.surface)?;
        recording.check_sources(sources)?;
        sets.check_sources(recording.surface, sources)?;
        let given = Given::new(sources, recording.surface);
        recording.surface.state.check_sources(given, self.info.buffer.name)
    }

    /// Writes the inline sources of a recording. Returns the descriptor set from which passes read the sources, and
    /// the number of the sources, which were checked before.
    pub(super) fn read_sources(
        &self,
        recording: &Recording,
        sources: SourceInput,
    ) -> Result<(HostSet, u32), VulkanError> {
        let sets = self.sets()?.sets();
        if let SourceInput::Inline(sources) = sources {
            recording.recorder.write_sources(bytemuck::cast_slice(sources));
        }
        Ok(recording.sources_in(sources, sets[0], |number| sets[1 + number]))
    }

    /// Notes that the commands recorded so far, which end with the output's last pass, use the output.
    pub(super) fn end(&self, recording: &Recording) {
        if let Some(sets) = &self.sets {
            sets.are_used(recording.note());
        }
    }

    /// Returns the error for setting memory of the host on an output that owns its memory.
    fn own_memory(&self, reason: String) -> VulkanError {
        VulkanError::HostBuffer { what: self.info.buffer.name, reason }
    }
}

impl<K: BufferKind> Output<K> {
    /// Replaces the host's buffer in all later recordings of the output. Recordings in flight still write the old
    /// buffer, which the host keeps alive until they have run.
    ///
    /// # Errors
    /// As for [`Output::rebind`], or if the output has a buffer of its own, or the new buffer is too small.
    pub fn set_buffer(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        self.sets()?;
        if self.hosts.is_none() {
            let reason = "they have a buffer of their own: make them with the host's";
            return Err(self.own_memory(reason.into()));
        }
        self.bind(device, solver, surface, buffer)?;
        self.hosts = Some(HostMemory::Buffer(buffer));
        Ok(())
    }
}

impl<K: ImageKind> Output<K> {
    /// Returns the image. `layout` is the layout of the [`super::Reader`] for which the image was last
    /// recorded. The view is valid from the start, for descriptor sets that are written early.
    pub fn image(&self, layout: vk::ImageLayout) -> ResultImage {
        let own =
            self.image.as_ref().map(|image| HostImage { image: image.image, view: image.view });
        let image = self.hosts.and_then(HostMemory::image).or(own);
        let null = HostImage { image: vk::Image::null(), view: vk::ImageView::null() };
        let HostImage { image, view } = image.unwrap_or(null);
        let info = self.info.image.expect("this kind of output has an image");
        let vk::Extent3D { width, height, .. } = info.extent;
        let extent = vk::Extent2D { width, height };
        ResultImage { image, view, format: info.format, extent, layout }
    }

    /// Replaces the host's image in all later recordings. Recordings in flight still write the old image,
    /// which the host keeps alive until they have run.
    ///
    /// # Errors
    /// If the output has an image of its own or was destroyed, or a handle is null.
    pub fn set_image(&mut self, image: HostImage) -> Result<(), VulkanError> {
        self.sets()?;
        let what = self.info.buffer.name;
        if self.hosts.is_none() {
            return Err(self.own_memory(format!(
                "the image belongs to the library: create the {what} with an image of yours"
            )));
        }
        image.check(what)?;
        self.hosts = Some(HostMemory::Image(image));
        Ok(())
    }
}
