//! Geodesic paths on the device, for drawing in the same frame.

use crate::vulkan::device_memory::DeviceMemory;
use ash::vk;

use super::access::Access;
use super::curves::{self, CurveBuffer, CurveLayout, CurveRecord, Curves, CurvesInfo, Reads};
use super::host_sets;
use super::inputs::{PointSource, SourceInput};
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::Surface;
use crate::constants::{CURVE_WORDS, PATH_WORDS, STEPS_TOGETHER};
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::barrier::{CLEAR, SHADER, SHADER_WRITE, TRANSFER};
use crate::vulkan::limits::Limits;
use crate::vulkan::memory::BufferInfo;
use crate::vulkan::passes::{PATH_STARTS, PATHS};
use crate::vulkan::pipelines::Pipeline;
use crate::vulkan::profile::{PassKind, PassRecord, Work};
use crate::vulkan::record::dispatched;
use crate::vulkan::shaders::path_starts::Push;

/// Room for paths on a surface, and the passes that trace them: [`Recording::paths`].
///
/// ```no_run
/// # use geosweep::ash::{self, vk};
/// # use geosweep::gpu_allocator::vulkan::Allocator;
/// # use geosweep::vulkan::{VulkanError, embed::*};
/// # fn host(
/// #     device: &ash::Device, allocator: &mut Allocator, solver: &Solver, surface: &Surface,
/// #     commands: vk::CommandBuffer,
/// # ) -> Result<(), VulkanError> {
/// // Once: room for two paths.
/// let info = PathsInfo { paths: 2, vertices: 1000 };
/// let mut paths = solver.paths(device, allocator, surface, info)?;
///
/// // Every frame, after the map:
/// let strips = solver.record(device, commands, surface).paths(&paths, &PathFrame {
///     before: Access::NONE,
///     starts: StartInput::Inline(&[[20.5, 31.0], [200.0, 5.25]]),
///     sources: SourceInput::Inline(&[PointSource::at(120.5, 80.25)]),
///     points: 0,
///     reader: Access::DRAW,
/// })?;
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
/// Dropping it frees nothing: the host calls [`Paths::destroy`], before or after the surface's.
#[derive(Debug)]
pub struct Paths {
    curves: Curves,
    /// The pass that begins, and the one that goes on, over and over.
    pipelines: [Pipeline<Push>; 2],
}

/// Room for paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathsInfo {
    /// How many at once: at most 65 535.
    pub paths: u32,
    /// Vertices of each. A straight way has one at each grid line that it crosses, so that M + N + 8
    /// are enough where nothing is in the way.
    pub vertices: u32,
}

/// Where paths start: row and column, two floats each. What is off the grid or not a number has no
/// path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartInput<'a> {
    /// From the program's memory, copied into the command buffer: at most 8192.
    Inline(&'a [[f32; 2]]),
    /// From a buffer of the host's with usage `TRANSFER_SRC`.
    Buffer {
        /// The buffer.
        buffer: vk::Buffer,
        /// Bytes before the first; a multiple of 4.
        offset: u64,
        /// How many.
        count: u32,
    },
}

/// What [`Recording::paths`] takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathFrame<'a> {
    /// How the host has written starts and sources.
    pub before: Access,
    /// Where paths start, no more than there is room for; the other records say
    /// [`super::CurveStatus::Outside`] and draw nothing.
    pub starts: StartInput<'a>,
    /// All sources of the map, those added to it too.
    pub sources: SourceInput<'a>,
    /// The number of the surface's points to which paths are lifted.
    pub points: usize,
    /// How the host reads the paths, this frame and the frame before; [`Access::DRAW`] as a rule.
    /// [`Access::NONE`] on another queue, after a semaphore, with paths for each frame in flight.
    pub reader: Access,
}

/// What one command may copy into a command buffer.
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
        (solver, surface): (&Solver, &Surface),
        info: PathsInfo,
        hosts: Option<vk::Buffer>,
    ) -> Result<Self, VulkanError> {
        let limits = &solver.limits;
        let (layout, buffers) = parts(limits, info)?;
        let make = |pass| solver.pipelines.make(device, pass, Wavefront::Planar);
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

    /// Where the paths are: a [`super::CurveRecord`] each, drawn as a strip of lines.
    pub fn curves(&self) -> CurveBuffer {
        self.curves.curves()
    }

    /// Most records that [`Recording::paths`] makes in a [`crate::vulkan::profile::Profile`], beside
    /// those of [`Solver::passes_of_frame`].
    pub fn passes(&self) -> u32 {
        // Sources come, paths begin and go on, and are lifted.
        1 + 1 + passes_that_go_on(self.curves.layout, MOST_TRACES) + 1
    }

    /// Bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        self.curves.bytes()
    }

    /// Has the paths read the surface's points and sources that were replaced since they were made
    /// ([`Surface::set_points`], [`Surface::set_sources`]). Recordings in flight go on with those before.
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

    /// Bytes of a buffer of the host's: [`Solver::paths_into`].
    pub fn buffer_bytes(info: PathsInfo) -> u64 {
        layout_of(info).bytes()
    }

    /// Has paths from now on go to another buffer of the host's. Recordings in flight go on with the one before.
    ///
    /// # Errors
    /// As [`Paths::rebind`], or if they were made with a buffer of their own, or this one is too small.
    pub fn set_buffer(
        &mut self,
        device: &ash::Device,
        solver: &Solver,
        surface: &Surface,
        buffer: vk::Buffer,
    ) -> Result<(), VulkanError> {
        self.curves.set_buffer(device, solver, surface, buffer)
    }

    /// Whether a recording of the paths may not have run: known with [`super::Tools::checks`] alone.
    pub fn is_in_flight(&self) -> bool {
        self.curves.is_in_flight()
    }

    /// Frees everything. No submitted work may still use the paths. A second call does nothing.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        self.curves.destroy(device, allocator);
    }
}

