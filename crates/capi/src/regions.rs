//! Regions of the points nearest to each source, for shaders in the same frame.

use ash::vk;

use super::arguments::{chart, reference, write};
use super::choices::{WavefrontNumber, choose};
use super::frame::{GeosweepAccess, GeosweepSources, access, sources};
use super::objects::{kind_of_object, object};
use super::outputs;
use super::record::record;
use super::shared::{Made, same_fields};
use super::solver::GeosweepSolver;
use super::status::calls;
use super::surface::GeosweepSurface;
use geosweep::vulkan::embed;

/// Label of a point without a nearest source: the point is a hole, or no front arrives there.
pub const GEOSWEEP_NO_REGION: u32 = 0xFFFF_FFFF;
const _: () = assert!(GEOSWEEP_NO_REGION == geosweep::geometry::NO_REGION);

/// Buffer for the regions of a surface's maps, and the passes that find them. Frames in flight on one queue
/// share one such object. If regions are read on other queues, create one object for each of these queues.
pub struct GeosweepRegions(());

kind_of_object! { GeosweepRegions, regions: Made<embed::Regions> }

/// Buffer of labels. Unless it is your own, it has the usages `STORAGE_BUFFER`, `VERTEX_BUFFER` and
/// `TRANSFER_SRC`. From its first byte it has an unsigned 32-bit number for each grid point, row by row.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepLabels {
    /// The buffer, which is longer than the labels. Unless it is your own, it belongs to the regions.
    pub buffer: vk::Buffer,
    /// Bytes of all labels: 4 x rows x cols.
    pub bytes: u64,
}

/// Sources whose regions a recording finds, and the commands that read the labels.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepRegionFrame {
    /// Access that has written the sources.
    pub before: GeosweepAccess,
    /// All sources of the map, including those that were added to the map. A source's index in this list is
    /// its label.
    pub sources: GeosweepSources,
    /// Access that reads the labels, in this frame and in the previous one.
    pub reader: GeosweepAccess,
}

calls! {
    /// Computes the bytes of device memory that regions will take, before they are created: 24 per grid point.
    fn geosweep_regions_bytes_for(
        solver: *const GeosweepSolver,
        rows: u32,
        cols: u32,
        bytes: *mut u64,
    ) {
        outputs::bytes_for(solver, bytes, |solver, device| {
            Ok(solver.bytes_for_regions(device, chart(rows, cols)?)?)
        })?;
    }

    /// Creates regions of a surface's maps with one wavefront. Allocates device memory and compiles passes.
    /// `geosweep_regions_destroy` destroys the regions.
    fn geosweep_regions_create(
        surface: *const GeosweepSurface,
        wavefront: WavefrontNumber,
        regions: *mut *mut GeosweepRegions,
    ) {
        let wavefront = choose(wavefront, "wavefront")?;
        outputs::create(surface, regions, |solver, device, memory, surface| {
            solver.regions(device, memory, surface, wavefront)
        })?;
    }

    /// Computes the bytes that your own buffer for regions must have, if you provide one.
    fn geosweep_regions_buffer_bytes(rows: u32, cols: u32, bytes: *mut u64) {
        write(bytes, "bytes", embed::Regions::buffer_bytes(chart(rows, cols)?))?;
    }

    /// Creates regions as `geosweep_regions_create` does, in your own buffer from its first byte. The buffer's
    /// usage contains `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`, `VK_BUFFER_USAGE_TRANSFER_DST_BIT` and what its
    /// readers need, device addresses included. The buffer remains yours. While no regions are in use, a render
    /// graph may use its memory for other resources.
    fn geosweep_regions_create_into(
        surface: *const GeosweepSurface,
        wavefront: WavefrontNumber,
        buffer: vk::Buffer,
        regions: *mut *mut GeosweepRegions,
    ) {
        let wavefront = choose(wavefront, "wavefront")?;
        outputs::create(surface, regions, |solver, device, memory, surface| {
            solver.regions_into(device, memory, surface, wavefront, buffer)
        })?;
    }

    /// Makes regions write to another buffer of yours in later recordings. The regions must have been created
    /// with your own buffer. Recordings in flight continue to use the previous buffer.
    fn geosweep_regions_set_buffer(
        regions: *mut GeosweepRegions,
        surface: *const GeosweepSurface,
        buffer: vk::Buffer,
    ) {
        outputs::set_buffer(regions, surface, buffer)?;
    }

    /// Returns the bytes of device memory that regions take.
    fn geosweep_regions_bytes(regions: *const GeosweepRegions, bytes: *mut u64) {
        outputs::bytes(regions, bytes)?;
    }

    /// Returns where labels are stored, also before any are recorded.
    fn geosweep_regions_labels(regions: *const GeosweepRegions, labels: *mut GeosweepLabels) {
        write(labels, "labels", object(regions)?.of.labels().into())?;
    }

    /// Finds the nearest source of each grid point and stores the labels for you to read. A label is the index of
    /// a source in the list, or `GEOSWEEP_NO_REGION`. Call this after the map was recorded, in the same command
    /// buffer or after `geosweep_record_begin`. Writes where labels are stored to `result` unless that is null.
    fn geosweep_record_regions(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
        regions: *const GeosweepRegions,
        frame: *const GeosweepRegionFrame,
        result: *mut GeosweepLabels,
    ) {
        record(surface, commands, result, |_, recording| {
            let (regions, given) = (object(regions)?, reference(frame, "frame")?);
            let sources = sources(&given.sources, "frame->sources.sources")?;
            let frame = embed::RegionFrame::new(sources, access(given.reader, "frame->reader")?)
                .with_before(access(given.before, "frame->before")?);
            Ok(recording.regions(&regions.of, &frame)?)
        })?;
    }

    /// Makes regions read the surface's sources that `geosweep_surface_set_sources` has set since the regions
    /// were created. Recordings in flight continue to read the previous sources.
    fn geosweep_regions_rebind(regions: *mut GeosweepRegions, surface: *const GeosweepSurface) {
        outputs::rebind(regions, surface)?;
    }

    /// Destroys regions, before or after their surface. No submitted work may still use them; a solver with
    /// checks verifies that. Null is allowed.
    fn geosweep_regions_destroy(regions: *mut GeosweepRegions) {
        outputs::destroy(regions)?;
    }
}

same_fields! { embed::RegionBuffer => GeosweepLabels { buffer, bytes }; }
