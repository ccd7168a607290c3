//! Records into the host's command buffer.

use std::ptr::null_mut;
use std::sync::Arc;

use ash::vk;
use ash::vk::Handle;

use super::arguments::{Output, list, reference};
use super::frame::{
    GEOSWEEP_POINTS_UNCHANGED, GeosweepAccess, GeosweepFrame, GeosweepReader, GeosweepSources,
    access, limit, reader, sources, unreached,
};
use super::objects::{object, object_named};
use super::plan::{GeosweepPlan, plan};
use super::shared::Shared;
use super::status::{Failure, calls};
use super::surface::{GeosweepImage, GeosweepOutcome, GeosweepSurface};
use geosweep::vulkan::embed::{self, MOST_TOGETHER, Recording};

/// Size in bytes of the record that `geosweep_record_outcome_to` copies.
pub const GEOSWEEP_OUTCOME_BYTES: u32 = 80;
const _: () = assert!(GEOSWEEP_OUTCOME_BYTES as usize == embed::Outcome::BYTES);

/// Appends commands to a recording for a surface. Writes what `append` returns to `result` unless that is null.
///
/// # Safety
/// `surface` is null or a surface's pointer. `commands` is null or a command buffer that is being recorded. `result`
/// is null, badly aligned, or has room for a value.
pub(super) unsafe fn record<R, C: From<R>>(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    result: *mut C,
    append: impl FnOnce(&GeosweepSurface, Recording) -> Result<R, Failure>,
) -> Result<(), Failure> {
    // SAFETY: required.
    let (surface, output) = unsafe { (object(surface)?, output_unless_null(result)?) };
    if commands.is_null() {
        return Err(Failure::argument("commands", "is the null handle"));
    }
    let GeosweepSurface { shared, surface: of, .. } = surface;
    let recorded = append(surface, shared.solver.record(&shared.device, commands, of))?;
    if let Some(output) = output {
        output.write(recorded.into());
    }
    Ok(())
}

/// Appends commands without a result to a recording for a surface.
///
/// # Safety
/// As for [`record`].
unsafe fn append(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    append: impl FnOnce(&GeosweepSurface, Recording) -> Result<(), Failure>,
) -> Result<(), Failure> {
    // SAFETY: required.
    unsafe { record(surface, commands, null_mut::<()>(), append) }
}

/// Returns the output of a call, or `None` if the pointer is null.
///
/// # Safety
/// As for [`Output::new`].
unsafe fn output_unless_null<T>(pointer: *mut T) -> Result<Option<Output<T>>, Failure> {
    // SAFETY: required.
    if pointer.is_null() { Ok(None) } else { unsafe { Output::new(pointer, "result") }.map(Some) }
}

