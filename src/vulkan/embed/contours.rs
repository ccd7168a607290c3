//! Contours on the device, for drawing in the same frame.

use crate::vulkan::device_memory::DeviceMemory;
use ash::vk;
use gpu_allocator::MemoryLocation;

use super::access::Access;
use super::curves::{self, CurveBuffer, CurveLayout, Curves, CurvesInfo, Reads};
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::Surface;
use crate::constants::{LEVELS_TOGETHER, WORKGROUP};
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::barrier::{CLEAR, SHADER, SHADER_WRITE};
use crate::vulkan::limits::Limits;
use crate::vulkan::memory::BufferInfo;
use crate::vulkan::passes::{CONTOUR_COUNTS, CONTOUR_OFFSETS, CONTOUR_SEGMENTS};
use crate::vulkan::pipelines::Pipeline;
use crate::vulkan::profile::{PassKind, PassRecord, Work};
use crate::vulkan::record::dispatched;
use crate::vulkan::shaders::contour_counts::Push;

/// Room for the contours of a surface, and the passes that find them: [`Recording::contours`].
///
/// ```no_run
/// # use geosweep::ash::{self, vk};
/// # use geosweep::gpu_allocator::vulkan::Allocator;
/// # use geosweep::vulkan::{VulkanError, embed::*};
/// # fn host(
/// #     device: &ash::Device, allocator: &mut Allocator, solver: &Solver, surface: &Surface,
/// #     commands: vk::CommandBuffer,
/// # ) -> Result<(), VulkanError> {
/// // Once: room for 100 000 vertices.
/// let mut contours = solver.contours(device, allocator, surface, 100_000)?;
///
/// // Every frame, after the map:
/// let lines = solver.record(device, commands, surface).contours(&contours, &ContourFrame {
///     levels: LevelInput::Spacing { step: 10.0, count: 100 },
///     start: 0.0,
///     points: 0,
///     reader: Access::DRAW,
/// })?;
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
/// Dropping it frees nothing: the host calls [`Contours::destroy`], before or after the surface's.
#[derive(Debug)]
pub struct Contours {
    curves: Curves,
    /// In their order.
    pipelines: [Pipeline<Push>; 3],
}

/// At which times contours are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelInput<'a> {
    /// At these, ascending: at most 1024.
    List(&'a [f32]),
    /// At so many multiples of a distance, from the first: at most 1024. Those beyond the map's
    /// largest distance cost next to nothing.
    Spacing {
        /// From level to level; positive.
        step: f32,
        /// How many.
        count: usize,
    },
}

/// What [`Recording::contours`] takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourFrame<'a> {
    /// At which times.
    pub levels: LevelInput<'a>,
    /// The smallest initial value of the map's sources, 0 as a rule: where between grid points a
    /// contour runs follows from squares of the times since then.
    pub start: f32,
    /// The number of the surface's points to which contours are lifted.
    pub points: usize,
    /// How the host reads the contours, this frame and the frame before; [`Access::DRAW`] as a
    /// rule. [`Access::NONE`] on another queue, after a semaphore, with contours for each frame in
    /// flight.
    pub reader: Access,
}

const MOST_LEVELS: usize = LEVELS_TOGETHER as usize;
/// Everything a surface's contours are counted in is no longer than this for a row.
const ROW_WORDS: usize = 1 + WORKGROUP as usize;

impl Contours {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        (solver, surface): (&Solver, &Surface),
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

    /// Where the contours are: of a single [`super::CurveRecord`], drawn as a list of lines.
    pub fn curves(&self) -> CurveBuffer {
        self.curves.curves()
    }

    /// Most records that [`Recording::contours`] makes in a [`crate::vulkan::profile::Profile`],
    /// beside those of [`Solver::passes_of_frame`].
    pub fn passes(&self) -> u32 {
        self.pipelines.len() as u32 + 1
    }

    /// Bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        self.curves.bytes()
    }

    /// Has the contours read the surface's points that were replaced since they were made
    /// ([`Surface::set_points`]). Recordings in flight go on with those before.
    ///
    /// # Errors
    /// If they were made for another surface or destroyed, or all of their descriptor sets are in flight.
    pub fn rebind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &Surface,
    ) -> Result<(), VulkanError> {
        self.curves.rebind(device, solver, surface)
    }

    /// Bytes of a buffer of the host's: [`Solver::contours_into`].
    pub fn buffer_bytes(vertices: u32) -> u64 {
        layout_of(vertices).bytes()
    }

    /// Has contours from now on go to another buffer of the host's. Recordings in flight go on with the one before.
    ///
    /// # Errors
    /// As [`Contours::rebind`], or if they were made with a buffer of their own, or this one is too small.
    pub fn set_buffer(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &Surface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        self.curves.set_buffer(device, solver, surface, buffer)
    }

    /// Whether a recording of the contours may not have run: known with [`super::Tools::checks`] alone.
    pub fn is_in_flight(&self) -> bool {
        self.curves.is_in_flight()
    }

    /// Frees everything. No submitted work may still use the contours. A second call does nothing.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        self.curves.destroy(device, allocator);
    }
}

