//! Traces geodesic paths on the device, for drawing in the same frame.

use ash::vk;

use super::access::Access;
use super::creation::creation;
use super::curves::{CurveBuffer, CurveKind, CurveLayout, CurveRecord};
use super::host_sets;
use super::inputs::{PointSource, SourceInput};
use super::names::Labelled;
use super::outputs::{BufferKind, HostMemory, Output, OutputInfo};
use super::recording::{Recording, grid_size};
use super::solver::Solver;
use super::surface::FrameSurface;
use crate::constants::{
    CURVE_WORDS, PATH_WORDS, SLIDE_HALVINGS, SLIDE_ROUNDS, SLIDE_WINDOW, STEPS_TOGETHER, WORKGROUP,
};
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::device::barrier::{SHADER, SHADER_WRITE, TRANSFER, TRANSFER_WRITE};
use crate::vulkan::device::device_memory::DeviceMemory;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::passes::{PATH_DOUBLES, PATH_LENGTHS, PATH_SLIDES, PATH_STARTS, PATHS};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::path_starts::Push;
use crate::vulkan::profile::PassKind;
use crate::vulkan::record::Moved;
use crate::vulkan::setters::setters;

/// Buffer for the paths on a surface, and the passes that trace them: [`Recording::paths`].
pub type Paths = Output<PathKind>;

/// Kind of [`Paths`].
#[derive(Debug)]
pub struct PathKind {
    /// Pass that begins the paths, and pass that continues them and is repeated.
    pipelines: [Pipeline<Push>; 2],
    /// Passes that move the vertices of paths over a slowness.
    slides: Option<Slides>,
}

/// Passes that move the vertices of paths over a slowness to where the paths cost least.
#[derive(Debug)]
struct Slides {
    double: Pipeline<Push>,
    slide: Pipeline<Push>,
    measure: Pipeline<Push>,
}

/// Number of passes that move vertices.
const SLIDE_PASSES: u32 = SLIDE_ROUNDS * (1 + SLIDE_HALVINGS) + 1;

