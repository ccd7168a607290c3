//! Contours for drawing in the same frame.

use std::sync::Arc;

use ash::vk;

use super::arguments::{Output, list, reference};
use super::curves::GeosweepCurves;
use super::frame::{GeosweepAccess, access};
use super::objects::{exclusive, hand_out, land, object, take};
use super::plan::chart;
use super::record::{output_unless_null, record};
use super::solver::{GeosweepSolver, Shared};
use super::status::{Failure, GeosweepStatus, guard};
use super::surface::GeosweepSurface;
use crate::vulkan::embed::{self, LevelInput, Recording};

/// Levels of a recording, at most.
const MOST_LEVELS: usize = 1024;

/// Room for the contours of a surface, and the passes that find them. Frames in flight on one queue
/// share it; with readers on another queue make one for each.
pub struct GeosweepContours {
    pub(super) shared: Arc<Shared>,
    contours: embed::Contours,
}

/// Which contours are wanted, and who draws them. Levels are a list, or, if that is null, multiples of
/// a step.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepContourFrame {
    /// The list, ascending, or null.
    pub levels: *const f32,
    /// How many levels: at most 1024. Those beyond the map's largest distance cost next to nothing.
    pub level_count: u32,
    /// From level to level, without a list; positive, and the first level.
    pub step: f32,
    /// The smallest time of the map's sources, 0 as a rule.
    pub start: f32,
    /// The number of the surface's points to which contours are lifted.
    pub points: u32,
    /// Bytes beyond where the surface has these points, as `GeosweepFrame::points_offset`.
    pub points_offset: u64,
    /// How you read the contours, this frame and the frame before: the stages
    /// `VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT` and `VK_PIPELINE_STAGE_VERTEX_INPUT_BIT` with
    /// `VK_ACCESS_INDIRECT_COMMAND_READ_BIT` and `VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT` as a rule.
    pub reader: GeosweepAccess,
}

/// Says how many bytes of device memory contours will take, before they are made: 24 a vertex, and
/// 260 a row of the grid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_contours_bytes_for(
    solver: *const GeosweepSolver,
    rows: u32,
    cols: u32,
    vertices: u32,
    bytes: *mut u64,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (solver, output) = unsafe { (object(solver, "solver")?, Output::new(bytes, "bytes")?) };
        let Shared { solver, device, .. } = &**solver.shared();
        output.write(solver.bytes_for_contours(device, chart(rows, cols)?, vertices)?);
        Ok(())
    })
}

/// Makes room for contours of a surface, of so many vertices, two for each piece between grid lines;
/// `geosweep_contours_destroy` destroys it. Takes device memory and compiles passes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_contours_create(
    surface: *const GeosweepSurface,
    vertices: u32,
    contours: *mut *mut GeosweepContours,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (surface, output) =
            unsafe { (object(surface, "surface")?, Output::new(contours, "contours")?) };
        let GeosweepSurface { shared, surface, .. } = surface;
        let mut allocator = shared.allocator();
        let contours = shared.solver.contours(&shared.device, &mut allocator, surface, vertices)?;
        hand_out(output, GeosweepContours { shared: Arc::clone(shared), contours });
        Ok(())
    })
}

/// Says how many bytes a buffer of yours has for contours, in place of one of their own.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_contours_buffer_bytes(
    vertices: u32,
    bytes: *mut u64,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let output = unsafe { Output::new(bytes, "bytes") }?;
        output.write(embed::Contours::buffer_bytes(vertices));
        Ok(())
    })
}

/// Makes contours as `geosweep_contours_create` does, which go to a buffer of yours, from its first byte: with usage
/// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT` and what
/// its readers ask for, device addresses too. It stays yours, and a render graph may give its memory to others meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_contours_create_into(
    surface: *const GeosweepSurface,
    vertices: u32,
    buffer: vk::Buffer,
    contours: *mut *mut GeosweepContours,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (surface, output) =
            unsafe { (object(surface, "surface")?, Output::new(contours, "contours")?) };
        let GeosweepSurface { shared, surface, .. } = surface;
        let mut allocator = shared.allocator();
        let (solver, device) = (&shared.solver, &shared.device);
        let contours = solver.contours_into(device, &mut allocator, surface, vertices, buffer)?;
        hand_out(output, GeosweepContours { shared: Arc::clone(shared), contours });
        Ok(())
    })
}

