//! Finds contours on the device, for drawing in the same frame.

use crate::vulkan::device::device_memory::DeviceMemory;
use ash::vk;
use gpu_allocator::MemoryLocation;

use super::access::Access;
use super::curves::{self, CurveBuffer, CurveLayout, Curves, CurvesInfo, Reads};
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::FrameSurface;
use crate::constants::{LEVELS_TOGETHER, WORKGROUP};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::{SHADER, SHADER_WRITE, TRANSFER_WRITE};
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::BufferInfo;
use crate::vulkan::device::passes::{CONTOUR_COUNTS, CONTOUR_OFFSETS, CONTOUR_SEGMENTS};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::contour_counts::Push;
use crate::vulkan::profile::PassKind;
use crate::vulkan::record::Moved;

/// Buffer for the contours of a surface, and the passes that find them: [`Recording::contours`].
///
/// ```no_run
/// # use geosweep::ash::{self, vk};
/// # use geosweep::gpu_allocator::vulkan::Allocator;
/// # use geosweep::vulkan::{VulkanError, embed::*};
/// # fn host(
/// #     device: &ash::Device, allocator: &mut Allocator, solver: &Solver, surface: &FrameSurface,
/// #     commands: vk::CommandBuffer,
/// # ) -> Result<(), VulkanError> {
/// // Once: room for 100 000 vertices.
/// let mut contours = solver.contours(device, allocator, surface, 100_000)?;
///
/// // Every frame, after the map:
/// let levels = LevelInput::Spacing { step: 10.0, count: 100 };
/// let frame = ContourFrame::new(levels, Access::DRAW);
/// let lines = solver.record(device, commands, surface).contours(&contours, &frame)?;
/// // In the render pass, with a pipeline for a list of lines:
/// unsafe {
///     device.cmd_bind_vertex_buffers(commands, 0, &[lines.buffer], &[lines.vertices_offset]);
///     device.cmd_draw_indirect(commands, lines.buffer, 0, 1, CurveRecord::BYTES);
/// }
///
/// // At the end, once no frame is in flight:
/// contours.destroy(device, allocator);
/// # Ok(()) }
/// ```
///
/// Dropping a value of this type frees nothing. The host calls [`Contours::destroy`], before or after it
/// destroys the surface.
#[derive(Debug)]
pub struct Contours {
    curves: Curves,
    /// Pipelines of the passes, in the order of the passes.
    pipelines: [Pipeline<Push>; 3],
}

/// Levels, that is arrival times, at which contours are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelInput<'a> {
    /// Given levels in ascending order, at most 1024.
    List(&'a [f32]),
    /// Multiples of a distance, beginning with the distance itself; at most 1024. Levels beyond the largest
    /// distance of the map cost next to nothing.
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
    /// Smallest initial value of the map's sources, which is usually 0. The position of a contour between
    /// grid points is interpolated from the squares of the times since this start.
    pub start: f32,
    /// Number of the surface's points to which the contours are lifted.
    pub points: usize,
    /// Access by which the host reads the contours, in this frame and in the previous one; usually
    /// [`Access::DRAW`]. It is [`Access::NONE`] if another queue reads them after a semaphore. Each frame in
    /// flight then needs contours of its own.
    pub reader: Access,
}

impl<'a> ContourFrame<'a> {
    /// Returns the parameters of contours on the surface's points 0, of a map that starts at time 0.
    pub fn new(levels: LevelInput<'a>, reader: Access) -> Self {
        Self { levels, start: 0.0, points: 0, reader }
    }

    /// Sets [`ContourFrame::levels`].
    pub fn with_levels(self, levels: LevelInput<'a>) -> Self {
        Self { levels, ..self }
    }

    /// Sets [`ContourFrame::start`].
    pub fn with_start(self, start: f32) -> Self {
        Self { start, ..self }
    }

    /// Sets [`ContourFrame::points`].
    pub fn with_points(self, points: usize) -> Self {
        Self { points, ..self }
    }

    /// Sets [`ContourFrame::reader`].
    pub fn with_reader(self, reader: Access) -> Self {
        Self { reader, ..self }
    }
}

const MOST_LEVELS: usize = LEVELS_TOGETHER as usize;
/// Largest number of words per grid row in which contours are counted.
const ROW_WORDS: usize = 1 + WORKGROUP as usize;

