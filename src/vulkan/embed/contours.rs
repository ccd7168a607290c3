//! Finds contours on the device, for drawing in the same frame.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::access::Access;
use super::creation::creation;
use super::curves::{CurveBuffer, CurveKind, CurveLayout};
use super::names::Labelled;
use super::outputs::{BufferKind, HostMemory, Output, OutputInfo};
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::FrameSurface;
use crate::constants::{LEVELS_TOGETHER, WORKGROUP};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::{SHADER, SHADER_WRITE, TRANSFER_WRITE};
use crate::vulkan::device::device_memory::DeviceMemory;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::BufferInfo;
use crate::vulkan::device::passes::{CONTOUR_COUNTS, CONTOUR_OFFSETS, CONTOUR_SEGMENTS};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::contour_counts::Push;
use crate::vulkan::profile::PassKind;
use crate::vulkan::record::Moved;
use crate::vulkan::setters::setters;

/// Buffer for the contours of a surface, and the passes that find them: [`Recording::contours`].
pub type Contours = Output<ContourKind>;

/// Kind of [`Contours`].
#[derive(Debug)]
pub struct ContourKind {
    /// Pipelines of the passes, in the order of the passes.
    pipelines: [Pipeline<Push>; 3],
}

impl BufferKind for ContourKind {}
impl CurveKind for ContourKind {}

/// Levels, that is arrival times, at which contours are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelInput<'a> {
    /// Given levels in ascending order, at most 1024.
    List(&'a [f32]),
    /// Multiples of a distance, beginning with the distance itself; at most 1024. Levels above the largest distance of
    /// the map cost almost nothing.
    Spacing {
        /// Distance between levels; positive.
        step: f32,
        /// Number of levels.
        count: usize,
    },
}

/// Parameters of [`Recording::contours`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContourFrame<'a> {
    /// Levels of the contours.
    pub levels: LevelInput<'a>,
    /// Smallest initial value of the map's sources, usually 0. Between grid points, contours are placed by
    /// interpolation of the squares of the times since this start.
    pub start: f32,
    /// Number of the surface's points to which the contours are lifted.
    pub points: usize,
    /// Access by which the host reads the contours, in this frame and in the previous one; usually
    /// [`Access::DRAW`]. It is [`Access::NONE`] if another queue reads them after a semaphore. Each frame in
    /// flight then needs contours of its own.
    pub reader: Access,
}

impl<'a> ContourFrame<'a> {
    /// Returns the parameters of contours on the surface's points with number 0, for a map that starts at time 0.
    pub fn new(levels: LevelInput<'a>, reader: Access) -> Self {
        Self { levels, start: 0.0, points: 0, reader }
    }

    setters! {
        with_levels(levels: LevelInput<'a>);
        with_start(start: f32);
        with_points(points: usize);
        with_reader(reader: Access);
    }
}

const MOST_LEVELS: usize = LEVELS_TOGETHER as usize;
/// Largest number of words per grid row for counting contours.
const ROW_WORDS: usize = 1 + WORKGROUP as usize;

impl Contours {
    /// Returns the smallest size in bytes of a buffer of the host for [`Solver::contours_into`].
    pub fn buffer_bytes(vertices: u32) -> u64 {
        contour_layout(vertices).bytes()
    }
}

creation! {
    Contours(vertices: u32), buffer: Buffer(vk::Buffer);
    bytes_for_contours(chart: Chart, vertices: u32);
    /// Creates contours of a surface, with room for `vertices` vertices. A segment has two of them. The
    /// memory takes 24 bytes per vertex and 260 bytes per row of the grid.
    contours;
    /// The buffer is used from its first byte. [`Contours::buffer_bytes`] returns the size that it needs. Its usages
    /// are `STORAGE_BUFFER` and those of its readers, such as `VERTEX_BUFFER`, `INDIRECT_BUFFER` or
    /// `SHADER_DEVICE_ADDRESS`.
    contours_into;
}

fn make(
    device: &ash::Device,
    (solver, surface): (&Solver, &FrameSurface),
    vertices: u32,
) -> Result<(OutputInfo, ContourKind), VulkanError> {
    let info = info(&solver.limits, surface.grid.chart, vertices)?;
    let make = |pass| solver.pipelines.make(device, pass, Wavefront::Planar);
    let pipelines = [make(CONTOUR_COUNTS)?, make(CONTOUR_OFFSETS)?, make(CONTOUR_SEGMENTS)?];
    Ok((info, ContourKind { pipelines }))
}

/// Returns the layout of a buffer for contours. Its capacity is even, since a segment has two vertices.
fn contour_layout(vertices: u32) -> CurveLayout {
    CurveLayout { curves: 1, capacity: vertices / 2 * 2, between: 0 }
}

/// Returns the buffers for the curves, and for levels and counts.
fn info(limits: &Limits, chart: Chart, vertices: u32) -> Result<OutputInfo, VulkanError> {
    let layout = contour_layout(vertices);
    if layout.capacity == 0 {
        let reason = format!("{vertices} vertices are too few for a line");
        return Err(VulkanError::Curves { what: "contours", reason });
    }
    limits.texels(chart)?;
    let words = MOST_LEVELS + ROW_WORDS * chart.rows;
    let counts = BufferInfo {
        name: "counts of contours",
        size: (size_of::<u32>() * words) as u64,
        location: MemoryLocation::GpuOnly,
    };
    let (buffer, curves) = (layout.buffer("contours", limits)?, Some(layout));
    Ok(OutputInfo { buffer, counts: Some(counts), image: None, curves, passes: 3 + 1 })
}

impl LevelInput<'_> {
    /// Returns the levels in ascending order, and their number. The rest of the array is unused.
    fn read(self) -> Result<([f32; MOST_LEVELS], usize), VulkanError> {
        let refuse = |reason| Err(VulkanError::Curves { what: "contours", reason });
        let count = match self {
            Self::List(levels) => levels.len(),
            Self::Spacing { count, .. } => count,
        };
        if count > MOST_LEVELS {
            return refuse(format!(
                "{count} levels are more than the {MOST_LEVELS} of a recording"
            ));
        }
        let mut read = [0.0; MOST_LEVELS];
        match self {
            Self::List(levels) => {
                if let Some(level) = levels.iter().find(|level| !level.is_finite()) {
                    return refuse(format!("level {level} is not finite"));
                }
                if let Some(pair) = levels.windows(2).find(|pair| pair[0] >= pair[1]) {
                    return refuse(format!(
                        "levels must ascend, but {} comes before {}",
                        pair[0], pair[1]
                    ));
                }
                read[..count].copy_from_slice(levels);
            }
            Self::Spacing { step, .. } => {
                if !(step > 0.0 && (step * count as f32).is_finite()) {
                    return refuse(format!("{count} levels cannot be {step} apart"));
                }
                for (number, level) in (1..).zip(&mut read[..count]) {
                    *level = step * number as f32;
                }
            }
        }
        Ok((read, count))
    }
}

