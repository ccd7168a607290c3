//! Directions of the ways back, in an image for shaders of the same frame.

use std::sync::Arc;

use ash::vk;

use super::arguments::reference;
use super::frame::{GeosweepAccess, GeosweepReader, GeosweepSources, access, reader, sources};
use super::objects::object;
use super::record::{output_unless_null, record};
use super::shared::Shared;
use super::solver::GeosweepSolver;
use super::status::{Failure, GeosweepStatus};
use super::surface::{GeosweepImage, GeosweepSurface};
use super::surface_info::GeosweepHostImage;
use super::way_image::{self, ways};
use crate::vulkan::embed::{self, Recording};

/// Image of the directions in which ways lead back to the sources, and the passes that find them. A texel of
/// `VK_FORMAT_R16G16_SFLOAT` is a unit vector in columns and rows. It is 0, 0 at sources and at points that
/// are not reached. Frames in flight on one queue share the image.
pub struct GeosweepDirections {
    pub(super) shared: Arc<Shared>,
    directions: embed::Directions,
}

/// Sources to which ways lead back, and the commands that read the image.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepDirectionFrame {
    /// Access that has written the sources.
    pub before: GeosweepAccess,
    /// All sources of the map, including those that were added to the map.
    pub sources: GeosweepSources,
    /// Access that reads the image, in this frame and in the previous one, and its layout.
    pub reader: GeosweepReader,
}

ways!(GeosweepDirections, directions, directions_into);

/// Computes the bytes of device memory that directions will take, before they are created: 12 (8 with an
/// image of yours) per grid point.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_directions_bytes_for(
    solver: *const GeosweepSolver,
    rows: u32,
    cols: u32,
    bytes: *mut u64,
) -> GeosweepStatus {
    // SAFETY: the caller's promise.
    unsafe {
        way_image::bytes_for(solver, [rows, cols], bytes, embed::Solver::bytes_for_directions)
    }
}

/// Creates directions of a surface, for maps with any wavefront. Allocates device memory and compiles passes.
/// Without an `image` of yours, an image is allocated too; it has the format `VK_FORMAT_R16G16_SFLOAT`. Your
/// image has at least cols x rows texels of that format, and its usage contains
/// `VK_IMAGE_USAGE_TRANSFER_DST_BIT`. `geosweep_directions_destroy` destroys the directions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_directions_create(
    surface: *const GeosweepSurface,
    image: *const GeosweepHostImage,
    directions: *mut *mut GeosweepDirections,
) -> GeosweepStatus {
    // SAFETY: the caller's promise.
    unsafe { way_image::create(surface, image, directions) }
}

/// Makes directions write to another image of yours in later recordings. The directions must have been
/// created with an image of yours. Recordings in flight continue to use the previous image.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_directions_set_image(
    directions: *mut GeosweepDirections,
    image: *const GeosweepHostImage,
) -> GeosweepStatus {
    // SAFETY: the caller's promise.
    unsafe { way_image::set_image(directions, image) }
}

/// Returns the bytes of device memory that directions take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_directions_bytes(
    directions: *const GeosweepDirections,
    bytes: *mut u64,
) -> GeosweepStatus {
    // SAFETY: the caller's promise.
    unsafe { way_image::bytes(directions, bytes) }
}

/// Returns the image, also before any recording writes it. `layout` is the layout of the reader for which the
/// image is recorded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_directions_image(
    directions: *const GeosweepDirections,
    layout: vk::ImageLayout,
    image: *mut GeosweepImage,
) -> GeosweepStatus {
    // SAFETY: the caller's promise.
    unsafe { way_image::image(directions, layout, image) }
}

/// Finds the direction in which the way back leaves each grid point. Call this after the map was recorded, in
/// the same command buffer or after `geosweep_record_begin`. Writes the image to `result` unless that is
/// null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_directions(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    directions: *const GeosweepDirections,
    frame: *const GeosweepDirectionFrame,
    result: *mut GeosweepImage,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        // SAFETY: the caller's promise.
        let (output, of, given, sources) = unsafe {
            let output = output_unless_null(result)?;
            let of = object(directions, "directions")?;
            let given = reference(frame, "frame")?;
            (output, of, given, sources(&given.sources, "frame->sources.sources")?)
        };
        let frame = embed::DirectionFrame::new(sources, reader(given.reader, "frame->reader")?)
            .with_before(access(given.before, "frame->before")?);
        let image = recording.directions(&of.directions, &frame)?;
        if let Some(output) = output {
            output.write(image.into());
        }
        Ok::<_, Failure>(())
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Makes directions read the surface's sources that `geosweep_surface_set_sources` has set since the
/// directions were created. Recordings in flight continue to read the previous sources.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_directions_rebind(
    directions: *mut GeosweepDirections,
    surface: *const GeosweepSurface,
) -> GeosweepStatus {
    // SAFETY: the caller's promise.
    unsafe { way_image::rebind(directions, surface) }
}

/// Destroys directions, before or after the surface. No submitted work may still use the directions; a solver
/// with checks verifies that. Null is allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_directions_destroy(
    directions: *mut GeosweepDirections,
) -> GeosweepStatus {
    // SAFETY: the caller's promise.
    unsafe { way_image::destroy(directions) }
}