impl Contours {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        (solver, surface): (&Solver, &FrameSurface),
        vertices: u32,
        hosts: Option<vk::Buffer>,
    ) -> Result<Self, VulkanError> {
        let limits = &solver.limits;
        let (layout, buffers) = parts(limits, surface.grid.chart, vertices)?;
        let counts = buffers[1].size;
        let make = |pass| solver.pipelines.make(device, pass, Wavefront::Planar);
        let pipelines = [make(CONTOUR_COUNTS)?, make(CONTOUR_OFFSETS)?, make(CONTOUR_SEGMENTS)?];
        let info = CurvesInfo { layout, reads: Reads::Counts(counts), buffers: &buffers, hosts };
        let curves = Curves::new(device, allocator, (solver, surface), info)?;
        Ok(Self { curves, pipelines })
    }

    pub(super) fn bytes_for(
        device: &ash::Device,
        limits: &Limits,
        chart: Chart,
        vertices: u32,
    ) -> Result<u64, VulkanError> {
        limits.texels(chart)?;
        curves::bytes_for(device, &parts(limits, chart, vertices)?.1)
    }

    /// Returns where the contours are. They have a single [`super::CurveRecord`] and are drawn as a list of
    /// lines.
    pub fn curves(&self) -> CurveBuffer {
        self.curves.curves()
    }

    /// Returns the largest number of records that [`Recording::contours`] makes in a
    /// [`crate::vulkan::profile::Profile`], in addition to those of [`Solver::passes_of_frame`].
    pub fn passes(&self) -> u32 {
        self.pipelines.len() as u32 + 1
    }

    /// Returns the number of bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        self.curves.bytes()
    }

    /// Binds the surface's current points, after [`FrameSurface::set_points`] has replaced some of them.
    /// Recordings in flight still read the old points, which the host keeps alive until these recordings have
    /// run.
    ///
    /// # Errors
    /// If the contours were made for another surface or were destroyed, or all of their descriptor sets are
    /// in flight.
    pub fn rebind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
    ) -> Result<(), VulkanError> {
        self.curves.rebind(device, solver, surface)
    }

    /// Returns the smallest size in bytes of a buffer of the host for [`Solver::contours_into`].
    pub fn buffer_bytes(vertices: u32) -> u64 {
        layout_of(vertices).bytes()
    }

    /// Replaces the host's buffer in all later recordings of the contours. Recordings in flight still write
    /// the old buffer, which the host keeps alive until they have run.
    ///
    /// # Errors
    /// As for [`Contours::rebind`], or if the contours have a buffer of their own, or the new buffer is too
    /// small.
    pub fn set_buffer(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        self.curves.set_buffer(device, solver, surface, buffer)
    }

    /// Returns whether a recording of the contours may not have run. This is known with
    /// [`super::Tools::checks`] only.
    pub fn is_in_flight(&self) -> bool {
        self.curves.is_in_flight()
    }

    /// Frees everything. No submitted work may still use the contours. A second call does nothing.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        self.curves.destroy(device, allocator);
    }
}

impl Solver {
    /// Returns the number of bytes that contours take from the allocator's memory blocks on this device. No
    /// memory is allocated.
    ///
    /// # Errors
    /// As for [`Solver::contours`].
    pub fn bytes_for_contours(
        &self,
        device: &ash::Device,
        chart: Chart,
        vertices: u32,
    ) -> Result<u64, VulkanError> {
        Contours::bytes_for(device, &self.limits, chart, vertices)
    }

    /// Creates contours of a surface, with room for `vertices` vertices. A segment has two of them. The
    /// memory takes 24 bytes per vertex and 260 bytes per row of the grid. This is the only call that
    /// allocates for contours. The first call on a solver also creates the pipelines. The host calls
    /// [`Contours::destroy`] in the end.
    ///
    /// # Errors
    /// If there is no room for a segment, the buffer is larger than shaders can access, or memory runs out.
    /// Nothing is left behind then.
    pub fn contours(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
        vertices: u32,
    ) -> Result<Contours, VulkanError> {
        Contours::new(device, allocator, (self, surface), vertices, None)
    }

