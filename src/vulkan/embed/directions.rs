//! Computes on the device the direction of the way back at each grid point.

use super::access::Reader;
use super::creation::creation;
use super::names::Labelled;
use super::outputs::{HostImage, HostMemory, ImageKind, Output, OutputInfo, SourceFrame};
use super::recording::Recording;
use super::solver::Solver;
use super::starts::{Starts, records_of_starts};
use super::surface::{FrameSurface, ResultImage};
use super::way_image::{WayKind, Ways};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::SHADER;
use crate::vulkan::device::device_memory::DeviceMemory;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::DIRECTION_FORMAT;
use crate::vulkan::device::passes::{DIRECTIONS, WAY_STARTS};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::way_starts::Push;
use crate::vulkan::profile::PassKind;

/// Image of the directions of the ways back to the sources, and the passes that compute them:
/// [`Recording::directions`]. The image is for agents and flow fields, which step along these directions.
///
/// The image has the format R16G16_SFLOAT, N x M texels (width x height), one for each grid point. A texel is
/// a unit vector in the chart: columns to the right, rows downwards. It is 0, 0 at sources, at points that
/// are not reached, and at points without an earlier neighbour, such as some of the points of a pole.
/// All devices can filter the format bilinearly. Where ways diverge, as beside holes and where fronts meet, filtered
/// vectors are shorter than 1.
///
/// A step by this vector does not have the length 1 on the surface.
///
/// On a glued surface all copies of a point have the same direction, each in the rows and columns of its own side.
/// The direction may lead beyond that side. At poles and at the corners of an octahedral map, the rows and columns of
/// the copies have no common plane. There, copies may have 0, 0.
pub type Directions = Output<DirectionKind>;

/// Kind of [`Directions`].
#[derive(Debug)]
pub struct DirectionKind {
    starts: Starts<Push>,
    over_points: Pipeline<Push>,
}

impl ImageKind for DirectionKind {}

impl WayKind for DirectionKind {
    /// The buffer has two words for each grid point. The second is the packed direction.
    const WAYS: Ways = Ways {
        what: "directions",
        format: DIRECTION_FORMAT,
        pass: PassKind::Directions,
        point_words: 2,
        words_before: 1,
    };
}

/// Parameters of [`Recording::directions`].
pub type DirectionFrame<'a> = SourceFrame<'a, Reader>;

creation! {
    Directions(), image: Image(HostImage);
    bytes_for_directions(chart: Chart);
    /// Creates directions of a surface, for maps with any wavefront. The memory takes 12 bytes per grid
    /// point, 4 of them for the image.
    directions;
    /// The image is 2D, of format R16G16_SFLOAT, with at least N x M texels (width x height), one sample and one mip
    /// level. Its usage is `TRANSFER_DST` and whatever its readers need. The format and usage in [`HostImage`] do not
    /// apply.
    directions_into;
}

fn make(
    device: &ash::Device,
    on: (&Solver, &FrameSurface),
) -> Result<(OutputInfo, DirectionKind), VulkanError> {
    let (solver, surface) = on;
    let variant = surface.finished_map(Wavefront::Planar);
    let starts = Starts::new(device, on, WAY_STARTS, variant)?;
    let over_points = solver.pipelines.make(device, DIRECTIONS, variant)?;
    // The last passes visit all points, and copy the result to the image.
    let passes = records_of_starts(surface) + 1 + 1;
    let info = OutputInfo { passes, ..info(&solver.limits, surface.chart())? };
    Ok((info, DirectionKind { starts, over_points }))
}

fn info(limits: &Limits, chart: Chart) -> Result<OutputInfo, VulkanError> {
    DirectionKind::WAYS.info(limits, chart)
}

impl Recording<'_> {
    /// Records the passes that compute the direction of the way back at each grid point, and returns the image that
    /// receives them.
    ///
    /// The direction is that of the continuous way back, which [`Recording::paths`] follows.
    /// [`crate::geometry::BackDirections`] computes the same direction on the CPU. Where several fronts meet, it is the
    /// direction of one of the shortest paths. The same map always gives the same directions.
    ///
    /// # Errors
    /// If the directions were destroyed or made for another surface, there is no map, the sources are too
    /// many or do not fit the surface, or they were replaced since the last [`Output::rebind`].
    pub fn directions(
        &self,
        directions: &Directions,
        frame: &DirectionFrame,
    ) -> Result<ResultImage, VulkanError> {
        let DirectionKind { starts, over_points } = directions.kind;
        directions.check_sources(self, frame.sources)?;
        let _group = self.group(Labelled::Directions);
        let (passes, push) = directions.start(self, frame.sources, frame.before, starts)?;
        passes.over_points(over_points, &push, [None; 2], SHADER);
        Ok(directions.copy(&passes, frame.reader))
    }
}
