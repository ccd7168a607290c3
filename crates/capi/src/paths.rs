//! Geodesic paths for drawing in the same frame.

use ash::vk;
use ash::vk::Handle;

use super::arguments::{list, reference, write};
use super::curves::GeosweepCurves;
use super::frame::{GeosweepAccess, GeosweepSources, access, sources};
use super::objects::{kind_of_object, object};
use super::outputs;
use super::record::record;
use super::shared::Made;
use super::solver::GeosweepSolver;
use super::status::{Failure, calls};
use super::surface::GeosweepSurface;
use geosweep::vulkan::embed::{self, PathsInfo, StartInput};

/// Largest number of starts in a recording from the program's memory.
const MOST_STARTS: usize = 8192;

/// Buffer for the paths on a surface, and the passes that trace them. Frames in flight on one queue share one
/// such object. If paths are read on other queues, create one object for each of these queues.
pub struct GeosweepPaths(());

kind_of_object! { GeosweepPaths, paths: Made<embed::Paths> }

/// Starts and ends of paths, and the commands that read the paths. The starts are an array in the program's
/// memory, which is copied into the command buffer, or, if `starts` is null, in a buffer.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepPathFrame {
    /// Access that has written starts and sources.
    pub before: GeosweepAccess,
    /// Array with two floats per start, row and column; or null. A start that is off the grid or NaN has no
    /// path.
    pub starts: *const f32,
    /// Buffer of starts with usage `VK_BUFFER_USAGE_TRANSFER_SRC_BIT`, or null.
    pub start_buffer: vk::Buffer,
    /// Offset of the first start in the buffer in bytes; a multiple of 4.
    pub start_offset: u64,
    /// Number of starts. It is at most the number of paths that there is room for, and at most 8192 in an
    /// array. The records of the remaining paths say that they have no start, and these paths draw nothing.
    pub start_count: u32,
    /// Number of the surface's points to which paths are lifted.
    pub points: u32,
    /// Offset in bytes, added to the offset of these points in the surface's buffer, as
    /// `GeosweepFrame::points_offset`.
    pub points_offset: u64,
    /// All sources of the map, including those that were added to the map.
    pub sources: GeosweepSources,
    /// Access that reads the paths, in this frame and in the previous one, as in `GeosweepContourFrame`.
    pub reader: GeosweepAccess,
}