    /// Creates contours as [`Solver::contours`] does, but in a buffer of the host, from its first byte.
    /// [`Contours::buffer_bytes`] returns the size that the buffer needs. Its usages are `STORAGE_BUFFER` and
    /// those of its readers, such as `VERTEX_BUFFER`, `INDIRECT_BUFFER` or `SHADER_DEVICE_ADDRESS`.
    ///
    /// The host keeps the buffer alive until the recordings that write it have run, and destroys it. Each
    /// frame may use another buffer ([`Contours::set_buffer`]).
    ///
    /// # Errors
    /// As for [`Solver::contours`], or if the buffer is too small, as far as its memory requirements show
    /// that.
    pub fn contours_into(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
        vertices: u32,
        buffer: vk::Buffer,
    ) -> Result<Contours, VulkanError> {
        Contours::new(device, allocator, (self, surface), vertices, Some(buffer))
    }
}

fn layout_of(vertices: u32) -> CurveLayout {
    // A segment has two vertices.
    CurveLayout { curves: 1, capacity: vertices / 2 * 2, between: 0 }
}

/// Returns the layout, and the buffers for the curves and for levels and counts.
fn parts(
    limits: &Limits,
    chart: Chart,
    vertices: u32,
) -> Result<(CurveLayout, [BufferInfo; 2]), VulkanError> {
    let layout = layout_of(vertices);
    if layout.capacity == 0 {
        let reason = format!("{vertices} vertices are too few for a line");
        return Err(VulkanError::Curves { what: "contours", reason });
    }
    layout.check("contours", limits)?;
    let words = MOST_LEVELS + ROW_WORDS * chart.rows;
    let counts = BufferInfo {
        name: "counts of contours",
        size: (size_of::<u32>() * words) as u64,
        location: MemoryLocation::GpuOnly,
    };
    Ok((layout, [layout.info("contours"), counts]))
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
    /// Records the passes that find the contours of the map and lift them to the surface. Returns the buffer
    /// that receives them for the host to draw. The segments are ordered by their cells: from north to south,
    /// and within a row from west to east. The same map always gives the same order.
    ///
    /// Record them after the map: in the same command buffer, or after [`Recording::begin`] in another. The
    /// commands wait for earlier reads by the frame's `reader`, and later reads by that reader wait for the
    /// commands. `contours` must stay alive until the commands have run.
    ///
    /// The segments are those of [`crate::geometry::contours`]. Seen from the first vertex of a segment
    /// towards the second, nearer points lie to the left, in a picture of the grid with rows downwards. If
    /// there is too little room, the southern segments are left out. [`super::CurveRecord::vertices`] then
    /// holds the number of vertices that are needed.
    ///
    /// # Errors
    /// If the contours were destroyed or made for another surface, there is no map, the frame's points do not
    /// exist, are a metric or were replaced since the last [`Contours::rebind`], or the levels are not
    /// finite, not ascending or too many.
    pub fn contours(
        &self,
        contours: &Contours,
        frame: &ContourFrame,
    ) -> Result<CurveBuffer, VulkanError> {
        let curves = &contours.curves;
        curves.check(self, frame.points)?;
        let sets = curves.sets()?.sets();
        let (levels, count) = frame.levels.read()?;
        let (recorder, chart) = (&self.recorder, self.surface.grid.chart);
        let _group = recorder.group(c"geosweep: contours");
        let (stages, access) = frame.reader.side();
        let ours = (TRANSFER_WRITE.0 | SHADER.0, TRANSFER_WRITE.1 | SHADER.1);
        recorder.barrier((stages | SHADER.0, access | SHADER.1), ours);
        if count > 0 {
            recorder.update(curves.counts(), 0, bytemuck::cast_slice(&levels[..count]));
            recorder.barrier(TRANSFER_WRITE, SHADER);
        }
        let push = Push {
            grid: grid_size(chart),
            levels: count as u32,
            first_vertex: curves.layout.first_vertex() as i32,
            capacity: curves.layout.capacity as i32,
            start: frame.start,
        };
        // A row of cells lies between two rows of points.
        let rows = chart.rows as u32 - 1;
        let heights = [rows, 1, rows];
        for ((&pipeline, height), moved) in contours.pipelines.iter().zip(heights).zip(moved(chart))
        {
            let size = [WORKGROUP, height];
            let _pass = recorder.pass_moving(PassKind::Contours, moved);
            recorder.host_pass(pipeline, sets[0].set, &push, size);
            recorder.barrier(SHADER_WRITE, SHADER);
        }
        curves.lift(self, frame.points, frame.reader);
        Ok(contours.curves())
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
