//! Traces geodesic paths on the device, for drawing in the same frame.

use crate::vulkan::device::device_memory::DeviceMemory;
use ash::vk;

use super::access::Access;
use super::curves::{self, CurveBuffer, CurveLayout, CurveRecord, Curves, CurvesInfo, Reads};
use super::host_sets;
use super::inputs::{PointSource, SourceInput};
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::FrameSurface;
use crate::constants::{CURVE_WORDS, PATH_WORDS, STEPS_TOGETHER};
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::{SHADER, SHADER_WRITE, TRANSFER, TRANSFER_WRITE};
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::memory::BufferInfo;
use crate::vulkan::device::passes::{PATH_STARTS, PATHS};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::path_starts::Push;
use crate::vulkan::profile::PassKind;
use crate::vulkan::record::Moved;

/// Buffer for the paths on a surface, and the passes that trace them: [`Recording::paths`].
///
/// ```no_run
/// # use geosweep::ash::{self, vk};
/// # use geosweep::gpu_allocator::vulkan::Allocator;
/// # use geosweep::vulkan::{VulkanError, embed::*};
/// # fn host(
/// #     device: &ash::Device, allocator: &mut Allocator, solver: &Solver, surface: &FrameSurface,
/// #     commands: vk::CommandBuffer,
/// # ) -> Result<(), VulkanError> {
/// // Once: room for two paths.
/// let info = PathsInfo::new(2, 1000);
/// let mut paths = solver.paths(device, allocator, surface, info)?;
///
/// // Every frame, after the map:
/// let starts = StartInput::Inline(&[[20.5, 31.0], [200.0, 5.25]]);
/// let sources = [PointSource::at(120.5, 80.25)];
/// let frame = PathFrame::new(starts, SourceInput::Inline(&sources), Access::DRAW);
/// let strips = solver.record(device, commands, surface).paths(&paths, &frame)?;
/// // In the render pass, with a pipeline for a strip of lines:
/// unsafe {
///     device.cmd_bind_vertex_buffers(commands, 0, &[strips.buffer], &[strips.vertices_offset]);
///     for path in 0..2 {
///         let record = path * u64::from(CurveRecord::BYTES);
///         device.cmd_draw_indirect(commands, strips.buffer, record, 1, CurveRecord::BYTES);
///     }
/// }
///
/// // At the end, once no frame is in flight:
/// paths.destroy(device, allocator);
/// # Ok(()) }
/// ```
///
/// Dropping a value of this type frees nothing. The host calls [`Paths::destroy`], before or after it
/// destroys the surface.
#[derive(Debug)]
pub struct Paths {
    curves: Curves,
    /// Pass that begins the paths, and pass that continues them and is repeated.
    pipelines: [Pipeline<Push>; 2],
}

/// Room for paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PathsInfo {
    /// Largest number of paths at once, at most 65 535.
    pub paths: u32,
    /// Largest number of vertices of each path. A straight path has one vertex at each grid line that it
    /// crosses, so M + N + 8 are enough on a surface without obstacles.
    pub vertices: u32,
}

impl PathsInfo {
    /// Returns room for `paths` paths of up to `vertices` vertices each.
    pub const fn new(paths: u32, vertices: u32) -> Self {
        Self { paths, vertices }
    }
}

/// Starts of paths. Each is a row and a column, two floats. A start that is off the grid or NaN has no path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartInput<'a> {
    /// Starts in the program's memory, at most 8192. They are copied into the command buffer.
    Inline(&'a [[f32; 2]]),
    /// Starts in a buffer of the host with usage `TRANSFER_SRC`.
    Buffer {
        /// Buffer handle. The buffer must stay alive until the commands have run.
        buffer: vk::Buffer,
        /// Offset of the first start in bytes; a multiple of 4.
        offset: u64,
        /// Number of starts.
        count: u32,
    },
}

/// Parameters of [`Recording::paths`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PathFrame<'a> {
    /// Access by which the host has written starts and sources.
    pub before: Access,
    /// Starts of the paths, no more than there is room for. Records without a start have the status
    /// [`super::CurveStatus::Outside`] and draw nothing.
    pub starts: StartInput<'a>,
    /// All sources of the map, including those that were added to it.
    pub sources: SourceInput<'a>,
    /// Number of the surface's points to which the paths are lifted.
    pub points: usize,
    /// Access by which the host reads the paths, in this frame and in the previous one; usually
    /// [`Access::DRAW`]. It is [`Access::NONE`] if another queue reads them after a semaphore. Each frame in
    /// flight then needs paths of its own.
    pub reader: Access,
}

