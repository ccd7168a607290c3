//! Geodesic paths for drawing in the same frame.

use std::sync::Arc;

use ash::vk;
use ash::vk::Handle;

use super::arguments::{Output, list, reference};
use super::curves::GeosweepCurves;
use super::frame::{GeosweepAccess, GeosweepSources, access, sources};
use super::objects::{exclusive, hand_out, land, object, take};
use super::record::{output_unless_null, record};
use super::solver::{GeosweepSolver, Shared};
use super::status::{Failure, GeosweepStatus, guard};
use super::surface::GeosweepSurface;
use crate::vulkan::embed::{self, PathsInfo, Recording, StartInput};

/// Starts of a recording from the program's memory, at most.
const MOST_STARTS: usize = 8192;

/// Room for paths on a surface, and the passes that trace them. Frames in flight on one queue share
/// it; with readers on another queue make one for each.
pub struct GeosweepPaths {
    pub(super) shared: Arc<Shared>,
    paths: embed::Paths,
}

/// Where paths start, where they end, and who draws them. Starts are an array of the program's, which
/// is copied into the command buffer, or, if that is null, in a buffer.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepPathFrame {
    /// How you have written starts and sources.
    pub before: GeosweepAccess,
    /// Two floats a start, row and column; or null. One that is off the grid or not a number has no
    /// path.
    pub starts: *const f32,
    /// With usage `VK_BUFFER_USAGE_TRANSFER_SRC_BIT`, or null.
    pub start_buffer: vk::Buffer,
    /// Bytes before the first in the buffer; a multiple of 4.
    pub start_offset: u64,
    /// How many: no more than there is room for, and at most 8192 in an array. Other paths have a
    /// record that says so, and draw nothing.
    pub start_count: u32,
    /// The number of the surface's points to which paths are lifted.
    pub points: u32,
    /// Bytes beyond where the surface has these points, as `GeosweepFrame::points_offset`.
    pub points_offset: u64,
    /// All sources of the map, those added to it too.
    pub sources: GeosweepSources,
    /// How you read the paths, this frame and the frame before, as of `GeosweepContourFrame`.
    pub reader: GeosweepAccess,
}

/// Says how many bytes of device memory paths will take, before they are made: 24 a vertex of each,
/// and 104 a path.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_paths_bytes_for(
    solver: *const GeosweepSolver,
    path_count: u32,
    vertices: u32,
    bytes: *mut u64,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (solver, output) = unsafe { (object(solver, "solver")?, Output::new(bytes, "bytes")?) };
        let Shared { solver, device, .. } = &**solver.shared();
        output.write(solver.bytes_for_paths(device, PathsInfo { paths: path_count, vertices })?);
        Ok(())
    })
}

/// Makes room for paths on a surface: so many at once, at most 65535, of so many vertices each. A
/// straight way has one at each grid line that it crosses, so that rows + cols + 8 are enough where
/// nothing is in the way. `geosweep_paths_destroy` destroys it. Takes device memory and compiles
/// passes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_paths_create(
    surface: *const GeosweepSurface,
    path_count: u32,
    vertices: u32,
    paths: *mut *mut GeosweepPaths,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (surface, output) =
            unsafe { (object(surface, "surface")?, Output::new(paths, "paths")?) };
        let GeosweepSurface { shared, surface, .. } = surface;
        let info = PathsInfo { paths: path_count, vertices };
        let mut allocator = shared.allocator();
        let paths = shared.solver.paths(&shared.device, &mut allocator, surface, info)?;
        hand_out(output, GeosweepPaths { shared: Arc::clone(shared), paths });
        Ok(())
    })
}

/// Says how many bytes a buffer of yours has for paths, in place of one of their own.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_paths_buffer_bytes(
    count: u32,
    vertices: u32,
    bytes: *mut u64,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let output = unsafe { Output::new(bytes, "bytes") }?;
        output.write(embed::Paths::buffer_bytes(embed::PathsInfo { paths: count, vertices }));
        Ok(())
    })
}

