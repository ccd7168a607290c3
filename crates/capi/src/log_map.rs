//! Log maps, in an image for shaders of the same frame.

use ash::vk;

use super::arguments::{chart, reference};
use super::frame::{
    GeosweepAccess, GeosweepReader, GeosweepSources, access, no_place, reader, sources,
};
use super::objects::{kind_of_object, object};
use super::outputs;
use super::record::record;
use super::shared::Made;
use super::solver::GeosweepSolver;
use super::status::calls;
use super::surface::{GeosweepImage, GeosweepSurface};
use super::surface_info::GeosweepHostImage;
use geosweep::vulkan::embed;

/// Image of the log map of point sources, and the passes that compute it. A texel of
/// `VK_FORMAT_R32G32_SFLOAT` is (u, v): the direction in which the shortest path to the point leaves its
/// source, times the distance. u is in the direction of increasing columns at the source, v at a right angle
/// to it, on the side of increasing rows. Frames in flight on one queue share the image.
pub struct GeosweepLogMap(());

kind_of_object! { GeosweepLogMap, log_map: Made<embed::LogMapImage> }

/// Sources of the log map, and the commands that read the image.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepLogMapFrame {
    /// Access that has written the sources.
    pub before: GeosweepAccess,
    /// All sources of the map, including those that were added to the map.
    pub sources: GeosweepSources,
    /// Access that reads the image, in this frame and in the previous one, and its layout.
    pub reader: GeosweepReader,
    /// Largest distance of points that get coordinates; 0 for no limit. If sources start at different times,
    /// the distance counts from the latest of these.
    pub radius: f32,
    /// Value of u and v at points that are not reached or beyond the radius. It is no coordinate: infinite, NaN, or
    /// with a size beyond the radius, beyond 1e6 if there is no limit. 0 is the place of the source.
    pub unreached: f32,
}

calls! {
    /// Computes the bytes of device memory that a log map will take, before it is created: 40 (32 with an image
    /// of yours) per grid point.
    fn geosweep_log_map_bytes_for(
        solver: *const GeosweepSolver,
        rows: u32,
        cols: u32,
        bytes: *mut u64,
    ) {
        outputs::bytes_for(solver, bytes, |solver, device| {
            Ok(solver.bytes_for_log_map(device, chart(rows, cols)?)?)
        })?;
    }

    /// Creates a log map of a surface, for maps with any wavefront. Allocates device memory and compiles passes.
    /// Without an `image` of yours, an image is allocated too; it has the format `VK_FORMAT_R32G32_SFLOAT`. Your
    /// image has at least cols x rows texels of that format, and its usage contains
    /// `VK_IMAGE_USAGE_TRANSFER_DST_BIT`. `geosweep_log_map_destroy` destroys the log map.
    fn geosweep_log_map_create(
        surface: *const GeosweepSurface,
        image: *const GeosweepHostImage,
        log_map: *mut *mut GeosweepLogMap,
    ) {
        let image = outputs::hosts(image)?;
        outputs::create(surface, log_map, |solver, device, memory, surface| match image {
            None => solver.log_map(device, memory, surface),
            Some(image) => solver.log_map_into(device, memory, surface, image),
        })?;
    }

    /// Makes a log map write to another image of yours in later recordings. The log map must have been created
    /// with an image of yours. Recordings in flight continue to use the previous image.
    fn geosweep_log_map_set_image(
        log_map: *mut GeosweepLogMap,
        image: *const GeosweepHostImage,
    ) {
        outputs::set_image(log_map, image)?;
    }

    /// Returns the bytes of device memory that a log map takes.
    fn geosweep_log_map_bytes(log_map: *const GeosweepLogMap, bytes: *mut u64) {
        outputs::bytes(log_map, bytes)?;
    }

    /// Returns the image, also before any recording writes it. `layout` is the layout of the reader for which the
    /// image is recorded.
    fn geosweep_log_map_image(
        log_map: *const GeosweepLogMap,
        layout: vk::ImageLayout,
        image: *mut GeosweepImage,
    ) {
        outputs::image(log_map, layout, image)?;
    }

    /// Computes the log map of the sources of the map. Call this after the map was recorded, in the same command
    /// buffer or after `geosweep_record_begin`. Writes the image to `result` unless that is null.
    fn geosweep_record_log_map(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        log_map: *const GeosweepLogMap,
        frame: *const GeosweepLogMapFrame,
        result: *mut GeosweepImage,
    ) {
        record(surface, commands, result, |_, recording| {
            let (log_map, given) = (object(log_map)?, reference(frame, "frame")?);
            let sources = sources(&given.sources, "frame->sources.sources")?;
            let frame = embed::LogMapFrame::new(sources, reader(given.reader, "frame->reader")?)
                .with_before(access(given.before, "frame->before")?)
                .with_unreached(no_place(given.unreached, given.radius, "frame->unreached")?)
                .with_radius(if given.radius == 0.0 { f32::INFINITY } else { given.radius });
            Ok(recording.log_map(&log_map.of, &frame)?)
        })?;
    }

    /// Makes a log map read the surface's sources that `geosweep_surface_set_sources` has set since the log map
    /// was created. Recordings in flight continue to read the previous sources.
    fn geosweep_log_map_rebind(log_map: *mut GeosweepLogMap, surface: *const GeosweepSurface) {
        outputs::rebind(log_map, surface)?;
    }

    /// Destroys a log map, before or after the surface. No submitted work may still use the log map; a solver
    /// with checks verifies that. Null is allowed.
    fn geosweep_log_map_destroy(log_map: *mut GeosweepLogMap) {
        outputs::destroy(log_map)?;
    }
}