/// Has contours from now on go to another buffer of yours, if they were made with one. Recordings in flight go on with the
/// one before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_contours_set_buffer(
    contours: *mut GeosweepContours,
    surface: *const GeosweepSurface,
    buffer: vk::Buffer,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, surface) =
            unsafe { (exclusive(contours, "contours")?, object(surface, "surface")?) };
        let Shared { device, solver, .. } = &*surface.shared;
        Ok(of.contours.set_buffer(device, solver, &surface.surface, buffer)?)
    })
}

/// Says how many bytes of device memory contours take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_contours_bytes(
    contours: *const GeosweepContours,
    bytes: *mut u64,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (contours, output) =
            unsafe { (object(contours, "contours")?, Output::new(bytes, "bytes")?) };
        output.write(contours.contours.bytes());
        Ok(())
    })
}

/// Says where contours are, also before any are recorded: one curve, drawn as a list of lines.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_contours_curves(
    contours: *const GeosweepContours,
    curves: *mut GeosweepCurves,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (contours, output) =
            unsafe { (object(contours, "contours")?, Output::new(curves, "curves")?) };
        output.write(contours.contours.curves().into());
        Ok(())
    })
}

/// Finds the contours of the map, lifts them to the surface and leaves them for you to draw, the same
/// in the same order whenever the map is the same. To be recorded after the map, in the same command
/// buffer or after `geosweep_record_begin`. If there are more than there is room for, the southern
/// ones are left out, and their record says how many vertices there are. Gives where they are to
/// `result` unless that is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_contours(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    contours: *const GeosweepContours,
    frame: *const GeosweepContourFrame,
    result: *mut GeosweepCurves,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        // SAFETY: the caller's promise.
        let (output, contours, given, levels) = unsafe {
            let output = output_unless_null(result)?;
            let contours = object(contours, "contours")?;
            let given = reference(frame, "frame")?;
            (output, contours, given, levels(given)?)
        };
        let curves = recording.points_at(given.points_offset).contours(
            &contours.contours,
            &embed::ContourFrame {
                levels,
                start: given.start,
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
/// The list is as long as is said.
unsafe fn levels<'a>(given: &GeosweepContourFrame) -> Result<LevelInput<'a>, Failure> {
    let GeosweepContourFrame { levels, level_count, step, .. } = *given;
    if levels.is_null() && level_count > 0 {
        return Ok(LevelInput::Spacing { step, count: level_count as usize });
    }
    if step != 0.0 {
        let reason = format!("is {step}, and there is a list of levels or none are wanted");
        return Err(Failure::argument("frame->step", reason));
    }
    // SAFETY: the caller's promise.
    unsafe { list(levels, level_count, MOST_LEVELS, "frame->levels") }.map(LevelInput::List)
}

/// Has contours read the surface's points that were replaced since they were made, by
/// `geosweep_surface_set_points`. Recordings in flight go on with those before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_contours_rebind(
    contours: *mut GeosweepContours,
    surface: *const GeosweepSurface,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, surface) =
            unsafe { (exclusive(contours, "contours")?, object(surface, "surface")?) };
        let Shared { device, solver, .. } = &*surface.shared;
        Ok(of.contours.rebind(device, solver, &surface.surface)?)
    })
}

/// Destroys contours, before or after their surface. No submitted work may still use them, which a
/// solver with checks looks at. Null is
/// fine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_contours_destroy(
    contours: *mut GeosweepContours,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let Some(_) = (unsafe { land(contours, "contours", |of| of.contours.is_in_flight()) })?
        else {
            return Ok(());
        };
        // SAFETY: the caller's promise.
        let Some(contours) = unsafe { take(contours, "contours") }? else { return Ok(()) };
        let GeosweepContours { shared, mut contours } = contours;
        contours.destroy(&shared.device, &mut shared.allocator());
        Ok(())
    })
}
