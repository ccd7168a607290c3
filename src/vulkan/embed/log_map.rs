//! Computes on the device the coordinates of each grid point in the tangent plane of its source.

use super::access::{Access, Reader};
use super::creation::creation;
use super::inputs::SourceInput;
use super::names::Labelled;
use super::outputs::{HostImage, HostMemory, ImageKind, Output, OutputInfo};
use super::recording::Recording;
use super::solver::Solver;
use super::starts::{Starts, records_of_starts};
use super::surface::{FrameSurface, ResultImage};
use super::way_image::{WayKind, Ways};
use crate::constants::{LOG_MAP_DISC, LOG_MAP_STEPS};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::SHADER;
use crate::vulkan::device::device_memory::DeviceMemory;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::LOG_MAP_FORMAT;
use crate::vulkan::device::passes::{
    LOG_MAP_ROUNDS, LOG_MAP_STEPS as STEPS, LOG_MAP_WAYS, WAY_STARTS,
};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::way_starts::Push;
use crate::vulkan::profile::PassKind;
use crate::vulkan::setters::setters;

/// Image of the log map of point sources, and the passes that compute it: [`Recording::log_map`]. The image
/// is for decals and brushes, which read their texture at these coordinates.
///
/// The image has the format R32G32_SFLOAT, N x M texels (width x height), one for each grid point. A texel is
/// (u, v): the direction in which the point's shortest path leaves its source, times its distance from the
/// source. Both are in the unit of distances, u along the direction of the columns at the source, v at a
/// right angle to u on the surface, on the side of increasing rows ([`crate::geometry::Basis`]). With several
/// sources each point lies in the plane of its nearest one. Devices need not filter this format: ask for
/// `SAMPLED_IMAGE_FILTER_LINEAR`, or load four texels.
pub type LogMapImage = Output<LogMapKind>;

/// Kind of [`LogMapImage`].
#[derive(Debug)]
pub struct LogMapKind {
    starts: Starts<Push>,
    /// Passes that begin the ways, take their first step, and follow them.
    pipelines: [Pipeline<Push>; 3],
}

impl ImageKind for LogMapKind {}

impl WayKind for LogMapKind {
    /// The buffer has two words and three pairs of words for each grid point. The first pair is (u, v).
    const WAYS: Ways = Ways {
        what: "log map",
        format: LOG_MAP_FORMAT,
        pass: PassKind::LogMap,
        point_words: 2 + 3 * 2,
        words_before: 2,
    };
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

    setters! {
        with_before(before: Access);
        with_sources(sources: SourceInput<'a>);
        with_reader(reader: Reader);
        with_radius(radius: f32);
        with_unreached(unreached: f32);
    }
}

creation! {
    LogMapImage(), image: Image(HostImage);
    bytes_for_log_map(chart: Chart);
    /// Creates a log map of a surface without glued sides, for maps with any wavefront. The memory takes 40 bytes per
    /// grid point, 8 of them for the image.
    log_map;
    /// The image is 2D, of format R32G32_SFLOAT, with at least N x M texels (width x height), one sample and one mip
    /// level. Its usage is `TRANSFER_DST` and whatever its readers need. The format and usage in [`HostImage`] do not
    /// apply.
    log_map_into;
}

fn make(
    device: &ash::Device,
    on: (&Solver, &FrameSurface),
) -> Result<(OutputInfo, LogMapKind), VulkanError> {
    let (solver, surface) = on;
    surface.check_open("a log map in a frame")?;
    let make = |pass| solver.pipelines.make(device, pass, Wavefront::Planar);
    let starts = Starts::new(device, on, WAY_STARTS, Wavefront::Planar.into())?;
    let pipelines = [make(LOG_MAP_WAYS)?, make(STEPS)?, make(LOG_MAP_ROUNDS)?];
    // The last passes begin the ways, step once, follow the ways in rounds, and copy.
    let passes = records_of_starts(surface) + 1 + 1 + rounds(surface.chart()) + 1;
    let info = OutputInfo { passes, ..info(&solver.limits, surface.chart())? };
    Ok((info, LogMapKind { starts, pipelines }))
}

fn info(limits: &Limits, chart: Chart) -> Result<OutputInfo, VulkanError> {
    LogMapKind::WAYS.info(limits, chart)
}

/// Returns the number of rounds after which the coordinates of all points are known, if no way has more cells than the
/// grid has points. A way is one cell long in the first round and doubles its length in each further round.
fn rounds(chart: Chart) -> u32 {
    let known =
        |rounds: &u32| LOG_MAP_DISC as u64 + u64::from(LOG_MAP_STEPS) * ((1u64 << rounds) - 1);
    (1..=30).find(|rounds| known(rounds) >= chart.points() as u64).unwrap_or(30)
}

impl Recording<'_> {
    /// Records the passes that compute the log map of the map's sources, and returns the image that receives
    /// it.
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
    /// [`Output::rebind`].
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
        log_map.check_sources(self, sources)?;
        let LogMapKind { starts, pipelines: [ways, step, round] } = log_map.kind;
        let _group = self.group(Labelled::LogMap);
        let (passes, push) = log_map.start(self, sources, before, starts)?;
        let push = Push { radius, unreached, ..push };
        let over_points = |pipeline, push| passes.over_points(pipeline, &push, [None; 2], SHADER);
        over_points(ways, push);
        over_points(step, push);
        for turn in 0..rounds(log_map.chart) as i32 {
            over_points(round, Push { turn, ..push });
        }
        Ok(log_map.copy(&passes, reader))
    }
}