impl Recording<'_> {
    /// Records the passes that find the contours of the map and lift them to the surface. Returns the buffer that
    /// receives them for the host to draw. [`Output`] says when to record them. The segments are ordered by their
    /// cells: from north to south, and within a row from west to east. The same map always gives the same order.
    ///
    /// The segments are those of [`crate::geometry::contours`]. Seen from the first vertex of a segment towards the
    /// second, nearer points lie to the left, in a picture of the grid with rows downwards. If the buffer is too small,
    /// the southern segments are left out, and [`super::CurveRecord::vertices`] holds the number of vertices needed.
    ///
    /// # Errors
    /// If the contours were destroyed or made for another surface, there is no map, the frame's points do not
    /// exist, are a metric or were replaced since the last [`Output::rebind`], or the levels or the
    /// start are not finite, or the levels not ascending or too many.
    pub fn contours(
        &self,
        contours: &Contours,
        frame: &ContourFrame,
    ) -> Result<CurveBuffer, VulkanError> {
        contours.check_points(self, frame.points)?;
        let set = contours.sets()?.sets()[0];
        if !frame.start.is_finite() {
            let reason = format!("the start {} of the map is not finite", frame.start);
            return Err(VulkanError::Curves { what: "contours", reason });
        }
        let (levels, count) = frame.levels.read()?;
        let (recorder, chart) = (&self.recorder, self.surface.grid.chart);
        let _group = self.group(Labelled::Contours);
        let (stages, access) = frame.reader.side();
        let ours = (TRANSFER_WRITE.0 | SHADER.0, TRANSFER_WRITE.1 | SHADER.1);
        recorder.barrier((stages | SHADER.0, access | SHADER.1), ours);
        if count > 0 {
            recorder.update(contours.counts(), 0, bytemuck::cast_slice(&levels[..count]));
            recorder.barrier(TRANSFER_WRITE, SHADER);
        }
        let layout = contours.layout();
        let push = Push {
            grid: grid_size(chart),
            levels: count as u32,
            first_vertex: layout.first_vertex() as i32,
            capacity: layout.capacity as i32,
            start: frame.start,
        };
        // A row of cells lies between two rows of points.
        let rows = chart.rows as u32 - 1;
        let heights = [rows, 1, rows];
        let passes = contours.kind.pipelines.into_iter().zip(heights).zip(moved(chart));
        for ((pipeline, height), moved) in passes {
            let size = [WORKGROUP, height];
            let _pass = recorder.pass_moving(PassKind::Contours, moved);
            recorder.host_pass(pipeline, set.set, &push, size);
            recorder.barrier(SHADER_WRITE, SHADER);
        }
        contours.lift(self, frame.points, frame.reader)
    }
}

/// Returns the bytes that the passes move: times of all points, and counts of rows of cells and of their
/// strips. Only the device knows how many segments the last pass writes.
fn moved(chart: Chart) -> [Moved; 3] {
    let number = size_of::<u32>() as u64;
    let (times, rows) = (number * chart.points() as u64, number * (chart.rows as u64 - 1));
    let (counts, record) = (rows * ROW_WORDS as u64, 6 * number);
    [[Some(times), Some(counts)], [Some(rows), Some(rows + record)], [Some(times + counts), None]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_ascending_numbers() {
        let read = |levels: LevelInput| levels.read().map(|(levels, n)| levels[..n].to_vec());
        assert_eq!(read(LevelInput::List(&[-1.0, 2.5])).unwrap(), [-1.0, 2.5]);
        assert_eq!(read(LevelInput::Spacing { step: 2.0, count: 3 }).unwrap(), [2.0, 4.0, 6.0]);
        assert!(read(LevelInput::List(&[])).unwrap().is_empty());
        let many = [0.0; MOST_LEVELS + 1];
        for (levels, reason) in [
            (LevelInput::List(&[f32::NAN]), "NaN"),
            (LevelInput::List(&[1.0, 1.0]), "must ascend, but 1 comes before 1"),
            (LevelInput::List(&many), "1025 levels"),
            (LevelInput::Spacing { step: 0.0, count: 2 }, "0 apart"),
            (LevelInput::Spacing { step: f32::INFINITY, count: 0 }, "inf apart"),
            (LevelInput::Spacing { step: 1.0, count: 2000 }, "2000 levels"),
        ] {
            let error = read(levels).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
    }
}