calls! {
    /// Prepares a new surface. Record this once, before anything else of that surface.
    fn geosweep_record_prepare(surface: *const GeosweepSurface, commands: vk::CommandBuffer) {
        append(surface, commands, |_, recording| {
            recording.prepare();
            Ok(())
        })?;
    }

    /// Records all parts of a usual frame: `begin`, `measure` if there are new points, `solve`, `outcome` and
    /// `result`. Writes the image of distances to `result` unless that is null.
    fn geosweep_record_frame(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        frame: *const GeosweepFrame,
        result: *mut GeosweepImage,
    ) {
        record(surface, commands, result, |surface, recording| {
            let given = reference(frame, "frame")?;
            let frame = frame_of(surface, given)?;
            let recording = recording.points_at(given.points_offset);
            if given.profile.is_null() {
                return Ok(recording.frame(&frame)?);
            }
            let profile = object_named(given.profile, "frame->profile")?;
            if !Arc::ptr_eq(&profile.shared, &surface.shared) {
                return Err(Failure::argument("frame->profile", "is of another solver"));
            }
            profile.check_room(surface, frame.plan)?;
            // If the frame is refused, nothing is recorded, not even a query.
            recording.check_frame(&frame)?;
            let recording = recording.profiled(&profile.profile)?;
            profile.note_recording();
            Ok(recording.frame(&frame)?)
        })?;
    }

    /// Records frames of several surfaces so that they run at the same time. Each is recorded as
    /// `geosweep_record_frame` does, and the passes of all frames share barriers. `count` surfaces of one size
    /// and plan thus need only the barriers of one surface. Frames that are recorded one after another also run
    /// one after another. `surfaces` and `frames` have `count` entries, at most 64. All surfaces belong to one
    /// solver, none is listed twice, and no frame has a profile. No two frames write the same image of yours.
    /// Writes the images of distances to `results`, which has room for `count`, unless that is null.
    fn geosweep_record_frames(
        surfaces: *const *const GeosweepSurface,
        frames: *const GeosweepFrame,
        count: u32,
        commands: vk::CommandBuffer,
        results: *mut GeosweepImage,
    ) {
        let surfaces = list(surfaces, count, MOST_TOGETHER, "surfaces")?;
        let given = list(frames, count, MOST_TOGETHER, "frames")?;
        let results = output_unless_null(results)?;
        if commands.is_null() {
            return Err(Failure::argument("commands", "is the null handle"));
        }
        let mut shared: Option<&Arc<Shared>> = None;
        let mut frames = [const { None }; MOST_TOGETHER];
        for (number, (&surface, given)) in surfaces.iter().zip(given).enumerate() {
            let frame = frame_together(surface, given, &mut shared);
            frames[number] = Some(frame.map_err(|failure| failure.of_frame(number))?);
        }
        let (Some(shared), [Some(first), ..]) = (shared, frames) else { return Ok(()) };
        let frames: [_; MOST_TOGETHER] = std::array::from_fn(|number| frames[number].unwrap_or(first));
        let frames = &frames[..count as usize];
        shared.solver.record_frames(&shared.device, commands, frames)?;
        if let Some(results) = results {
            for (number, of) in frames.iter().enumerate() {
                let image = of.surface.result(of.frame.slot, of.frame.reader.layout)?;
                results.write_at(number, image.into());
            }
        }
    }

    /// Begins a frame that is recorded by several calls. Waits for what you have written, and for earlier
    /// recordings of this surface.
    fn geosweep_record_begin(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        before: GeosweepAccess,
    ) {
        append(surface, commands, |_, recording| {
            recording.begin(access(before, "before")?);
            Ok(())
        })?;
    }

    /// Measures the surface's edges from the points with this number. Invalidates the map, so
    /// `geosweep_record_solve` comes next. `offset` is as `GeosweepFrame::points_offset`.
    fn geosweep_record_measure(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        points: u32,
        offset: u64,
    ) {
        append(surface, commands, |_, recording| {
            Ok(recording.points_at(offset).measure(points as usize)?)
        })?;
    }

    /// Computes a new map with the plan's number of iterations. Iterations after convergence are skipped.
    fn geosweep_record_solve(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        sources: *const GeosweepSources,
        plan: *const GeosweepPlan,
    ) {
        append(surface, commands, |surface, recording| {
            let given = self::sources(reference(sources, "sources")?, "sources->sources")?;
            Ok(recording.solve(given, self::plan(plan, surface, "plan")?)?)
        })?;
    }

    /// Adds sources to the map. The map must have converged, with the same wavefront.
    fn geosweep_record_add(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        sources: *const GeosweepSources,
        plan: *const GeosweepPlan,
    ) {
        append(surface, commands, |surface, recording| {
            let given = self::sources(reference(sources, "sources")?, "sources->sources")?;
            Ok(recording.add(given, self::plan(plan, surface, "plan")?)?)
        })?;
    }

    /// Continues a map that may not have converged, by the plan's number of iterations. Record this in the same
    /// command buffer or, for long maps, in later ones, with `begin` before and `outcome` and `result` after it.
    /// The plan must be the one with which the map was started.
    fn geosweep_record_resume(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        plan: *const GeosweepPlan,
    ) {
        append(surface, commands, |surface, recording| {
            Ok(recording.resume(self::plan(plan, surface, "plan")?)?)
        })?;
    }

    /// Copies the outcome of the iterations to the slot's record, for `geosweep_surface_outcome`.
    fn geosweep_record_outcome(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        slot: u32,
    ) {
        append(surface, commands, |_, recording| Ok(recording.outcome(slot as usize)?))?;
    }

    /// Copies the outcome of the iterations to your own buffer with usage `VK_BUFFER_USAGE_TRANSFER_DST_BIT`. It
    /// copies `GEOSWEEP_OUTCOME_BYTES` bytes, which `geosweep_outcome_from_bytes` reads. Shaders find the number
    /// of iterations in the third 32-bit number. `after` is the access by which you read the bytes; `offset` is a
    /// multiple of 4.
    fn geosweep_record_outcome_to(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        buffer: vk::Buffer,
        offset: u64,
        after: GeosweepAccess,
    ) {
        append(surface, commands, |_, recording| {
            Ok(recording.outcome_to(buffer, offset, access(after, "after")?)?)
        })?;
    }

    /// Reads the record of `GEOSWEEP_OUTCOME_BYTES` bytes that `geosweep_record_outcome_to` has copied. It is an
    /// error if the bytes belong to another surface, or if the surface's preparation has not run.
    fn geosweep_outcome_from_bytes(
        surface: *const GeosweepSurface,
        bytes: *const u8,
        outcome: *mut GeosweepOutcome,
    ) {
        let bytes = reference(bytes.cast::<[u8; embed::Outcome::BYTES]>(), "bytes")?;
        let (surface, output) = (object(surface)?, Output::new(outcome, "outcome")?);
        output.write(surface.surface.outcome_from(bytes)?.into());
    }

    /// Writes the map to the slot's image of distances, for a reader. Waits for the reads by `reader` in earlier
    /// commands; the reads in later commands wait for this. Writes the image to `result` unless that is null.
    fn geosweep_record_result(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        slot: u32,
        reader: GeosweepReader,
        unreached: f32,
        result: *mut GeosweepImage,
    ) {
        record(surface, commands, result, |_, recording| {
            let reader = self::reader(reader, "reader.")?;
            let unreached = self::unreached(unreached, "unreached")?;
            Ok(recording.result(slot as usize, reader, unreached)?)
        })?;
    }

    /// Looks up distances by the surface's lookup with this number. Between grid points, distances are
    /// interpolated bilinearly. Where no front arrives and off the grid, they are `unreached`. Waits for your
    /// writes by the access `before`; `after` is the access by which you read the distances.
    fn geosweep_record_lookup(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        number: u32,
        unreached: f32,
        before: GeosweepAccess,
        after: GeosweepAccess,
    ) {
        append(surface, commands, |_, recording| {
            let unreached = self::unreached(unreached, "unreached")?;
            let (before, after) = (access(before, "before")?, access(after, "after")?);
            Ok(recording.lookup(number as usize, unreached, before, after)?)
        })?;
    }

    /// Ends a frame, so that commands in the stages of `after` may read the packed distances, or overwrite points
    /// and sources.
    fn geosweep_record_end(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        after: GeosweepAccess,
    ) {
        append(surface, commands, |_, recording| {
            recording.end(access(after, "after")?);
            Ok(())
        })?;
    }
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

/// Returns a frame that is recorded together with others, which have the same solver as the first.
///
/// # Safety
/// The pointers are null or valid.
unsafe fn frame_together<'a>(
    surface: *const GeosweepSurface,
    given: &GeosweepFrame,
    first: &mut Option<&'a Arc<Shared>>,
) -> Result<embed::SurfaceFrame<'a>, Failure> {
    // SAFETY: required.
    let surface: &GeosweepSurface = unsafe { object_named(surface, "its surface") }?;
    if !Arc::ptr_eq(first.get_or_insert(&surface.shared), &surface.shared) {
        return Err(Failure::argument("its surface", "is of another solver than the first"));
    }
    if !given.profile.is_null() {
        let reason = "is not null: frames recorded together are not profiled";
        return Err(Failure::argument("frame->profile", reason));
    }
    // SAFETY: required.
    let frame = unsafe { frame_of(surface, given) }?;
    Ok(embed::SurfaceFrame::new(&surface.surface, frame).with_points_at(given.points_offset))
}
