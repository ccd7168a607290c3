//! Records into the host's command buffer.

use std::sync::Arc;

use ash::vk;
use ash::vk::Handle;

use super::arguments::{Output, list, reference};
use super::frame::{
    GEOSWEEP_POINTS_UNCHANGED, GeosweepAccess, GeosweepFrame, GeosweepReader, GeosweepSources,
    access, limit, reader, sources, unreached,
};
use super::objects::object;
use super::plan::{GeosweepPlan, plan};
use super::shared::Shared;
use super::status::{Failure, GeosweepStatus, guard};
use super::surface::{GeosweepImage, GeosweepOutcome, GeosweepSurface};
use crate::vulkan::embed::{self, Recording, SourceInput};
use crate::vulkan::record::MOST_TOGETHER;

/// Size in bytes of the record that `geosweep_record_outcome_to` copies.
pub const GEOSWEEP_OUTCOME_BYTES: u32 = 72;
const _: () = assert!(GEOSWEEP_OUTCOME_BYTES as usize == embed::Outcome::BYTES);

/// Runs `body` with a recording for a surface.
///
/// # Safety
/// `surface` is null or a surface's pointer. `commands` is null or a command buffer that is being recorded.
pub(super) unsafe fn record(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    append: impl FnOnce(&GeosweepSurface, Recording) -> Result<(), Failure>,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let surface = unsafe { object(surface, "surface") }?;
        if commands.is_null() {
            return Err(Failure::argument("commands", "is the null handle"));
        }
        let GeosweepSurface { shared, surface: of, .. } = surface;
        append(surface, shared.solver.record(&shared.device, commands, of))
    })
}