calls! {
    /// Computes the bytes of device memory that paths will take, before they are created: 24 for each vertex of
    /// each path, and 104 per path.
    fn geosweep_paths_bytes_for(
        solver: *const GeosweepSolver,
        path_count: u32,
        vertices: u32,
        bytes: *mut u64,
    ) {
        outputs::bytes_for(solver, bytes, |solver, device| {
            Ok(solver.bytes_for_paths(device, PathsInfo::new(path_count, vertices))?)
        })?;
    }

    /// Creates paths on a surface: `path_count` paths at once, at most 65535, with room for `vertices` vertices
    /// each. A straight path has one vertex at each grid line that it crosses, so rows + cols + 8 vertices are
    /// enough on a surface without obstacles. Allocates device memory and compiles passes.
    /// `geosweep_paths_destroy` destroys the paths.
    fn geosweep_paths_create(
        surface: *const GeosweepSurface,
        path_count: u32,
        vertices: u32,
        paths: *mut *mut GeosweepPaths,
    ) {
        let info = PathsInfo::new(path_count, vertices);
        outputs::create(surface, paths, |solver, device, memory, surface| {
            solver.paths(device, memory, surface, info)
        })?;
    }

    /// Computes the bytes that your own buffer for paths must have, if you provide one.
    fn geosweep_paths_buffer_bytes(count: u32, vertices: u32, bytes: *mut u64) {
        write(bytes, "bytes", embed::Paths::buffer_bytes(PathsInfo::new(count, vertices)))?;
    }

    /// Creates paths as `geosweep_paths_create` does, in your own buffer from its first byte. The buffer's usage
    /// contains `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`, `VK_BUFFER_USAGE_TRANSFER_DST_BIT` and what its readers
    /// need, device addresses included. The buffer remains yours. While no paths are in use, a render graph may
    /// use its memory for other resources.
    fn geosweep_paths_create_into(
        surface: *const GeosweepSurface,
        count: u32,
        vertices: u32,
        buffer: vk::Buffer,
        paths: *mut *mut GeosweepPaths,
    ) {
        let info = PathsInfo::new(count, vertices);
        outputs::create(surface, paths, |solver, device, memory, surface| {
            solver.paths_into(device, memory, surface, info, buffer)
        })?;
    }

    /// Makes paths write to another buffer of yours in later recordings. The paths must have been created with
    /// your own buffer. Recordings in flight continue to use the previous buffer.
    fn geosweep_paths_set_buffer(
        paths: *mut GeosweepPaths,
        surface: *const GeosweepSurface,
        buffer: vk::Buffer,
    ) {
        outputs::set_buffer(paths, surface, buffer)?;
    }

    /// Returns the bytes of device memory that paths take.
    fn geosweep_paths_bytes(paths: *const GeosweepPaths, bytes: *mut u64) {
        outputs::bytes(paths, bytes)?;
    }

    /// Returns where paths are stored, also before any are recorded. Each path is one curve, drawn as a strip of
    /// lines.
    fn geosweep_paths_curves(paths: *const GeosweepPaths, curves: *mut GeosweepCurves) {
        write(curves, "curves", object(paths)?.of.curves().into())?;
    }

    /// Records the tracing of paths from their starts back to the sources. Lifts them to the surface and stores
    /// them for you to draw. Call this after the map was recorded, in the same command buffer or after
    /// `geosweep_record_begin`. The record of a path that cannot be drawn gives the reason. Writes where paths
    /// are stored to `result` unless that is null.
    fn geosweep_record_paths(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        paths: *const GeosweepPaths,
        frame: *const GeosweepPathFrame,
        result: *mut GeosweepCurves,
    ) {
        record(surface, commands, result, |_, recording| {
            let (paths, given) = (object(paths)?, reference(frame, "frame")?);
            let (starts, sources) =
                (starts(given)?, sources(&given.sources, "frame->sources.sources")?);
            let reader = access(given.reader, "frame->reader")?;
            let frame = embed::PathFrame::new(starts, sources, reader)
                .with_before(access(given.before, "frame->before")?)
                .with_points(given.points as usize);
            Ok(recording.points_at(given.points_offset).paths(&paths.of, &frame)?)
        })?;
    }

    /// Makes paths read the surface's points and sources that `geosweep_surface_set_points` and
    /// `geosweep_surface_set_sources` have set since the paths were created. Recordings in flight continue to
    /// read the previous inputs.
    fn geosweep_paths_rebind(paths: *mut GeosweepPaths, surface: *const GeosweepSurface) {
        outputs::rebind(paths, surface)?;
    }

    /// Destroys paths, before or after their surface. No submitted work may still use them; a solver with checks
    /// verifies that. Null is allowed.
    fn geosweep_paths_destroy(paths: *mut GeosweepPaths) {
        outputs::destroy(paths)?;
    }
}

/// Returns the starts of a frame.
///
/// # Safety
/// The array has `start_count` entries.
unsafe fn starts<'a>(given: &GeosweepPathFrame) -> Result<StartInput<'a>, Failure> {
    let GeosweepPathFrame { starts, start_buffer, start_offset, start_count, .. } = *given;
    if start_buffer.is_null() {
        let starts = starts.cast::<[f32; 2]>();
        // SAFETY: the caller's promise.
        let starts = unsafe { list(starts, start_count, MOST_STARTS, "frame->starts") };
        return starts.map(StartInput::Inline);
    }
    if !starts.is_null() {
        let reason = "and frame->start_buffer are both given: one of them is null";
        return Err(Failure::argument("frame->starts", reason));
    }
    Ok(StartInput::Buffer { buffer: start_buffer, offset: start_offset, count: start_count })
}
