//! Contours for drawing in the same frame.

use ash::vk;

use super::arguments::{chart, list, reference, write};
use super::curves::GeosweepCurves;
use super::frame::{GeosweepAccess, access};
use super::objects::{kind_of_object, object};
use super::outputs;
use super::record::record;
use super::shared::Made;
use super::solver::GeosweepSolver;
use super::status::{Failure, calls};
use super::surface::GeosweepSurface;
use geosweep::vulkan::embed::{self, LevelInput};

/// Largest number of levels in a recording.
const MOST_LEVELS: usize = 1024;

/// Buffer for the contours of a surface, and the passes that find them. Frames in flight on one queue share
/// one such object. If contours are read on other queues, create one object for each of these queues.
pub struct GeosweepContours(());

kind_of_object! { GeosweepContours, contours: Made<embed::Contours> }

/// Levels of the contours that a recording finds, and the commands that read them. The levels are a list or,
/// if `levels` is null, the multiples of a step.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepContourFrame {
    /// Levels in ascending order, or null.
    pub levels: *const f32,
    /// Number of levels, at most 1024. Levels beyond the map's largest distance cost next to nothing.
    pub level_count: u32,
    /// Distance between levels if there is no list. It is positive, and it is the first level too.
    pub step: f32,
    /// Smallest time of the map's sources, usually 0.
    pub start: f32,
    /// Number of the surface's points to which contours are lifted.
    pub points: u32,
    /// Offset in bytes, added to the offset of these points in the surface's buffer, as
    /// `GeosweepFrame::points_offset`.
    pub points_offset: u64,
    /// Stages and accesses that read the contours, in this frame and in the frame before. Usually these are
    /// the stages `VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT` and `VK_PIPELINE_STAGE_VERTEX_INPUT_BIT` with
    /// `VK_ACCESS_INDIRECT_COMMAND_READ_BIT` and `VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT`.
    pub reader: GeosweepAccess,
}

calls! {
    /// Computes the bytes of device memory that contours will take, before they are created: 24 per vertex and
    /// 260 per row of the grid.
    fn geosweep_contours_bytes_for(
        solver: *const GeosweepSolver,
        rows: u32,
        cols: u32,
        vertices: u32,
        bytes: *mut u64,
    ) {
        outputs::bytes_for(solver, bytes, |solver, device| {
            Ok(solver.bytes_for_contours(device, chart(rows, cols)?, vertices)?)
        })?;
    }

    /// Creates contours of a surface with room for `vertices` vertices. Each piece of a contour between grid
    /// lines has two vertices. Allocates device memory and compiles passes. `geosweep_contours_destroy` destroys
    /// the contours.
    fn geosweep_contours_create(
        surface: *const GeosweepSurface,
        vertices: u32,
        contours: *mut *mut GeosweepContours,
    ) {
        outputs::create(surface, contours, |solver, device, memory, surface| {
            solver.contours(device, memory, surface, vertices)
        })?;
    }

    /// Computes the bytes that your own buffer for contours must have, if you provide one.
    fn geosweep_contours_buffer_bytes(vertices: u32, bytes: *mut u64) {
        write(bytes, "bytes", embed::Contours::buffer_bytes(vertices))?;
    }

    /// Creates contours as `geosweep_contours_create` does, in your own buffer from its first byte. The buffer's
    /// usage contains `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT` and what its readers need, device addresses included.
    /// The buffer remains yours. While no contours are in use, a render graph may use its memory for other
    /// resources.
    fn geosweep_contours_create_into(
        surface: *const GeosweepSurface,
        vertices: u32,
        buffer: vk::Buffer,
        contours: *mut *mut GeosweepContours,
    ) {
        outputs::create(surface, contours, |solver, device, memory, surface| {
            solver.contours_into(device, memory, surface, vertices, buffer)
        })?;
    }

    /// Makes contours write to another buffer of yours in later recordings. The contours must have been created
    /// with your own buffer. Recordings in flight continue to use the previous buffer.
    fn geosweep_contours_set_buffer(
        contours: *mut GeosweepContours,
        surface: *const GeosweepSurface,
        buffer: vk::Buffer,
    ) {
        outputs::set_buffer(contours, surface, buffer)?;
    }

    /// Returns the bytes of device memory that contours take.
    fn geosweep_contours_bytes(contours: *const GeosweepContours, bytes: *mut u64) {
        outputs::bytes(contours, bytes)?;
    }

    /// Returns where contours are stored, also before any are recorded. They are one curve, drawn as a list of
    /// lines.
    fn geosweep_contours_curves(contours: *const GeosweepContours, curves: *mut GeosweepCurves) {
        write(curves, "curves", object(contours)?.of.curves().into())?;
    }

    /// Records the search for the contours of the map. Lifts them to the surface and stores them for you to draw.
    /// Equal maps give equal contours in equal order. Call this after the map was recorded, in the same command
    /// buffer or after `geosweep_record_begin`. If there is not enough room for all vertices, the southern
    /// contours are left out, and the record has the number of vertices that all contours need. Writes where
    /// contours are stored to `result` unless that is null.
    fn geosweep_record_contours(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        contours: *const GeosweepContours,
        frame: *const GeosweepContourFrame,
        result: *mut GeosweepCurves,
    ) {
        record(surface, commands, result, |_, recording| {
            let (contours, given) = (object(contours)?, reference(frame, "frame")?);
            let reader = access(given.reader, "frame->reader")?;
            let frame = embed::ContourFrame::new(levels(given)?, reader)
                .with_start(given.start)
                .with_points(given.points as usize);
            Ok(recording.points_at(given.points_offset).contours(&contours.of, &frame)?)
        })?;
    }

    /// Makes contours read the surface's points that `geosweep_surface_set_points` has set since the contours
    /// were created. Recordings in flight continue to read the previous points.
    fn geosweep_contours_rebind(
        contours: *mut GeosweepContours,
        surface: *const GeosweepSurface,
    ) {
        outputs::rebind(contours, surface)?;
    }

    /// Destroys contours, before or after their surface. No submitted work may still use them; a solver with
    /// checks verifies that. Null is allowed.
    fn geosweep_contours_destroy(contours: *mut GeosweepContours) {
        outputs::destroy(contours)?;
    }
}

/// Returns the levels of a frame.
///
/// # Safety
/// The list of levels has `level_count` entries.
unsafe fn levels<'a>(given: &GeosweepContourFrame) -> Result<LevelInput<'a>, Failure> {
    let GeosweepContourFrame { levels, level_count, step, .. } = *given;
    if levels.is_null() && level_count > 0 {
        return Ok(LevelInput::Spacing { step, count: level_count as usize });
    }
    if step != 0.0 {
        let reason = format!("is {step}, but must be 0 with a list of levels or without levels");
        return Err(Failure::argument("frame->step", reason));
    }
    // SAFETY: the caller's promise.
    unsafe { list(levels, level_count, MOST_LEVELS, "frame->levels") }.map(LevelInput::List)
}