/// Prepares a new surface. Record this once, before anything else of that surface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_prepare(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        recording.prepare();
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Records all parts of a usual frame: `begin`, `measure` if there are new points, `solve`, `outcome` and
/// `result`. Writes the image of distances to `result` unless that is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_frame(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    frame: *const GeosweepFrame,
    result: *mut GeosweepImage,
) -> GeosweepStatus {
    let append = |surface: &GeosweepSurface, recording: Recording| {
        // SAFETY: the caller's promise.
        let (output, given, frame) = unsafe {
            let output = output_unless_null(result)?;
            let given = reference(frame, "frame")?;
            (output, given, frame_of(surface, given)?)
        };
        let recording = recording.points_at(given.points_offset);
        let recording = match given.profile.is_null() {
            true => recording,
            false => {
                // SAFETY: the caller's promise.
                let profile = unsafe { object(given.profile, "frame->profile") }?;
                if !Arc::ptr_eq(&profile.shared, &surface.shared) {
                    return Err(Failure::argument("frame->profile", "is of another solver"));
                }
                // If the frame is refused, nothing is recorded, not even a query.
                recording.check_frame(&frame)?;
                profile.note_recording();
                recording.profiled(&profile.profile)
            }
        };
        let image = recording.frame(&frame)?;
        if let Some(output) = output {
            output.write(image.into());
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Returns a frame of a surface, after the checks that arguments from C need.
///
/// # Safety
/// The pointers of the frame are null or valid.
unsafe fn frame_of<'a>(
    surface: &GeosweepSurface,
    given: &GeosweepFrame,
) -> Result<embed::Frame<'a>, Failure> {
    // SAFETY: the caller's promise.
    let (plan, sources, limit) = unsafe {
        let plan = plan(given.plan, surface, "frame->plan")?;
        (plan, sources(&given.sources, "frame->sources.sources")?, limit(given)?)
    };
    let points = (given.points != GEOSWEEP_POINTS_UNCHANGED).then_some(given.points as usize);
    Ok(embed::Frame::new(plan, sources, reader(given.reader, "frame->reader.")?)
        .with_before(access(given.before, "frame->before")?)
        .with_points(points)
        .with_slot(given.slot as usize)
        .with_limit(limit)
        .with_unreached(unreached(given.unreached, "frame->unreached")?))
}

/// Records frames of several surfaces so that they run at the same time. Each is recorded as
/// `geosweep_record_frame` does, and the passes of all frames share barriers. `count` surfaces of one size
/// and plan thus need only the barriers of one surface. Frames that are recorded one after another also run
/// one after another. `surfaces` and `frames` have `count` entries, at most 64. All surfaces belong to one
/// solver, none is listed twice, and no frame has a profile. No two frames write the same image of yours.
/// Writes the images of distances to `results`, which has room for `count`, unless that is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_frames(
    surfaces: *const *const GeosweepSurface,
    frames: *const GeosweepFrame,
    count: u32,
    commands: vk::CommandBuffer,
    results: *mut GeosweepImage,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (surfaces, given, results) = unsafe {
            let surfaces = list(surfaces, count, MOST_TOGETHER, "surfaces")?;
            let given = list(frames, count, MOST_TOGETHER, "frames")?;
            (surfaces, given, output_unless_null(results)?)
        };
        if commands.is_null() {
            return Err(Failure::argument("commands", "is the null handle"));
        }
        let mut shared: Option<&Arc<Shared>> = None;
        let mut frames = [const { None }; MOST_TOGETHER];
        for (number, (&surface, given)) in surfaces.iter().zip(given).enumerate() {
            let in_frame = |failure: Failure| failure.of_frame(number);
            // SAFETY: the caller's promise.
            let surface = unsafe { object(surface, "its surface") }.map_err(in_frame)?;
            if !Arc::ptr_eq(shared.get_or_insert(&surface.shared), &surface.shared) {
                let failure =
                    Failure::argument("its surface", "is of another solver than the first");
                return Err(in_frame(failure));
            }
            if !given.profile.is_null() {
                let failure = Failure::argument(
                    "frame->profile",
                    "is not null: frames recorded together are not profiled",
                );
                return Err(in_frame(failure));
            }
            // SAFETY: the caller's promise.
            let frame = unsafe { frame_of(surface, given) }.map_err(in_frame)?;
            let (surface, points_at) = (&surface.surface, given.points_offset);
            frames[number] =
                Some(embed::SurfaceFrame::new(surface, frame).with_points_at(points_at));
        }
        let (Some(shared), [Some(first), ..]) = (shared, frames) else { return Ok(()) };
        let frames: [_; MOST_TOGETHER] =
            std::array::from_fn(|number| frames[number].unwrap_or(first));
        let frames = &frames[..count as usize];
        shared.solver.record_frames(&shared.device, commands, frames)?;
        if let Some(results) = results {
            for (number, of) in frames.iter().enumerate() {
                let image = of.surface.result(of.frame.slot, of.frame.reader.layout)?;
                // SAFETY: the caller promises that there is room for `count` images.
                unsafe { results.write_at(number, image.into()) };
            }
        }
        Ok(())
    })
}

/// Begins a frame that is recorded by several calls. Waits for what you have written, and for earlier
/// recordings of this surface.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_begin(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    before: GeosweepAccess,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        recording.begin(access(before, "before")?);
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Measures the surface's edges from the points with this number. Invalidates the map, so
/// `geosweep_record_solve` comes next. `offset` is as `GeosweepFrame::points_offset`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_measure(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    points: u32,
    offset: u64,
) -> GeosweepStatus {
    let append =
        |_: &_, recording: Recording| Ok(recording.points_at(offset).measure(points as usize)?);
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Computes a new map with the plan's number of iterations. Iterations after convergence are skipped.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_solve(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    sources: *const GeosweepSources,
    plan: *const GeosweepPlan,
) -> GeosweepStatus {
    // SAFETY: the caller's promise.
    unsafe {
        start(surface, commands, (sources, plan), |recording, sources, plan| {
            recording.solve(sources, plan)
        })
    }
}

/// Adds sources to the map. The map must have converged, with the same wavefront.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_add(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    sources: *const GeosweepSources,
    plan: *const GeosweepPlan,
) -> GeosweepStatus {
    // SAFETY: the caller's promise.
    unsafe {
        start(surface, commands, (sources, plan), |recording, sources, plan| {
            recording.add(sources, plan)
        })
    }
}

