//! Regions of the points nearest to each source, for shaders in the same frame.

use std::sync::Arc;

use ash::vk;

use super::arguments::{Output, reference};
use super::choices::{WavefrontNumber, wavefront};
use super::frame::{GeosweepAccess, GeosweepSources, access, sources};
use super::objects::{exclusive, hand_out, land, object, take};
use super::plan::chart;
use super::record::{output_unless_null, record};
use super::solver::{GeosweepSolver, Shared};
use super::status::{Failure, GeosweepStatus, guard};
use super::surface::GeosweepSurface;
use crate::vulkan::embed::{self, Recording};

/// For a label: no source is the nearest, since the point is a hole or no front arrives there.
pub const GEOSWEEP_NO_REGION: u32 = 0xFFFF_FFFF;
const _: () = assert!(GEOSWEEP_NO_REGION == crate::geometry::NO_REGION);

/// Room for the regions of a surface's maps, and the passes that find them. Frames in flight on one queue share
/// it; with readers on another queue make one for each.
pub struct GeosweepRegions {
    pub(super) shared: Arc<Shared>,
    regions: embed::Regions,
}

/// Where labels are: a buffer with the usages `STORAGE_BUFFER`, `VERTEX_BUFFER` and `TRANSFER_SRC`, from its first
/// byte: an unsigned 32-bit number for each grid point, row by row.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepLabels {
    /// The buffer, which is longer, and belongs to the regions.
    pub buffer: vk::Buffer,
    /// Bytes of all labels: 4 x rows x cols.
    pub bytes: u64,
}

/// Of which sources regions are wanted, and who reads them.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepRegionFrame {
    /// How you have written the sources.
    pub before: GeosweepAccess,
    /// All sources of the map, those added to it too. Their places in this list are the labels.
    pub sources: GeosweepSources,
    /// How you read the labels, this frame and the frame before.
    pub reader: GeosweepAccess,
}

/// Says how many bytes of device memory regions will take, before they are made: 24 a grid point.
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

/// Makes room for the regions of a surface's maps with one wavefront; `geosweep_regions_destroy` destroys it.
/// Takes device memory and compiles passes.
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

/// Says how many bytes a buffer of yours has for regions, in place of one of their own.
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

/// Makes regions as `geosweep_regions_create` does, which go to a buffer of yours, from its first byte: with usage
/// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT` and `VK_BUFFER_USAGE_TRANSFER_DST_BIT` and what
/// its readers ask for, device addresses too. It stays yours, and a render graph may give its memory to others meanwhile.
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

/// Has regions from now on go to another buffer of yours, if they were made with one. Recordings in flight go on with the
/// one before.
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

/// Says how many bytes of device memory regions take.
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

/// Says where labels are, also before any are recorded.
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

/// Finds which source is the nearest to each grid point and leaves the labels for you to read: a source's place in
/// the list, or `GEOSWEEP_NO_REGION`. To be recorded after the map, in the same command buffer or after
/// `geosweep_record_begin`. Gives where they are to `result` unless that is null.
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
            &embed::RegionFrame {
                before: access(given.before, "frame->before")?,
                sources,
                reader: access(given.reader, "frame->reader")?,
            },
        )?;
        if let Some(output) = output {
            output.write(labels.into());
        }
        Ok::<_, Failure>(())
    };
    // SAFETY: the caller's promise.
    unsafe { record(surface, commands, append) }
}

/// Has regions read the surface's sources that were replaced since they were made, by
/// `geosweep_surface_set_sources`. Recordings in flight go on with those before.
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

/// Destroys regions, before or after their surface. No submitted work may still use them, which a solver
/// with checks looks at. Null is fine.
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
