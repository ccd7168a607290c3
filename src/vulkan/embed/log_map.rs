//! Computes on the device the place of each grid point in the tangent plane of its source.

use ash::vk;

use super::access::{Access, Reader};
use super::inputs::SourceInput;
use super::outputs::HostImage;
use super::recording::Recording;
use super::solver::Solver;
use super::surface::{FrameSurface, ResultImage};
use super::way_image::{WayImage, WayKind, on_way_image};
use crate::constants::{LOG_MAP_DISC, LOG_MAP_STEPS};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::device_memory::DeviceMemory;
use crate::vulkan::device::memory::LOG_MAP_FORMAT;
use crate::vulkan::device::passes::{
    LOG_MAP_ROUNDS, LOG_MAP_STEPS as STEPS, LOG_MAP_WAYS, WAY_STARTS,
};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::way_starts::Push;
use crate::vulkan::profile::PassKind;

/// Image of the log map of point sources, and the passes that compute it: [`Recording::log_map`]. The image
/// is for decals and brushes, which read their texture at these coordinates.
///
/// The image has the format R32G32_SFLOAT, N x M texels (width x height), one for each grid point. A texel is
/// (u, v): the direction in which the point's shortest path leaves its source, times its distance from the
/// source. Both are in the unit of distances, u along the direction of the columns at the source, v at a
/// right angle to u on the surface, on the side of increasing rows ([`crate::geometry::Basis`]). With several
/// sources each point lies in the plane of its nearest one. Devices need not filter this format: ask for
/// `SAMPLED_IMAGE_FILTER_LINEAR`, or load four texels.
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
/// let mut log_map = solver.log_map(device, allocator, surface)?;
///
/// // Every frame, after the map of the same source, for a decal that is 2 units wide:
/// let sources = [PointSource::at(120.5, 80.25)];
/// let frame = LogMapFrame::new(SourceInput::Inline(&sources), Reader::FRAGMENT)
///     .with_radius(1.5)
///     .with_unreached(1e6);
/// let image = solver.record(device, commands, surface).log_map(&log_map, &frame)?;
/// // The fragment shader reads the decal at 0.5 + 0.5 * (u, v).
///
/// // At the end, once no frame is in flight:
/// log_map.destroy(device, allocator);
/// # Ok(()) }
/// ```
///
/// Dropping a value of this type frees nothing. The host calls [`LogMapImage::destroy`], before or after it
/// destroys the surface.
#[derive(Debug)]
pub struct LogMapImage {
    image: WayImage,
    chart: Chart,
    /// Passes that find the sources beside points, begin the ways, take their first step, and follow them.
    pipelines: [Pipeline<Push>; 4],
}

/// Parameters of [`Recording::log_map`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LogMapFrame<'a> {
    /// Access by which the host has written the sources.
    pub before: Access,
    /// All sources of the map, including those that were added to it.
    pub sources: SourceInput<'a>,
    /// Access by which the host reads the image in this frame and in the previous one, and its layout. With
    /// [`Reader::OTHER_QUEUE`], each frame in flight needs a log map of its own.
    pub reader: Reader,
    /// Largest distance of points that get coordinates, in the unit of distances. Other points cost next to
    /// nothing. If the sources have several initial values, the distance counts from the latest one.
    pub radius: f32,
    /// Value of u and v at points that are not reached or beyond the radius. A bilinear filter turns
    /// +infinity into NaN beside such points.
    pub unreached: f32,
}

impl<'a> LogMapFrame<'a> {
    /// Returns the parameters of the log map of the whole surface. It does not wait for writes of the host,
    /// and is +infinity at points that are not reached.
    pub fn new(sources: SourceInput<'a>, reader: Reader) -> Self {
        let (before, radius) = (Access::NONE, f32::INFINITY);
        Self { before, sources, reader, radius, unreached: f32::INFINITY }
    }

    /// Sets [`LogMapFrame::before`].
    pub fn with_before(self, before: Access) -> Self {
        Self { before, ..self }
    }

    /// Sets [`LogMapFrame::sources`].
    pub fn with_sources(self, sources: SourceInput<'a>) -> Self {
        Self { sources, ..self }
    }

    /// Sets [`LogMapFrame::reader`].
    pub fn with_reader(self, reader: Reader) -> Self {
        Self { reader, ..self }
    }

    /// Sets [`LogMapFrame::radius`].
    pub fn with_radius(self, radius: f32) -> Self {
        Self { radius, ..self }
    }

    /// Sets [`LogMapFrame::unreached`].
    pub fn with_unreached(self, unreached: f32) -> Self {
        Self { unreached, ..self }
    }
}

/// The buffer has two words and three pairs of words for each grid point. The first pair is (u, v).
const KIND: WayKind = WayKind {
    what: "log map",
    format: LOG_MAP_FORMAT,
    pass: PassKind::LogMap,
    point_words: 2 + 3 * 2,
    words_before: 2,
};