impl Solver {
    /// Bytes that contours take from the allocator's memory blocks on this device, before they are
    /// made.
    ///
    /// # Errors
    /// As [`Solver::contours`].
    pub fn bytes_for_contours(
        &self,
        device: &ash::Device,
        chart: Chart,
        vertices: u32,
    ) -> Result<u64, VulkanError> {
        Contours::bytes_for(device, &self.limits, chart, vertices)
    }

    /// Makes room for contours of a surface, of so many vertices, two for each of their segments:
    /// 24 bytes a vertex and 260 a row of the grid. The one call that allocates for contours; the first
    /// of the solver also makes their pipelines.
    ///
    /// # Errors
    /// If there is no room for a segment, more than shaders see in one buffer, or memory runs out.
    /// Nothing is left behind then.
    pub fn contours(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &Surface,
        vertices: u32,
    ) -> Result<Contours, VulkanError> {
        Contours::new(device, allocator, (self, surface), vertices, None)
    }

    /// The same with a buffer of the host's for what is drawn, from its first byte: with usage `STORAGE_BUFFER`, and `VERTEX_BUFFER`, `INDIRECT_BUFFER` or `SHADER_DEVICE_ADDRESS` as
    /// its readers ask for. [`Contours::buffer_bytes`] says how large
    /// it has to be. It is the host's to destroy, and may be another in each frame ([`Contours::set_buffer`]).
    ///
    /// # Errors
    /// As [`Solver::contours`], or if the buffer is too small, as far as that can be told.
    pub fn contours_into(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &Surface,
        vertices: u32,
        buffer: vk::Buffer,
    ) -> Result<Contours, VulkanError> {
        Contours::new(device, allocator, (self, surface), vertices, Some(buffer))
    }
}

fn layout_of(vertices: u32) -> CurveLayout {
    // Two a segment.
    CurveLayout { curves: 1, capacity: vertices / 2 * 2, between: 0 }
}

/// The layout, the buffer of curves and that of levels and counts.
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
    /// The levels in order, in an array that they may not fill.
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
                    return refuse(format!("level {} stands before {}", pair[0], pair[1]));
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
    /// Finds the contours of the map, lifts them to the surface and leaves them for the host to
    /// draw: the segments in the cells from north to south, each row's from west to east, in the
    /// same order whenever the map is the same. To be recorded after the map, in the same command
    /// buffer or after [`Recording::begin`]; the commands wait until the reader of commands before
    /// has done, and the reader of commands after waits for them.
    ///
    /// The segments are those of [`crate::geometry::contours`]: nearer points lie to the left of
    /// each, from its first vertex to its second, in a picture of the grid with rows downwards. If there
    /// are more than there is room for, the southern ones are left out, and
    /// [`super::CurveRecord::vertices`] says how much room there should be.
    ///
    /// # Errors
    /// If the contours were made for another surface, there is no map, its points are a metric, or the levels
    /// are not finite, not ascending or too many.
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
        let ours = (CLEAR.0 | SHADER.0, CLEAR.1 | SHADER.1);
        recorder.barrier((stages | SHADER.0, access | SHADER.1), ours);
        if count > 0 {
            recorder.update(curves.counts(), 0, bytemuck::cast_slice(&levels[..count]));
            recorder.barrier(CLEAR, SHADER);
        }
        let push = Push {
            grid: grid_size(chart),
            levels: count as u32,
            first_vertex: curves.layout.first_vertex() as i32,
            capacity: curves.layout.capacity as i32,
            start: frame.start,
        };
        // A row of cells has two of points.
        let rows = chart.rows as u32 - 1;
        let heights = [rows, 1, rows];
        for ((&pipeline, height), work) in contours.pipelines.iter().zip(heights).zip(works(chart))
        {
            let size = [WORKGROUP, height];
            let record = PassRecord { work, ..dispatched(PassKind::Contours, size) };
            let _pass = recorder.pass_with(record);
            recorder.host_pass(pipeline, sets[0].set, &push, size);
            recorder.barrier(SHADER_WRITE, SHADER);
        }
        curves.lift(self, frame.points, frame.reader);
        Ok(contours.curves())
    }
}

/// What the passes move: times of all points, and the counts of rows of cells and of their strips.
/// How many segments the last one writes, the device finds.
fn works(chart: Chart) -> [Work; 3] {
    let number = size_of::<u32>() as u64;
    let (times, rows) = (number * chart.points() as u64, number * (chart.rows as u64 - 1));
    let (counts, record) = (rows * ROW_WORDS as u64, 6 * number);
    [
        Work::of_bytes(times, counts),
        Work::of_bytes(rows, rows + record),
        Work { bytes_read: Some(times + counts), ..Work::default() },
    ]
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
            (LevelInput::List(&[1.0, 1.0]), "level 1 stands before 1"),
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