impl Solver {
    /// Bytes that paths take from the allocator's memory blocks on this device, before they are
    /// made.
    ///
    /// # Errors
    /// As [`Solver::paths`].
    pub fn bytes_for_paths(
        &self,
        device: &ash::Device,
        info: PathsInfo,
    ) -> Result<u64, VulkanError> {
        Paths::bytes_for(device, &self.limits, info)
    }

    /// Makes room for paths on a surface: 24 bytes a vertex and 104 a path. The one call that
    /// allocates for paths; the first of the solver also makes their pipelines.
    ///
    /// # Errors
    /// If there is no room for a path, more than shaders see in one buffer, or memory runs out.
    /// Nothing is left behind then.
    pub fn paths(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &Surface,
        info: PathsInfo,
    ) -> Result<Paths, VulkanError> {
        Paths::new(device, allocator, (self, surface), info, None)
    }

    /// The same with a buffer of the host's for what is drawn, from its first byte: with usage `STORAGE_BUFFER` and `TRANSFER_DST`, and `VERTEX_BUFFER`, `INDIRECT_BUFFER` or
    /// `SHADER_DEVICE_ADDRESS` as its readers ask for. [`Paths::buffer_bytes`] says how large
    /// it has to be. It is the host's to destroy, and may be another in each frame ([`Paths::set_buffer`]).
    ///
    /// # Errors
    /// As [`Solver::paths`], or if the buffer is too small, as far as that can be told.
    pub fn paths_into(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        surface: &Surface,
        info: PathsInfo,
        buffer: vk::Buffer,
    ) -> Result<Paths, VulkanError> {
        Paths::new(device, allocator, (self, surface), info, Some(buffer))
    }
}

fn layout_of(PathsInfo { paths, vertices }: PathsInfo) -> CurveLayout {
    CurveLayout { curves: paths, capacity: vertices, between: (2 + PATH_WORDS) * paths }
}

/// The layout and the one buffer; starts and states lie between records and vertices.
fn parts(limits: &Limits, info: PathsInfo) -> Result<(CurveLayout, [BufferInfo; 1]), VulkanError> {
    let PathsInfo { paths, vertices } = info;
    let refuse = |reason| Err(VulkanError::Curves { what: "paths", reason });
    if paths == 0 || paths > MOST_PATHS {
        return refuse(format!("{paths} at once are not between 1 and {MOST_PATHS}"));
    }
    if vertices < 2 {
        return refuse(format!("{vertices} vertices are too few for a line"));
    }
    let layout = layout_of(info);
    layout.check("paths", limits)?;
    Ok((layout, [layout.info("paths")]))
}

impl Recording<'_> {
    /// Traces the paths from some places back to the source, lifts them to the surface and leaves
    /// them for the host to draw. To be recorded after the map, in the same command buffer or after
    /// [`Recording::begin`]; the commands wait for what `before` has written and until the reader of
    /// commands before has done, and the reader of commands after waits for them.
    ///
    /// The paths are those of [`crate::geometry::Paths`], in single precision. A path has one
    /// vertex at least at each grid line that it crosses, and ends at a source exactly. If there is
    /// none to draw, its record says why ([`super::CurveRecord::status`]). Each looks at each source
    /// once, and again where one may lie in its cell.
    ///
    /// # Errors
    /// If the paths were made for another surface, there is no map, its points are a metric, or starts or
    /// sources are too many, or beyond their buffer.
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
        recorder.barrier(CLEAR, SHADER);
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
        };
        let passes = passes_that_go_on(layout, traces(frame.sources));
        for pass in 0..=passes {
            let pipeline = paths.pipelines[usize::from(pass > 0)];
            let size = [layout.curves, 1];
            // How many steps paths take, the device finds.
            let work = match pass {
                0 => work_of_starts(layout.curves, count as u64, sources as u64),
                _ => Work::default(),
            };
            let record = PassRecord { work, ..dispatched(PassKind::Paths, size) };
            let _pass = recorder.pass_with(record);
            recorder.host_pass(pipeline, set.set, &batch, size);
            recorder.barrier(SHADER_WRITE, SHADER);
        }
        curves.lift(self, frame.points, frame.reader);
        Ok(paths.curves())
    }
}

/// What it moves to begin a path at each of so many starts: the start, the times around it, and the
/// sources; for each record itself and the path's state, and a vertex of each path.
fn work_of_starts(records: u32, starts: u64, sources: u64) -> Work {
    let number = size_of::<f32>() as u64;
    let sources = if starts > 0 { size_of::<PointSource>() as u64 * sources } else { 0 };
    let records = number * u64::from(CURVE_WORDS + PATH_WORDS) * u64::from(records);
    // A vertex is lifted later: its time, row and column.
    Work::of_bytes(
        starts * (START_BYTES as u64 + 4 * number) + sources,
        records + starts * 3 * number,
    )
}

/// How often a path may be traced: again where sources have unlike initial values.
fn traces(sources: SourceInput) -> u32 {
    match sources {
        SourceInput::Inline(sources) if sources.windows(2).all(|s| s[0].time == s[1].time) => 1,
        _ => MOST_TRACES,
    }
}

const MOST_TRACES: u32 = 3;

/// After the one that begins, if paths are traced so often at most.
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
