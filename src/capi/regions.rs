//! Regions of the points nearest to each source, for shaders in the same frame.

use std::sync::Arc;

use ash::vk;

use super::arguments::{Output, chart, reference};
use super::choices::{WavefrontNumber, wavefront};
use super::frame::{GeosweepAccess, GeosweepSources, access, sources};
use super::objects::{exclusive, hand_out, land, object, take};
use super::record::{output_unless_null, record};
use super::shared::Shared;
use super::solver::GeosweepSolver;
use super::status::{Failure, GeosweepStatus, guard};
use super::surface::GeosweepSurface;
use crate::vulkan::embed::{self, Recording};

/// Label of a point without a nearest source: the point is a hole, or no front arrives there.
pub const GEOSWEEP_NO_REGION: u32 = 0xFFFF_FFFF;
const _: () = assert!(GEOSWEEP_NO_REGION == crate::geometry::NO_REGION);

/// Buffer for the regions of a surface's maps, and the passes that find them. Frames in flight on one queue
/// share one such object. If regions are read on other queues, create one object for each of these queues.
pub struct GeosweepRegions {
    pub(super) shared: Arc<Shared>,
    regions: embed::Regions,
}

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

/// Computes the bytes of device memory that regions will take, before they are created: 24 per grid point.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_regions_bytes_for(
    solver: *const GeosweepSolver,
    rows: u32,
    cols: u32,
    bytes: *mut u64,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (solver, output) = unsafe { (object(solver, "solver")?, Output::new(bytes, "bytes")?) };
        let Shared { solver, device, .. } = &**solver.shared();
        output.write(solver.bytes_for_regions(device, chart(rows, cols)?)?);
        Ok(())
    })
}

/// Creates regions of a surface's maps with one wavefront. Allocates device memory and compiles passes.
/// `geosweep_regions_destroy` destroys the regions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_regions_create(
    surface: *const GeosweepSurface,
    wavefront: WavefrontNumber,
    regions: *mut *mut GeosweepRegions,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (surface, output) =
            unsafe { (object(surface, "surface")?, Output::new(regions, "regions")?) };
        let wavefront = self::wavefront(wavefront, "wavefront")?;
        let GeosweepSurface { shared, surface, .. } = surface;
        let mut allocator = shared.allocator();
        let regions = shared.solver.regions(&shared.device, &mut allocator, surface, wavefront)?;
        hand_out(output, GeosweepRegions { shared: Arc::clone(shared), regions });
        Ok(())
    })
}

/// Computes the bytes that your own buffer for regions must have, if you provide one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_regions_buffer_bytes(
    rows: u32,
    cols: u32,
    bytes: *mut u64,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let output = unsafe { Output::new(bytes, "bytes") }?;
        output.write(embed::Regions::buffer_bytes(chart(rows, cols)?));
        Ok(())
    })
}

/// Creates regions as `geosweep_regions_create` does, in your own buffer from its first byte. The buffer's
/// usage contains `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`, `VK_BUFFER_USAGE_TRANSFER_DST_BIT` and what its
/// readers need, device addresses included. The buffer remains yours. While no regions are in use, a render
/// graph may use its memory for other resources.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_regions_create_into(
    surface: *const GeosweepSurface,
    wavefront: WavefrontNumber,
    buffer: vk::Buffer,
    regions: *mut *mut GeosweepRegions,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (surface, output) =
            unsafe { (object(surface, "surface")?, Output::new(regions, "regions")?) };
        let wavefront = self::wavefront(wavefront, "wavefront")?;
        let GeosweepSurface { shared, surface, .. } = surface;
        let mut allocator = shared.allocator();
        let (solver, device) = (&shared.solver, &shared.device);
        let regions = solver.regions_into(device, &mut allocator, surface, wavefront, buffer)?;
        hand_out(output, GeosweepRegions { shared: Arc::clone(shared), regions });
        Ok(())
    })
}

/// Makes regions write to another buffer of yours in later recordings. The regions must have been created
/// with your own buffer. Recordings in flight continue to use the previous buffer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_regions_set_buffer(
    regions: *mut GeosweepRegions,
    surface: *const GeosweepSurface,
    buffer: vk::Buffer,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, surface) =
            unsafe { (exclusive(regions, "regions")?, object(surface, "surface")?) };
        let Shared { device, solver, .. } = &*surface.shared;
        Ok(of.regions.set_buffer(device, solver, &surface.surface, buffer)?)
    })
}

/// Returns the bytes of device memory that regions take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_regions_bytes(
    regions: *const GeosweepRegions,
    bytes: *mut u64,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (regions, output) =
            unsafe { (object(regions, "regions")?, Output::new(bytes, "bytes")?) };
        output.write(regions.regions.bytes());
        Ok(())
    })
}

/// Returns where labels are stored, also before any are recorded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_regions_labels(
    regions: *const GeosweepRegions,
    labels: *mut GeosweepLabels,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (regions, output) =
            unsafe { (object(regions, "regions")?, Output::new(labels, "labels")?) };
        output.write(regions.regions.labels().into());
        Ok(())
    })
}

/// Finds the nearest source of each grid point and stores the labels for you to read. A label is the index of
/// a source in the list, or `GEOSWEEP_NO_REGION`. Call this after the map was recorded, in the same command
/// buffer or after `geosweep_record_begin`. Writes where labels are stored to `result` unless that is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_record_regions(
    surface: *const GeosweepSurface,
    commands: vk::CommandBuffer,
    regions: *const GeosweepRegions,
    frame: *const GeosweepRegionFrame,
    result: *mut GeosweepLabels,
) -> GeosweepStatus {
    let append = |_: &_, recording: Recording| {
        // SAFETY: the caller's promise.
        let (output, regions, given, sources) = unsafe {
            let output = output_unless_null(result)?;
            let regions = object(regions, "regions")?;
            let given = reference(frame, "frame")?;
            (output, regions, given, sources(&given.sources, "frame->sources.sources")?)
        };
        let labels = recording.regions(
            &regions.regions,
            &embed::RegionFrame::new(sources, access(given.reader, "frame->reader")?)
                .with_before(access(given.before, "frame->before")?),
        )?;
        if let Some(output) = output {
            output.write(labels.into());
        }
        Ok::<_, Failure>(())
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Makes regions read the surface's sources that `geosweep_surface_set_sources` has set since the regions
/// were created. Recordings in flight continue to read the previous sources.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_regions_rebind(
    regions: *mut GeosweepRegions,
    surface: *const GeosweepSurface,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, surface) =
            unsafe { (exclusive(regions, "regions")?, object(surface, "surface")?) };
        let Shared { device, solver, .. } = &*surface.shared;
        Ok(of.regions.rebind(device, solver, &surface.surface)?)
    })
}

/// Destroys regions, before or after their surface. No submitted work may still use them; a solver with
/// checks verifies that. Null is allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn geosweep_regions_destroy(regions: *mut GeosweepRegions) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let Some(_) = (unsafe { land(regions, "regions", |of| of.regions.is_in_flight()) })? else {
            return Ok(());
        };
        // SAFETY: the caller's promise.
        let Some(regions) = unsafe { take(regions, "regions") }? else { return Ok(()) };
        let GeosweepRegions { shared, mut regions } = regions;
        regions.destroy(&shared.device, &mut shared.allocator());
        Ok(())
    })
}

impl From<embed::RegionBuffer> for GeosweepLabels {
    fn from(labels: embed::RegionBuffer) -> Self {
        let embed::RegionBuffer { buffer, bytes } = labels;
        Self { buffer, bytes }
    }
}
