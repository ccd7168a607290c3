//! Finds on the device the direction in which the way back leaves each grid point.

use ash::vk;

use super::access::{Access, Reader};
use super::inputs::SourceInput;
use super::outputs::HostImage;
use super::recording::Recording;
use super::solver::Solver;
use super::surface::{FrameSurface, ResultImage};
use super::way_image::{WayImage, WayKind, on_way_image};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::device_memory::DeviceMemory;
use crate::vulkan::device::memory::DIRECTION_FORMAT;
use crate::vulkan::device::passes::{DIRECTIONS, WAY_STARTS};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::way_starts::Push;
use crate::vulkan::profile::PassKind;

/// Image of the directions in which ways lead back to the sources, and the passes that find them:
/// [`Recording::directions`]. The image is for agents, flow fields and the like, which step along these
/// directions.
///
/// The image has the format R16G16_SFLOAT, N x M texels (width x height), one for each grid point. A texel is
/// a unit vector in the chart: columns to the right, rows downwards. It is 0, 0 at sources, at points that
/// are not reached, and at points without an earlier neighbour, such as some of the points of a pole.
/// All devices can filter the format bilinearly. Where ways lead apart, as beside holes and where fronts meet, filtered
/// vectors are shorter than 1.
///
/// A step by this vector does not have the length 1 on the surface.
///
/// On a glued surface all copies of a point have the same direction, each in the rows and columns of its own side.
/// The direction may lead beyond that side. At poles and at the corners of an octahedral map, the rows and columns of
/// the copies have no common plane. There, copies may have 0, 0.
///
/// ```no_run
/// # use geosweep::ash::{self, vk};
/// # use geosweep::gpu_allocator::vulkan::Allocator;
/// # use geosweep::vulkan::{VulkanError, embed::*};
/// # fn host(
/// #     device: &ash::Device, allocator: &mut Allocator, solver: &Solver, surface: &FrameSurface,
/// #     commands: vk::CommandBuffer,
/// # ) -> Result<(), VulkanError> {
/// // Once:
/// let mut directions = solver.directions(device, allocator, surface)?;
///
/// // Every frame, after the map of the same sources:
/// let sources = [PointSource::at(120.5, 80.25)];
/// let frame = DirectionFrame::new(SourceInput::Inline(&sources), Reader::COMPUTE);
/// let image = solver.record(device, commands, surface).directions(&directions, &frame)?;
/// // A shader moves an agent at column x and row y: place += speed * texture(image, (place + 0.5) / size).xy
///
/// // At the end, once no frame is in flight:
/// directions.destroy(device, allocator);
/// # Ok(()) }
/// ```
///
/// Dropping a value of this type frees nothing. The host calls [`Directions::destroy`], before or after it
/// destroys the surface.
#[derive(Debug)]
pub struct Directions {
    image: WayImage,
    /// Pass that finds the sources beside points, and pass over all points.
    pipelines: [Pipeline<Push>; 2],
}

/// Parameters of [`Recording::directions`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DirectionFrame<'a> {
    /// Access by which the host has written the sources.
    pub before: Access,
    /// All sources of the map, including those that were added to it.
    pub sources: SourceInput<'a>,
    /// Access by which the host reads the image in this frame and in the previous one, and its layout. With
    /// [`Reader::OTHER_QUEUE`], each frame in flight needs directions of its own.
    pub reader: Reader,
}

impl<'a> DirectionFrame<'a> {
    /// Returns the parameters of directions that do not wait for writes of the host.
    pub fn new(sources: SourceInput<'a>, reader: Reader) -> Self {
        Self { before: Access::NONE, sources, reader }
    }

    /// Sets [`DirectionFrame::before`].
    pub fn with_before(self, before: Access) -> Self {
        Self { before, ..self }
    }

    /// Sets [`DirectionFrame::sources`].
    pub fn with_sources(self, sources: SourceInput<'a>) -> Self {
        Self { sources, ..self }
    }

    /// Sets [`DirectionFrame::reader`].
    pub fn with_reader(self, reader: Reader) -> Self {
        Self { reader, ..self }
    }
}