impl<'a> PathFrame<'a> {
    /// Returns the parameters of paths on the surface's points 0. They do not wait for writes of the host.
    pub fn new(starts: StartInput<'a>, sources: SourceInput<'a>, reader: Access) -> Self {
        Self { before: Access::NONE, starts, sources, points: 0, reader }
    }

    /// Sets [`PathFrame::before`].
    pub fn with_before(self, before: Access) -> Self {
        Self { before, ..self }
    }

    /// Sets [`PathFrame::starts`].
    pub fn with_starts(self, starts: StartInput<'a>) -> Self {
        Self { starts, ..self }
    }

    /// Sets [`PathFrame::sources`].
    pub fn with_sources(self, sources: SourceInput<'a>) -> Self {
        Self { sources, ..self }
    }

    /// Sets [`PathFrame::points`].
    pub fn with_points(self, points: usize) -> Self {
        Self { points, ..self }
    }

    /// Sets [`PathFrame::reader`].
    pub fn with_reader(self, reader: Access) -> Self {
        Self { reader, ..self }
    }
}

/// Largest number of starts that one command can copy into a command buffer.
const INLINE_STARTS: usize = 65_536 / START_BYTES;
const START_BYTES: usize = size_of::<[f32; 2]>();
const MOST_PATHS: u32 = 65_535;

impl StartInput<'_> {
    fn count(self) -> usize {
        match self {
            Self::Inline(starts) => starts.len(),
            Self::Buffer { count, .. } => count as usize,
        }
    }
}

impl Paths {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        (solver, surface): (&Solver, &FrameSurface),
        info: PathsInfo,
        hosts: Option<vk::Buffer>,
    ) -> Result<Self, VulkanError> {
        let limits = &solver.limits;
        let (layout, buffers) = parts(limits, info)?;
        let variant = surface.finished_map(Wavefront::Planar);
        let make = |pass| solver.pipelines.make(device, pass, variant);
        let pipelines = [make(PATH_STARTS)?, make(PATHS)?];
        let info = CurvesInfo { layout, reads: Reads::Sources, buffers: &buffers, hosts };
        let curves = Curves::new(device, allocator, (solver, surface), info)?;
        Ok(Self { curves, pipelines })
    }

    pub(super) fn bytes_for(
        device: &ash::Device,
        limits: &Limits,
        info: PathsInfo,
    ) -> Result<u64, VulkanError> {
        curves::bytes_for(device, &parts(limits, info)?.1)
    }

    /// Returns where the paths are. Each has a [`super::CurveRecord`] and is drawn as a strip of lines.
    pub fn curves(&self) -> CurveBuffer {
        self.curves.curves()
    }

    /// Returns the largest number of records that [`Recording::paths`] makes in a
    /// [`crate::vulkan::profile::Profile`], in addition to those of [`Solver::passes_of_frame`].
    pub fn passes(&self) -> u32 {
        // The passes write the sources, begin the paths, continue them, and lift them.
        1 + 1 + passes_that_go_on(self.curves.layout, MOST_TRACES) + 1
    }

    /// Returns the number of bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        self.curves.bytes()
    }

    /// Binds the surface's current points and sources, after [`FrameSurface::set_points`] or
    /// [`FrameSurface::set_sources`] has replaced some of them. Recordings in flight still read the old ones,
    /// which the host keeps alive until these recordings have run.
    ///
    /// # Errors
    /// If the paths were made for another surface or were destroyed, or all of their descriptor sets are in
    /// flight.
    pub fn rebind(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
    ) -> Result<(), VulkanError> {
        self.curves.rebind(device, solver, surface)
    }

    /// Returns the smallest size in bytes of a buffer of the host for [`Solver::paths_into`].
    pub fn buffer_bytes(info: PathsInfo) -> u64 {
        layout_of(info).bytes()
    }

    /// Replaces the host's buffer in all later recordings of the paths. Recordings in flight still write the
    /// old buffer, which the host keeps alive until they have run.
    ///
    /// # Errors
    /// As for [`Paths::rebind`], or if the paths have a buffer of their own, or the new buffer is too small.
    pub fn set_buffer(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &FrameSurface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        self.curves.set_buffer(device, solver, surface, buffer)
    }

    /// Returns whether a recording of the paths may not have run. This is known with [`super::Tools::checks`]
    /// only.
    pub fn is_in_flight(&self) -> bool {
        self.curves.is_in_flight()
    }

    /// Frees everything. No submitted work may still use the paths. A second call does nothing.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        self.curves.destroy(device, allocator);
    }
}