/// Records a map from new sources.
///
/// # Safety
/// As for [`record`]. The other pointers are null or valid.
unsafe fn start(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    (given, with): (*const GeosweepSources, *const GeosweepPlan),
    start: impl FnOnce(Recording, SourceInput, &embed::Plan) -> Result<(), crate::vulkan::VulkanError>,
) -> GeosweepStatus {
    let append = |surface: &GeosweepSurface, recording: Recording| {
        // SAFETY: the caller's promise.
        let (sources, plan) = unsafe {
            let given = reference(given, "sources")?;
            (sources(given, "sources->sources")?, plan(with, surface, "plan")?)
        };
        Ok(start(recording, sources, plan)?)
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Continues a map that may not have converged, by the plan's number of iterations. Record this in the same
/// command buffer or, for long maps, in later ones, with `begin` before and `outcome` and `result` after it.
/// The plan must be the one with which the map was started.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_resume(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    plan: *const GeosweepPlan,
) -> GeosweepStatus {
    let append = |surface: &GeosweepSurface, recording: Recording| {
        // SAFETY: the caller's promise.
        let plan = unsafe { self::plan(plan, surface, "plan") }?;
        Ok(recording.resume(plan)?)
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Copies the outcome of the iterations to the slot's record, for `geosweep_surface_outcome`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_outcome(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    slot: u32,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| Ok(recording.outcome(slot as usize)?);
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Copies the outcome of the iterations to your own buffer with usage `VK_BUFFER_USAGE_TRANSFER_DST_BIT`. It
/// copies `GEOSWEEP_OUTCOME_BYTES` bytes, which `geosweep_outcome_from_bytes` reads. Shaders find the number
/// of iterations in the third 32-bit number. `after` is the access by which you read the bytes; `offset` is a
/// multiple of 4.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_outcome_to(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    buffer: vk::Buffer,
    offset: u64,
    after: GeosweepAccess,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        Ok(recording.outcome_to(buffer, offset, access(after, "after")?)?)
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Reads the record of `GEOSWEEP_OUTCOME_BYTES` bytes that `geosweep_record_outcome_to` has copied. It is an
/// error if the bytes belong to another surface, or if the surface's preparation has not run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_outcome_from_bytes(
    surface: *const GeosweepSurface,
    bytes: *const u8,
    outcome: *mut GeosweepOutcome,
) -> GeosweepStatus {
    guard(|| {
        const BYTES: usize = embed::Outcome::BYTES;
        // SAFETY: the caller's promise.
        let (surface, bytes, output) = unsafe {
            let output = Output::new(outcome, "outcome")?;
            let bytes = reference(bytes.cast::<[u8; BYTES]>(), "bytes")?;
            (object(surface, "surface")?, bytes, output)
        };
        output.write(surface.surface.outcome_from(bytes)?.into());
        Ok(())
    })
}

/// Writes the map to the slot's image of distances, for a reader. Waits for the reads by `reader` in earlier
/// commands; the reads in later commands wait for this. Writes the image to `result` unless that is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_result(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    slot: u32,
    reader: GeosweepReader,
    unreached: f32,
    result: *mut GeosweepImage,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        // SAFETY: the caller's promise.
        let output = unsafe { output_unless_null(result) }?;
        let reader = self::reader(reader, "reader.")?;
        let unreached = self::unreached(unreached, "unreached")?;
        let image = recording.result(slot as usize, reader, unreached)?;
        if let Some(output) = output {
            output.write(image.into());
        }
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Looks up distances by the surface's lookup with this number. Between grid points, distances are
/// interpolated bilinearly. Where no front arrives and off the grid, they are `unreached`. Waits for your
/// writes by the access `before`; `after` is the access by which you read the distances.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_lookup(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    number: u32,
    unreached: f32,
    before: GeosweepAccess,
    after: GeosweepAccess,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        let unreached = self::unreached(unreached, "unreached")?;
        let (before, after) = (access(before, "before")?, access(after, "after")?);
        Ok(recording.lookup(number as usize, unreached, before, after)?)
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Ends a frame, so that commands in the stages of `after` may read the packed distances, or overwrite points
/// and sources.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_end(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    after: GeosweepAccess,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        recording.end(access(after, "after")?);
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Returns the output of a call, or `None` if the pointer is null.
///
/// # Safety
/// As for [`Output::new`].
pub(super) unsafe fn output_unless_null<T>(pointer: *mut T) -> Result<Option<Output<T>>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    unsafe { Output::new(pointer, "result") }.map(Some)
}
