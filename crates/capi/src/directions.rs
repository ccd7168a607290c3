//! Directions of the ways back, in an image for shaders of the same frame.

use ash::vk;

use super::arguments::{chart, reference};
use super::frame::{GeosweepAccess, GeosweepReader, GeosweepSources, access, reader, sources};
use super::objects::{kind_of_object, object};
use super::outputs;
use super::record::record;
use super::shared::Made;
use super::solver::GeosweepSolver;
use super::status::calls;
use super::surface::{GeosweepImage, GeosweepSurface};
use super::surface_info::GeosweepHostImage;
use geosweep::vulkan::embed;

/// Image of the directions in which ways lead back to the sources, and the passes that find them. A texel of
/// `VK_FORMAT_R16G16_SFLOAT` is a unit vector in columns and rows. It is 0, 0 at sources and at points that
/// are not reached. Frames in flight on one queue share the image.
pub struct GeosweepDirections(());

kind_of_object! { GeosweepDirections, directions: Made<embed::Directions> }

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

calls! {
    /// Computes the bytes of device memory that directions will take, before they are created: 12 (8 with an
    /// image of yours) per grid point.
    fn geosweep_directions_bytes_for(
        solver: *const GeosweepSolver,
        rows: u32,
        cols: u32,
        bytes: *mut u64,
    ) {
        outputs::bytes_for(solver, bytes, |solver, device| {
            Ok(solver.bytes_for_directions(device, chart(rows, cols)?)?)
        })?;
    }

    /// Creates directions of a surface, for maps with any wavefront. Allocates device memory and compiles passes.
    /// Without an `image` of yours, an image is allocated too; it has the format `VK_FORMAT_R16G16_SFLOAT`. Your
    /// image has at least cols x rows texels of that format, and its usage contains
    /// `VK_IMAGE_USAGE_TRANSFER_DST_BIT`. `geosweep_directions_destroy` destroys the directions.
    fn geosweep_directions_create(
        surface: *const GeosweepSurface,
        image: *const GeosweepHostImage,
        directions: *mut *mut GeosweepDirections,
    ) {
        let image = outputs::hosts(image)?;
        outputs::create(surface, directions, |solver, device, memory, surface| match image {
            None => solver.directions(device, memory, surface),
            Some(image) => solver.directions_into(device, memory, surface, image),
        })?;
    }

    /// Makes directions write to another image of yours in later recordings. The directions must have been
    /// created with an image of yours. Recordings in flight continue to use the previous image.
    fn geosweep_directions_set_image(
        directions: *mut GeosweepDirections,
        image: *const GeosweepHostImage,
    ) {
        outputs::set_image(directions, image)?;
    }

    /// Returns the bytes of device memory that directions take.
    fn geosweep_directions_bytes(directions: *const GeosweepDirections, bytes: *mut u64) {
        outputs::bytes(directions, bytes)?;
    }

    /// Returns the image, also before any recording writes it. `layout` is the layout of the reader for which the
    /// image is recorded.
    fn geosweep_directions_image(
        directions: *const GeosweepDirections,
        layout: vk::ImageLayout,
        image: *mut GeosweepImage,
    ) {
        outputs::image(directions, layout, image)?;
    }

    /// Finds the direction in which the way back leaves each grid point. Call this after the map was recorded, in
    /// the same command buffer or after `geosweep_record_begin`. Writes the image to `result` unless that is
    /// null.
    fn geosweep_record_directions(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        directions: *const GeosweepDirections,
        frame: *const GeosweepDirectionFrame,
        result: *mut GeosweepImage,
    ) {
        record(surface, commands, result, |_, recording| {
            let (directions, given) = (object(directions)?, reference(frame, "frame")?);
            let sources = sources(&given.sources, "frame->sources.sources")?;
            let frame = embed::DirectionFrame::new(sources, reader(given.reader, "frame->reader")?)
                .with_before(access(given.before, "frame->before")?);
            Ok(recording.directions(&directions.of, &frame)?)
        })?;
    }

    /// Makes directions read the surface's sources that `geosweep_surface_set_sources` has set since the
    /// directions were created. Recordings in flight continue to read the previous sources.
    fn geosweep_directions_rebind(directions: *mut GeosweepDirections, surface: *const GeosweepSurface) {
        outputs::rebind(directions, surface)?;
    }

    /// Destroys directions, before or after the surface. No submitted work may still use the directions; a solver
    /// with checks verifies that. Null is allowed.
    fn geosweep_directions_destroy(directions: *mut GeosweepDirections) {
        outputs::destroy(directions)?;
    }
}