impl Solver {
    /// Returns the number of bytes that paths take from the allocator's memory blocks on this device. No
    /// memory is allocated.
    ///
    /// # Errors
    /// As for [`Solver::paths`].
    pub fn bytes_for_paths(
        &self,
        device: &ash::Device,
        info: PathsInfo,
    ) -> Result<u64, VulkanError> {
        Paths::bytes_for(device, &self.limits, info)
    }

    /// Creates paths on a surface. The memory takes 24 bytes per vertex and 104 bytes per path. This is the
    /// only call that allocates for paths. The first call on a solver also creates the pipelines. The host
    /// calls [`Paths::destroy`] in the end.
    ///
    /// # Errors
    /// If there is no room for a path, the buffer is larger than shaders can access, or memory runs out.
    /// Nothing is left behind then.
    pub fn paths(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
        info: PathsInfo,
    ) -> Result<Paths, VulkanError> {
        Paths::new(device, allocator, (self, surface), info, None)
    }

    /// Creates paths as [`Solver::paths`] does, but in a buffer of the host, from its first byte.
    /// [`Paths::buffer_bytes`] returns the size that the buffer needs. Its usages are `STORAGE_BUFFER`,
    /// `TRANSFER_DST` and those of its readers, such as `VERTEX_BUFFER`, `INDIRECT_BUFFER` or
    /// `SHADER_DEVICE_ADDRESS`.
    ///
    /// The host keeps the buffer alive until the recordings that write it have run, and destroys it. Each
    /// frame may use another buffer ([`Paths::set_buffer`]).
    ///
    /// # Errors
    /// As for [`Solver::paths`], or if the buffer is too small, as far as its memory requirements show that.
    pub fn paths_into(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &FrameSurface,
        info: PathsInfo,
        buffer: vk::Buffer,
    ) -> Result<Paths, VulkanError> {
        Paths::new(device, allocator, (self, surface), info, Some(buffer))
    }
}

fn layout_of(PathsInfo { paths, vertices }: PathsInfo) -> CurveLayout {
    CurveLayout { curves: paths, capacity: vertices, between: (2 + PATH_WORDS) * paths }
}

/// Returns the layout and the only buffer. Starts and states of the paths lie between the records and the
/// vertices.
fn parts(limits: &Limits, info: PathsInfo) -> Result<(CurveLayout, [BufferInfo; 1]), VulkanError> {
    let PathsInfo { paths, vertices } = info;
    let refuse = |reason| Err(VulkanError::Curves { what: "paths", reason });
    if paths == 0 || paths > MOST_PATHS {
        return refuse(format!(
            "the number of paths is {paths}, but must be from 1 to {MOST_PATHS}"
        ));
    }
    if vertices < 2 {
        return refuse(format!("{vertices} vertices are too few for a line"));
    }
    let layout = layout_of(info);
    layout.check("paths", limits)?;
    Ok((layout, [layout.info("paths")]))
}