impl LogMapImage {
    fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        on: (&Solver, &FrameSurface),
        hosts: Option<HostImage>,
    ) -> Result<Self, VulkanError> {
        on.1.check_open("a log map in a frame")?;
        let make = |pass| on.0.pipelines.make(device, pass, Wavefront::Planar);
        let pipelines =
            [make(WAY_STARTS)?, make(LOG_MAP_WAYS)?, make(STEPS)?, make(LOG_MAP_ROUNDS)?];
        let image = WayImage::new(device, allocator, on, KIND, hosts)?;
        Ok(Self { image, chart: on.1.chart(), pipelines })
    }

    /// Returns the largest number of records that [`Recording::log_map`] makes in a
    /// [`crate::vulkan::profile::Profile`], in addition to those of [`Solver::passes_of_frame`].
    pub fn passes(&self) -> u32 {
        // The passes clear, write the sources, examine these twice, begin the ways, step once, follow the
        // ways in rounds, and copy.
        1 + 1 + 2 + 1 + 1 + rounds(self.chart) + 1
    }
}

on_way_image!(LogMapImage);

impl Solver {
    /// Returns the number of bytes that a log map takes from the allocator's memory blocks on this device. No
    /// memory is allocated.
    ///
    /// # Errors
    /// As for [`Solver::log_map`].
    pub fn bytes_for_log_map(
        &self,
        device: &ash::Device,
        chart: Chart,
    ) -> Result<u64, VulkanError> {
        KIND.bytes_for(device, &self.limits, chart)
    }

    /// Creates a log map of a surface, for maps with any wavefront. The memory takes 40 bytes per grid point,
    /// 8 of them for the image. This is the only call that allocates for log maps. The first call for a
    /// solver also creates the pipelines. The host calls [`LogMapImage::destroy`] in the end.
    ///
    /// # Errors
    /// If the surface is glued, the buffer is larger than shaders can access, or memory runs out. Nothing is left
    /// behind then.
    pub fn log_map(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
    ) -> Result<LogMapImage, VulkanError> {
        LogMapImage::new(device, allocator, (self, surface), None)
    }

    /// Creates a log map as [`Solver::log_map`] does, but in an image of the host. The image is 2D, of format
    /// R32G32_SFLOAT, with at least N x M texels (width x height), one sample and one mip level. Its usage is
    /// `TRANSFER_DST` and whatever its readers need. [`HostImage`] says how long the image must live. The format
    /// and usage given there do not apply. Each frame may use another image ([`LogMapImage::set_image`]).
    ///
    /// # Errors
    /// As for [`Solver::log_map`], or if a handle is null.
    pub fn log_map_into(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
        image: HostImage,
    ) -> Result<LogMapImage, VulkanError> {
        LogMapImage::new(device, allocator, (self, surface), Some(image))
    }
}

/// Returns the number of rounds after which the coordinates of all points are known, if no way is longer than
/// the grid has points. A way is one cell long in the first round, and twice as long in each further round.
fn rounds(chart: Chart) -> u32 {
    let known =
        |rounds: &u32| LOG_MAP_DISC as u64 + u64::from(LOG_MAP_STEPS) * ((1u64 << rounds) - 1);
    (1..=30).find(|rounds| known(rounds) >= chart.points() as u64).unwrap_or(30)
}

impl Recording<'_> {
    /// Records the passes that compute the log map of the map's sources, and returns the image that receives
    /// it.
    ///
    /// Record them after the map: in the same command buffer, or after [`Recording::begin`] in another. The
    /// commands wait for the frame's `before` and for earlier reads of the image by its `reader`. Later reads
    /// by that reader wait for the commands. `log_map` and the buffer of sources must stay alive until the
    /// commands have run.
    ///
    /// The coordinates are those of [`crate::geometry::LogMap`], in single precision and from the map alone:
    /// the ways back of all points are followed to their sources. The number of passes depends on the
    /// logarithm of the number of grid points, whatever the map is. The same map always gives the same
    /// coordinates. The coordinates jump where several shortest paths lead to a point. The coordinates of the
    /// point itself belong to one of these paths.
    ///
    /// # Errors
    /// If the radius is not positive, the log map was destroyed or made for another surface, there is no map,
    /// the sources are too many or do not fit the surface, or they were replaced since the last
    /// [`LogMapImage::rebind`].
    pub fn log_map(
        &self,
        log_map: &LogMapImage,
        frame: &LogMapFrame,
    ) -> Result<ResultImage, VulkanError> {
        let LogMapFrame { before, sources, reader, radius, unreached } = *frame;
        if radius.is_nan() || radius <= 0.0 {
            let reason = format!("its radius {radius} is not positive");
            return Err(VulkanError::Curves { what: "log map", reason });
        }
        let [starts, ways, step, round] = log_map.pipelines;
        let _group = self.recorder.group(c"geosweep: log map");
        let passes = log_map.image.start(self, sources, before, starts)?;
        let push = Push { radius, unreached, ..passes.push };
        passes.over_points(ways, push);
        passes.over_points(step, push);
        for turn in 0..rounds(log_map.chart) as i32 {
            passes.over_points(round, Push { turn, ..push });
        }
        Ok(passes.end(reader))
    }
}