/// Makes paths as `geosweep_paths_create` does, which go to a buffer of yours, from its first byte: with usage
/// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT` and `VK_BUFFER_USAGE_TRANSFER_DST_BIT` and what
/// its readers ask for, device addresses too. It stays yours, and a render graph may give its memory to others meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_paths_create_into(
    surface: *const GeosweepSurface,
    count: u32,
    vertices: u32,
    buffer: vk::Buffer,
    paths: *mut *mut GeosweepPaths,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (surface, output) =
            unsafe { (object(surface, "surface")?, Output::new(paths, "paths")?) };
        let info = embed::PathsInfo { paths: count, vertices };
        let GeosweepSurface { shared, surface, .. } = surface;
        let mut allocator = shared.allocator();
        let (solver, device) = (&shared.solver, &shared.device);
        let paths = solver.paths_into(device, &mut allocator, surface, info, buffer)?;
        hand_out(output, GeosweepPaths { shared: Arc::clone(shared), paths });
        Ok(())
    })
}

/// Has paths from now on go to another buffer of yours, if they were made with one. Recordings in flight go on with the
/// one before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_paths_set_buffer(
    paths: *mut GeosweepPaths,
    surface: *const GeosweepSurface,
    buffer: vk::Buffer,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, surface) = unsafe { (exclusive(paths, "paths")?, object(surface, "surface")?) };
        let Shared { device, solver, .. } = &*surface.shared;
        Ok(of.paths.set_buffer(device, solver, &surface.surface, buffer)?)
    })
}

/// Says how many bytes of device memory paths take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_paths_bytes(
    paths: *const GeosweepPaths,
    bytes: *mut u64,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (paths, output) = unsafe { (object(paths, "paths")?, Output::new(bytes, "bytes")?) };
        output.write(paths.paths.bytes());
        Ok(())
    })
}

/// Says where paths are, also before any are recorded: a curve each, drawn as a strip of lines.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_paths_curves(
    paths: *const GeosweepPaths,
    curves: *mut GeosweepCurves,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (paths, output) = unsafe { (object(paths, "paths")?, Output::new(curves, "curves")?) };
        output.write(paths.paths.curves().into());
        Ok(())
    })
}

/// Traces the paths from some places back to the source, lifts them to the surface and leaves them
/// for you to draw. To be recorded after the map, in the same command buffer or after
/// `geosweep_record_begin`. If there is none to draw, its record says why. Gives where they are to
/// `result` unless that is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_paths(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    paths: *const GeosweepPaths,
    frame: *const GeosweepPathFrame,
    result: *mut GeosweepCurves,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        // SAFETY: the caller's promise.
        let (output, paths, given, starts, sources) = unsafe {
            let output = output_unless_null(result)?;
            let paths = object(paths, "paths")?;
            let given = reference(frame, "frame")?;
            (
                output,
                paths,
                given,
                starts(given)?,
                sources(&given.sources, "frame->sources.sources")?,
            )
        };
        let curves = recording.points_at(given.points_offset).paths(
            &paths.paths,
            &embed::PathFrame {
                before: access(given.before, "frame->before")?,
                starts,
                sources,
                points: given.points as usize,
                reader: access(given.reader, "frame->reader")?,
            },
        )?;
        if let Some(output) = output {
            output.write(curves.into());
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// # Safety
/// The array is as long as is said.
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

/// Has paths read the surface's points and sources that were replaced since they were made, by
/// `geosweep_surface_set_points` and `geosweep_surface_set_sources`. Recordings in flight go on with those before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_paths_rebind(
    paths: *mut GeosweepPaths,
    surface: *const GeosweepSurface,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, surface) = unsafe { (exclusive(paths, "paths")?, object(surface, "surface")?) };
        let Shared { device, solver, .. } = &*surface.shared;
        Ok(of.paths.rebind(device, solver, &surface.surface)?)
    })
}

/// Destroys paths, before or after their surface. No submitted work may still use them, which a
/// solver with checks looks at. Null is fine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_paths_destroy(paths: *mut GeosweepPaths) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let Some(_) = (unsafe { land(paths, "paths", |of| of.paths.is_in_flight()) })? else {
            return Ok(());
        };
        // SAFETY: the caller's promise.
        let Some(paths) = unsafe { take(paths, "paths") }? else { return Ok(()) };
        let GeosweepPaths { shared, mut paths } = paths;
        paths.destroy(&shared.device, &mut shared.allocator());
        Ok(())
    })
}
