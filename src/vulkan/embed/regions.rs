//! Finds on the device the regions of the points nearest to each source.

use ash::vk;

use super::access::Access;
use super::creation::creation;
use super::curves;
use super::names::Labelled;
use super::outputs::{BufferKind, HostMemory, Output, OutputInfo, SourceFrame};
use super::recording::Recording;
use super::solver::{Solver, over_any};
use super::starts::{Starts, WORD, records_of_starts};
use super::surface::FrameSurface;
use crate::constants::{FLOW_JUMPS, PARENT_JUMPS};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::{SHADER, TRANSFER_WRITE};
use crate::vulkan::device::device_memory::DeviceMemory;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::passes::{
    REGION_COPIES, REGION_FLOW, REGION_LABELS, REGION_STARTS, REGION_WAYS,
};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::region_starts::Push;
use crate::vulkan::profile::PassKind;
use crate::vulkan::record::Moved;

/// Buffer for the regions of the points nearest to each source, and the passes that find them:
/// [`Recording::regions`].
pub type Regions = Output<RegionKind>;

/// Kind of [`Regions`].
#[derive(Debug)]
pub struct RegionKind {
    wavefront: Wavefront,
    starts: Starts<Push>,
    /// Pass that begins the ways back from all points.
    ways: Pipeline<Push>,
    /// Pass that begins the ways back from the copies of points of a glued surface.
    over_copies: Option<Pipeline<Push>>,
    /// Passes that lengthen ways, and passes that step from parent to parent.
    rounds: [Pipeline<Push>; 2],
}

impl BufferKind for RegionKind {}

/// Buffer of labels. From its first byte it holds a 32-bit unsigned integer for each grid point, row-major.
/// It has the usages `STORAGE_BUFFER`, `VERTEX_BUFFER` and `TRANSFER_SRC`, unless the host provides it.
///
/// Shaders read the label of a vertex by the vertex's index, or as a vertex attribute of format `R32_UINT`, 4
/// bytes apart. Labels are not an image, since they cannot be filtered and an image would only add layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegionBuffer {
    /// Buffer handle. The buffer is longer than the labels.
    pub buffer: vk::Buffer,
    /// Size of all labels in bytes: 4 M N.
    pub bytes: u64,
}

/// Parameters of [`Recording::regions`]. A label is an index in the list of sources.
pub type RegionFrame<'a> = SourceFrame<'a, Access>;

/// Number of words per grid point: two links of one word each, and two places of two words each.
const POINT_WORDS: u64 = 2 + 2 * 2;

impl Regions {
    /// Returns the buffer of the labels.
    pub fn labels(&self) -> RegionBuffer {
        RegionBuffer { buffer: self.buffer(), bytes: WORD * self.chart.points() as u64 }
    }

    /// Returns the smallest size in bytes of a buffer of the host for [`Solver::regions_into`].
    pub fn buffer_bytes(chart: Chart) -> u64 {
        (WORD * POINT_WORDS).saturating_mul(chart.points() as u64)
    }
}

creation! {
    Regions(wavefront: Wavefront), buffer: Buffer(vk::Buffer);
    bytes_for_regions(chart: Chart);
    /// Creates regions of a surface, for maps with this wavefront. The memory takes 24 bytes per grid point. Pipelines
    /// are created for each wavefront.
    regions;
    /// The buffer holds the labels from its first byte, and the intermediate values of the passes.
    /// [`Regions::buffer_bytes`] returns the size that it needs. Its usages are `STORAGE_BUFFER`, `TRANSFER_DST` and
    /// those of its readers.
    regions_into;
}

fn make(
    device: &ash::Device,
    (solver, surface): (&Solver, &FrameSurface),
    wavefront: Wavefront,
) -> Result<(OutputInfo, RegionKind), VulkanError> {
    let (wavefront, chart) = (over_any(wavefront), surface.chart());
    let [flowing, jumping] = rounds(chart);
    let over_copies = u32::from(surface.is_glued());
    let passes = records_of_starts(surface) + 1 + over_copies + flowing + jumping;
    let info = OutputInfo { passes, ..info(&solver.limits, chart)? };
    let variant = surface.finished_map(wavefront);
    let make = |pass| solver.pipelines.make(device, pass, variant);
    let kind = RegionKind {
        wavefront,
        starts: Starts::new(device, (solver, surface), REGION_STARTS, variant)?,
        ways: make(REGION_WAYS)?,
        over_copies: if surface.is_glued() { Some(make(REGION_COPIES)?) } else { None },
        rounds: [make(REGION_FLOW)?, make(REGION_LABELS)?],
    };
    Ok((info, kind))
}