impl BufferKind for PathKind {}
impl CurveKind for PathKind {}

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
    /// Starts of the paths, at most [`PathsInfo::paths`]. Records without a start have the status
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
    /// Returns the parameters of paths on the surface's points with number 0. They do not wait for writes of the host.
    pub fn new(starts: StartInput<'a>, sources: SourceInput<'a>, reader: Access) -> Self {
        Self { before: Access::NONE, starts, sources, points: 0, reader }
    }

    setters! {
        with_before(before: Access);
        with_starts(starts: StartInput<'a>);
        with_sources(sources: SourceInput<'a>);
        with_points(points: usize);
        with_reader(reader: Access);
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
    /// Returns the smallest size in bytes of a buffer of the host for [`Solver::paths_into`].
    pub fn buffer_bytes(info: PathsInfo) -> u64 {
        layout_of(info).bytes()
    }
}

creation! {
    Paths(room: PathsInfo), buffer: Buffer(vk::Buffer);
    bytes_for_paths(room: PathsInfo);
    /// Creates paths on a surface. The memory takes 24 bytes per vertex and 104 bytes per path.
    paths;
    /// The buffer is used from its first byte. [`Paths::buffer_bytes`] returns the size that it needs. Its usages are
    /// `STORAGE_BUFFER`, `TRANSFER_DST` and those of its readers, such as `VERTEX_BUFFER`, `INDIRECT_BUFFER` or
    /// `SHADER_DEVICE_ADDRESS`.
    paths_into;
}

fn make(
    device: &ash::Device,
    (solver, surface): (&Solver, &FrameSurface),
    room: PathsInfo,
) -> Result<(OutputInfo, PathKind), VulkanError> {
    let mut info = info(&solver.limits, room)?;
    let variant = surface.finished_map(Wavefront::Planar);
    let make = |pass| solver.pipelines.make(device, pass, variant);
    let slides = if surface.grid.is_slowed() {
        info.passes += SLIDE_PASSES;
        let (double, slide) = (make(PATH_DOUBLES)?, make(PATH_SLIDES)?);
        Some(Slides { double, slide, measure: make(PATH_LENGTHS)? })
    } else {
        None
    };
    Ok((info, PathKind { pipelines: [make(PATH_STARTS)?, make(PATHS)?], slides }))
}

fn layout_of(PathsInfo { paths, vertices }: PathsInfo) -> CurveLayout {
    CurveLayout { curves: paths, capacity: vertices, between: (2 + PATH_WORDS) * paths }
}

/// Returns the only buffer. Starts and states of the paths lie between the records and the vertices.
fn info(limits: &Limits, room: PathsInfo) -> Result<OutputInfo, VulkanError> {
    let PathsInfo { paths, vertices } = room;
    let refuse = |reason| Err(VulkanError::Curves { what: "paths", reason });
    if paths == 0 || paths > MOST_PATHS {
        return refuse(format!(
            "the number of paths is {paths}, but must be from 1 to {MOST_PATHS}"
        ));
    }
    if vertices < 2 {
        return refuse(format!("{vertices} vertices are too few for a line"));
    }
    let layout = layout_of(room);
    // The passes write the sources, begin the paths, continue them, and lift them.
    let passes = 1 + 1 + passes_that_go_on(layout, MOST_TRACES) + 1;
    let (buffer, curves) = (layout.buffer("paths", limits)?, Some(layout));
    Ok(OutputInfo { buffer, counts: None, image: None, curves, passes })
}

impl Recording<'_> {
    /// Records the passes that trace paths from the frame's starts back to the sources, and lift them to the
    /// surface. Returns the buffer that receives them for the host to draw.
    ///
    /// The paths are those of [`crate::geometry::PathTracer`], in single precision. A path has at least one
    /// vertex at each grid line that it crosses, and ends at a source exactly. Over a slowness, its vertices slide to
    /// where it costs least; for that, there should be room for a second vertex at each grid point on its way. If there
    /// is no path to draw, its record says why ([`super::CurveRecord::status`]). For each path, every source is examined
    /// once, and again in each cell in which a source may lie.
    ///
    /// On a glued surface, paths cross seams. Two consecutive vertices are then the same point of the surface: the
    /// first at its row and column on one side of the seam, the second on the other side.
    ///
    /// # Errors
    /// If the paths were destroyed or made for another surface, there is no map, the frame's points do not
    /// exist or are a metric, points or sources were replaced since the last [`Output::rebind`], or starts or
    /// sources are too many or lie beyond their buffer.
    pub fn paths(&self, paths: &Paths, frame: &PathFrame) -> Result<CurveBuffer, VulkanError> {
        let layout = paths.layout();
        paths.check_points(self, frame.points)?;
        paths.check_sources(self, frame.sources)?;
        let count = frame.starts.count();
        check_starts(self.recorder.device, frame.starts, layout.curves as usize)?;
        let recorder = &self.recorder;
        let _group = self.group(Labelled::Paths);
        let (stages, access) = frame.reader.and(frame.before).side();
        let ours = (TRANSFER.0 | SHADER.0, TRANSFER.1 | SHADER.1);
        recorder.barrier((stages | SHADER.0, access | SHADER.1), ours);
        // The starts follow the records.
        let to = u64::from(CurveRecord::BYTES) * u64::from(layout.curves);
        match frame.starts {
            _ if count == 0 => {}
            StartInput::Inline(starts) => {
                recorder.update(paths.buffer(), to, bytemuck::cast_slice(starts));
            }
            StartInput::Buffer { buffer, offset, .. } => {
                let size = (START_BYTES * count) as u64;
                recorder.copy((buffer, offset), (paths.buffer(), to), size);
            }
        }
        recorder.barrier(TRANSFER_WRITE, SHADER);
        let (set, sources) = paths.read_sources(self, frame.sources)?;
        let batch = Push {
            grid: grid_size(self.surface.grid.chart),
            paths: count as i32,
            records: layout.curves as i32,
            first_vertex: layout.first_vertex() as i32,
            capacity: layout.capacity as i32,
            first_word: set.first_word,
            count: sources as i32,
            slowed: self.surface.grid.is_slowed().into(),
            halvings: 0,
        };
        // Only the device knows how many steps the paths take.
        let pass = |pipeline, batch: &Push, size, moved| {
            let _pass = recorder.pass_moving(PassKind::Paths, moved);
            recorder.map_pass(pipeline, set.set, batch, size);
            recorder.barrier(SHADER_WRITE, SHADER);
        };
        let PathKind { pipelines: [begin, go_on], slides } = &paths.kind;
        let each = [layout.curves, 1];
        let moved = moved_by_starts(layout.curves, count as u64, sources as u64);
        pass(*begin, &batch, each, moved);
        for _ in 0..passes_that_go_on(layout, traces(frame.sources)) {
            pass(*go_on, &batch, each, [None; 2]);
        }
        if let Some(Slides { double, slide, measure }) = slides {
            for _ in 0..SLIDE_ROUNDS {
                pass(*double, &batch, each, [None; 2]);
                for halvings in 0..SLIDE_HALVINGS {
                    let batch = Push { halvings: halvings as i32, ..batch };
                    pass(*slide, &batch, windows(layout), [None; 2]);
                }
            }
            pass(*measure, &batch, each, [None; 2]);
        }
        paths.lift(self, frame.points, frame.reader)
    }
}

/// Returns the number of invocations that move the vertices of paths, one for each window of each path.
fn windows(layout: CurveLayout) -> [u32; 2] {
    // The first window of every other pass is half as long.
    let windows = 1 + layout.capacity.div_ceil(SLIDE_WINDOW);
    [windows.next_multiple_of(WORKGROUP), layout.curves]
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