/// The buffer has two words for each grid point. The second is the packed direction.
const KIND: WayKind = WayKind {
    what: "directions",
    format: DIRECTION_FORMAT,
    pass: PassKind::Directions,
    point_words: 2,
    words_before: 1,
};

impl Directions {
    fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        on: (&Solver, &FrameSurface),
        hosts: Option<HostImage>,
    ) -> Result<Self, VulkanError> {
        let variant = on.1.finished_map(Wavefront::Planar);
        let make = |pass| on.0.pipelines.make(device, pass, variant);
        let pipelines = [make(WAY_STARTS)?, make(DIRECTIONS)?];
        Ok(Self { image: WayImage::new(device, allocator, on, KIND, hosts)?, pipelines })
    }

    /// Returns the largest number of records that [`Recording::directions`] makes in a
    /// [`crate::vulkan::profile::Profile`], in addition to those of [`Solver::passes_of_frame`].
    pub fn passes(&self) -> u32 {
        // The passes clear the buffer, write the sources, examine the sources twice, visit the copies of points on a
        // glued surface, visit all points, and copy the result to the image.
        1 + 1 + 2 + self.image.passes_over_copies() + 1 + 1
    }
}

on_way_image!(Directions);

impl Solver {
    /// Returns the number of bytes that directions take from the allocator's memory blocks on this device. No
    /// memory is allocated.
    ///
    /// # Errors
    /// As for [`Solver::directions`].
    pub fn bytes_for_directions(
        &self,
        device: &ash::Device,
        chart: Chart,
    ) -> Result<u64, VulkanError> {
        KIND.bytes_for(device, &self.limits, chart)
    }

    /// Creates directions of a surface, for maps with any wavefront. The memory takes 12 bytes per grid
    /// point, 4 of them for the image. This is the only call that allocates for directions. The first call
    /// for a solver also creates the pipelines. The host calls [`Directions::destroy`] in the end.
    ///
    /// # Errors
    /// If the buffer is larger than shaders can access, or memory runs out. Nothing is left behind then.
    pub fn directions(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
    ) -> Result<Directions, VulkanError> {
        Directions::new(device, allocator, (self, surface), None)
    }

    /// Creates directions as [`Solver::directions`] does, but in an image of the host. The image is 2D, of
    /// format R16G16_SFLOAT, with at least N x M texels (width x height), one sample and one mip level. Its
    /// usage is `TRANSFER_DST` and whatever its readers need. [`HostImage`] says how long the image must
    /// live. Each frame may use another image ([`Directions::set_image`]).
    ///
    /// # Errors
    /// As for [`Solver::directions`], or if a handle is null.
    pub fn directions_into(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
        image: HostImage,
    ) -> Result<Directions, VulkanError> {
        Directions::new(device, allocator, (self, surface), Some(image))
    }
}

impl Recording<'_> {
    /// Records the passes that find the direction in which the way back leaves each grid point, and returns
    /// the image that receives them.
    ///
    /// Record them after the map: in the same command buffer, or after [`Recording::begin`] in another. The
    /// commands wait for the frame's `before` and for earlier reads of the image by its `reader`. Later reads
    /// by that reader wait for the commands. `directions` and the buffer of sources must stay alive until the
    /// commands have run.
    ///
    /// The direction is the direction of the continuous way back, which [`Recording::paths`] follows.
    /// [`crate::geometry::BackDirections`] finds the same direction on the CPU. Where several fronts meet, it
    /// is the direction of one of the shortest paths. The same map always gives the same directions.
    ///
    /// # Errors
    /// If the directions were destroyed or made for another surface, there is no map, the sources are too
    /// many or do not fit the surface, or they were replaced since the last [`Directions::rebind`].
    pub fn directions(
        &self,
        directions: &Directions,
        frame: &DirectionFrame,
    ) -> Result<ResultImage, VulkanError> {
        let [starts, over_points] = directions.pipelines;
        let _group = self.recorder.group(c"geosweep: directions");
        let passes = directions.image.start(self, frame.sources, frame.before, starts)?;
        passes.over_points(over_points, passes.push);
        Ok(passes.end(frame.reader))
    }
}