fn info(limits: &Limits, chart: Chart) -> Result<OutputInfo, VulkanError> {
    limits.texels(chart)?;
    let buffer = curves::buffer_info("regions", limits, Regions::buffer_bytes(chart))?;
    Ok(OutputInfo { buffer, counts: None, image: None, curves: None, passes: 0 })
}

/// Returns the number of passes that lengthen ways, and the number of passes that step from parent to parent. Either
/// kind suffices for a way over as many points as the grid has. The sum of both numbers is even, so that the labels end
/// up in their place.
fn rounds(chart: Chart) -> [u32; 2] {
    let [flowing, jumping] = [FLOW_JUMPS, PARENT_JUMPS].map(|jumps| {
        let reaches =
            |rounds: &u32| (u64::from(jumps) + 1).saturating_pow(*rounds) >= chart.points() as u64;
        (1..).find(reaches).expect("powers grow beyond any number of points")
    });
    [flowing, jumping + (flowing + jumping) % 2]
}

impl Recording<'_> {
    /// Records the passes that find the nearest source to each grid point. The initial value of a source counts towards
    /// its distance. Returns the buffer that receives the labels for the host to read. A label is the source's index in
    /// the list, or [`crate::geometry::NO_REGION`] in holes and where no front arrives.
    ///
    /// Labels follow the map: each point gets the label of the source to which its front leads back. The
    /// number of passes depends on the logarithm of the number of grid points, whatever the map is. The same
    /// map always gives the same labels.
    ///
    /// If sources are at least four cells apart, labels are those of [`crate::geometry::Voronoi`], except at
    /// points within one or two cells of a border (three with planar fronts). If two sources are closer, the
    /// border between their regions may be rotated about the pair. On the plane it is rotated by up to 18
    /// degrees if both sources lie in the same cell.
    ///
    /// A point at the same distance from two sources gets one of their labels, always the same one. Of several sources
    /// at the same position, the first gets the region. A curve that is given as many sources has as many labels, which
    /// a table of the host can map to the curve.
    ///
    /// # Errors
    /// If the regions were destroyed or made for another surface or wavefront, there is no map, the sources
    /// are too many or do not fit the surface, or they were replaced since the last [`Output::rebind`].
    pub fn regions(
        &self,
        regions: &Regions,
        frame: &RegionFrame,
    ) -> Result<RegionBuffer, VulkanError> {
        let (RegionKind { wavefront, starts, ways, over_copies, rounds: by_turn }, chart) =
            (&regions.kind, regions.chart);
        regions.check_sources(self, frame.sources)?;
        self.surface.state.check_wavefront(*wavefront)?;
        let _group = self.group(Labelled::Regions);
        let (stages, access) = frame.reader.and(frame.before).side();
        let ours = (TRANSFER_WRITE.0 | SHADER.0, TRANSFER_WRITE.1 | SHADER.1);
        self.recorder.barrier((stages | SHADER.0, access | SHADER.1), ours);
        let passes = regions.begin(self, (PassKind::Regions, 0), frame.sources)?;
        let (grid, first_word, count) = passes.sources();
        let push = Push { grid, first_word, count, from: 0, is_last: 0 };
        passes.find_sources(*starts, |turn| Push { is_last: turn as u32, ..push });
        passes.over_points(*ways, &push, moved_by_ways(chart, *wavefront), SHADER);
        if let Some(over_copies) = over_copies {
            passes.over_copies(*over_copies, &push);
        }
        let [flowing, jumping] = rounds(chart);
        // Only the device knows how far ways lead.
        for number in 0..flowing + jumping {
            let is_last = number + 1 == flowing + jumping;
            let push = Push { from: number as i32 % 2, is_last: is_last.into(), ..push };
            let pass = by_turn[usize::from(number >= flowing)];
            let after = if is_last { frame.reader.side() } else { SHADER };
            passes.over_points(pass, &push, [None; 2], after);
        }
        regions.end(self);
        Ok(regions.labels())
    }
}

/// Returns the bytes moved to begin the ways to all points. The pass reads the front and number of the
/// earliest source, the front of the map, and four lengths. It writes a link and a place.
fn moved_by_ways(chart: Chart, wavefront: Wavefront) -> Moved {
    let curvatures = if wavefront.is_curved() { 2 } else { 0 };
    let points = WORD * chart.points() as u64;
    [Some(points * (2 + 1 + 4 + curvatures)), Some(points * 3)]
}