impl Recording<'_> {
    /// Records the passes that trace paths from the frame's starts back to the sources, and lift them to the
    /// surface. Returns the buffer that receives them for the host to draw.
    ///
    /// Record them after the map: in the same command buffer, or after [`Recording::begin`] in another. The
    /// commands wait for the frame's `before` and for earlier reads by its `reader`. Later reads by that
    /// reader wait for the commands. `paths`, and the buffers of starts and sources, must stay alive until
    /// the commands have run.
    ///
    /// The paths are those of [`crate::geometry::PathTracer`], in single precision. A path has at least one
    /// vertex at each grid line that it crosses, and ends at a source exactly. If there is no path to draw,
    /// its record says why ([`super::CurveRecord::status`]). For each path, every source is examined once,
    /// and again in each cell in which a source may lie.
    ///
    /// On a glued surface paths go on over seams. Where a path crosses a seam, two consecutive vertices are the same
    /// place of the surface: the first at its row and column on one side of the seam, the second on the other side.
    ///
    /// # Errors
    /// If the paths were destroyed or made for another surface, there is no map, the frame's points do not
    /// exist or are a metric, points or sources were replaced since the last [`Paths::rebind`], or starts or
    /// sources are too many or lie beyond their buffer.
    pub fn paths(&self, paths: &Paths, frame: &PathFrame) -> Result<CurveBuffer, VulkanError> {
        let (curves, layout) = (&paths.curves, paths.curves.layout);
        curves.check(self, frame.points)?;
        self.check_sources(frame.sources)?;
        let sets = curves.sets()?;
        sets.check_sources(self.surface, frame.sources)?;
        let count = frame.starts.count();
        check_starts(self.recorder.device, frame.starts, layout.curves as usize)?;
        let recorder = &self.recorder;
        let _group = recorder.group(c"geosweep: paths");
        let (stages, access) = frame.reader.and(frame.before).side();
        let ours = (TRANSFER.0 | SHADER.0, TRANSFER.1 | SHADER.1);
        recorder.barrier((stages | SHADER.0, access | SHADER.1), ours);
        // The starts follow the records.
        let to = u64::from(CurveRecord::BYTES) * u64::from(layout.curves);
        match frame.starts {
            _ if count == 0 => {}
            StartInput::Inline(starts) => {
                recorder.update(curves.output(), to, bytemuck::cast_slice(starts));
            }
            StartInput::Buffer { buffer, offset, .. } => {
                let size = (START_BYTES * count) as u64;
                recorder.copy((buffer, offset), (curves.output(), to), size);
            }
        }
        recorder.barrier(TRANSFER_WRITE, SHADER);
        if let SourceInput::Inline(sources) = frame.sources {
            recorder.write_sources(bytemuck::cast_slice(sources));
        }
        let (inline, of_buffer) = (sets.sets()[0], |number| sets.sets()[1 + number]);
        let (set, sources) = self.sources_in(frame.sources, inline, of_buffer);
        let batch = Push {
            grid: grid_size(self.surface.grid.chart),
            paths: count as i32,
            records: layout.curves as i32,
            first_vertex: layout.first_vertex() as i32,
            capacity: layout.capacity as i32,
            first_word: set.first_word,
            count: sources as i32,
            slowed: self.surface.grid.is_slowed().into(),
        };
        let passes = passes_that_go_on(layout, traces(frame.sources));
        for pass in 0..=passes {
            let pipeline = paths.pipelines[usize::from(pass > 0)];
            let size = [layout.curves, 1];
            // Only the device knows how many steps the paths take.
            let moved = match pass {
                0 => moved_by_starts(layout.curves, count as u64, sources as u64),
                _ => [None; 2],
            };
            let _pass = recorder.pass_moving(PassKind::Paths, moved);
            recorder.map_pass(pipeline, set.set, &batch, size);
            recorder.barrier(SHADER_WRITE, SHADER);
        }
        curves.lift(self, frame.points, frame.reader);
        Ok(paths.curves())
    }
}

/// Returns the bytes moved to begin the paths. For each start, the pass reads the start and the times around
/// it, and writes a vertex. It reads the sources once. For each path, it writes the record and the state of
/// the path.
fn moved_by_starts(records: u32, starts: u64, sources: u64) -> Moved {
    let number = size_of::<f32>() as u64;
    let sources = if starts > 0 { size_of::<PointSource>() as u64 * sources } else { 0 };
    let records = number * u64::from(CURVE_WORDS + PATH_WORDS) * u64::from(records);
    // A vertex holds its time, row and column. A later pass lifts it.
    let read = starts * (START_BYTES as u64 + 4 * number) + sources;
    [Some(read), Some(records + starts * 3 * number)]
}

/// Returns the largest number of times that a path is traced. Sources with different initial values may take
/// more than one trace.
fn traces(sources: SourceInput) -> u32 {
    match sources {
        SourceInput::Inline(sources) if sources.windows(2).all(|s| s[0].time == s[1].time) => 1,
        _ => MOST_TRACES,
    }
}

const MOST_TRACES: u32 = 3;

/// Returns the number of passes after the first, if paths are traced `traces` times at most.
fn passes_that_go_on(layout: CurveLayout, traces: u32) -> u32 {
    traces * layout.capacity.div_ceil(STEPS_TOGETHER)
}

fn check_starts(device: &ash::Device, starts: StartInput, room: usize) -> Result<(), VulkanError> {
    let refuse = |reason| Err(VulkanError::Curves { what: "paths", reason });
    let count = starts.count();
    if count > room {
        return refuse(format!("{count} starts are more than the {room} paths there is room for"));
    }
    match starts {
        StartInput::Inline(_) if count > INLINE_STARTS => refuse(format!(
            "{count} starts are more than the {INLINE_STARTS} that a command holds: use a buffer"
        )),
        StartInput::Buffer { buffer, offset, .. } => {
            let bytes = (START_BYTES * count) as u64;
            host_sets::check_copied(device, "starts", (buffer, offset), bytes)
        }
        StartInput::Inline(_) => Ok(()),
    }
}
