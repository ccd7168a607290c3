//! A surface and its queries.

use std::sync::Arc;

use ash::vk;

use super::arguments::{Output, reference, write};
use super::objects::{check_landed, exclusive, hand_out, in_flight, kind_of_object, object, take};
use super::points::{Arrays, Copied, Form, GeosweepPoints};
use super::shared::{Shared, same_fields};
use super::solver::GeosweepSolver;
use super::status::{Failure, calls};
use super::surface_info::{
    GeosweepHostImage, GeosweepSourceBuffer, GeosweepSurfaceInfo, Wanted, name,
};
use geosweep::surface::{EdgeRule, Unresolved};
use geosweep::vulkan::embed;

/// A grid on the device: edge lengths and fronts, which all recordings share, and an image of distances for
/// each slot.
pub struct GeosweepSurface {
    pub(super) shared: Arc<Shared>,
    pub(super) surface: embed::FrameSurface,
    edge_rule: EdgeRule,
    /// Points that were copied from the program's memory, indexed by the number of the points.
    copied: Vec<Option<Copied>>,
}

kind_of_object! { GeosweepSurface, surface: GeosweepSurface }

/// An image of distances, directions or a log map. Unless it is your own, it belongs to the object that
/// returns it and has the usages `SAMPLED` and `TRANSFER_SRC`, for distances `STORAGE` too.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepImage {
    /// The image.
    pub image: vk::Image,
    /// A view of the whole image.
    pub view: vk::ImageView,
    /// `VK_FORMAT_R32_SFLOAT` for distances, with one texel for each grid point: x is the column, and y is
    /// the row. Not all devices can filter it.
    pub format: vk::Format,
    /// Width and height in texels.
    pub extent: vk::Extent2D,
    /// Layout of the image after the recording.
    pub layout: vk::ImageLayout,
}

/// Distances in the form in which the passes store them: 2 x 2 grid points per texel, with a border. They
/// cannot be filtered. The point at row r and column c is component 2 (r mod 2) + c mod 2 of texel (c / 2 +
/// border, r / 2 + border) in layer `layer`. A point that no front has reached has 1e30 or more.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepPackedTimes {
    /// Image with `VK_FORMAT_R32G32B32A32_SFLOAT`, always in the layout `VK_IMAGE_LAYOUT_GENERAL`. Its view
    /// is an array.
    pub image: GeosweepImage,
    /// Layer of the view.
    pub layer: u32,
    /// Width of the border around the grid in texels.
    pub border: u32,
}

/// Outcome of a recording's iterations.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepOutcome {
    /// Largest relative change of a distance in the last iteration.
    pub residual: f64,
    /// Number of iterations, or of rounds of tiles, since the start of the map.
    pub iterations: u32,
    /// Number of visits since the start of the map, each by one workgroup: to a tile, or to the part of a block of
    /// lines that a workgroup updates. A smaller radius takes fewer visits.
    pub visits: u32,
    /// Number of grid points that are holes. A point is a hole if one of its values is not finite or too
    /// large, if it lies outside an image that is too small, or if its slowness is negative. Compare this
    /// with the holes that you made.
    pub holes: u32,
    /// Number of edges without a length between points that are not holes. Their points are at the same
    /// place, or so far apart that the length overflows single precision. Expect such edges at a pole or a
    /// seam. More of them mean that vertices were zeroed or not written yet.
    pub edges_without_length: u32,
    /// Number of the map's sources that reach no point: those off the grid, in holes, or with a time that is
    /// NaN or not below 1e30. Unused entries of a buffer count too.
    pub passed_over: u32,
    /// Largest gap between copies of a point of a glued surface, relative to the longest edge at these copies; 0 if
    /// the surface is not glued. It is rounded down by up to a sixteenth. A gap above a twentieth usually means
    /// that other sides are glued than those that coincide, or that one of them runs in the reverse order. With
    /// `GEOSWEEP_SOLVER_CHECKS`, a gap above a tenth makes the call fail.
    pub seam_gap: f32,
    /// Fraction of edges at whose ends the surface's normals differ by more than 30 degrees, among about a
    /// thousand edges. It is 0 for a metric. Above a tenth, the grid does not resolve the surface, and the
    /// map is that of some polyhedron.
    pub sharp_edges: f32,
    /// Whether the surface turns at random from point to point, as noise does. On such surfaces planar fronts
    /// have the smallest errors, and curved ones may arrive early by some hundredths of the distance.
    pub is_rough: bool,
    /// Row of the point whose cells are skewed most; see `unresolved_distance`.
    pub unresolved_row: u32,
    /// Column of that point.
    pub unresolved_col: u32,
    /// Distance in rows and columns of the points from which fronts arrive there, if that is too far away for updates, and
    /// 0 if it is not. Fronts may then be late around that point. `GeosweepSurfaceInfo::has_skewed_cells` lets updates
    /// look farther. If that is set already, the grid has to follow the direction in which lengths are short.
    pub unresolved_distance: u32,
    /// Whether the map has converged, over edges that were measured. If not, `geosweep_record_resume`
    /// continues it.
    pub converged: bool,
    /// Whether edges have been measured on the device. It is false if the recording that measures them has
    /// never run.
    pub measured: bool,
}

impl AsRef<Shared> for GeosweepSurface {
    fn as_ref(&self) -> &Shared {
        &self.shared
    }
}

impl From<embed::Outcome> for GeosweepOutcome {
    fn from(outcome: embed::Outcome) -> Self {
        let resolution = outcome.resolution;
        let unresolved = |of: fn(Unresolved) -> usize| outcome.unresolved.map_or(0, of) as u32;
        Self {
            residual: outcome.residual,
            iterations: outcome.iterations,
            visits: outcome.visits,
            holes: outcome.holes,
            edges_without_length: outcome.edges_without_length,
            passed_over: outcome.passed_over,
            seam_gap: outcome.seam_gap as f32,
            sharp_edges: resolution.map_or(0.0, |of| of.sharp_edges as f32),
            is_rough: resolution.is_some_and(|of| of.is_rough()),
            unresolved_row: unresolved(|at| at.row),
            unresolved_col: unresolved(|at| at.col),
            unresolved_distance: unresolved(|at| at.needed),
            converged: outcome.converged,
            measured: outcome.measured,
        }
    }
}

same_fields! { embed::ResultImage => GeosweepImage { image, view, format, extent, layout }; }

impl GeosweepSurface {
    /// Creates a surface.
    ///
    /// # Safety
    /// The arrays of points have the sizes that their layouts require.
    unsafe fn new(wanted: &Wanted, shared: &Arc<Shared>) -> Result<Self, Failure> {
        // If the grid is too large for the device, this fails before its points are read.
        wanted.bytes(shared)?;
        let read = wanted.points.iter().enumerate().map(|(index, form)| match form {
            Form::OnDevice(_) => Ok(None),
            Form::InProgram(layout, arrays) => {
                let prefix = format!("{}.", name(index));
                // SAFETY: the caller's promise.
                let read = unsafe { layout.read(*arrays, wanted.chart, wanted.edge_rule, &prefix) };
                Ok(Some((*layout, read?)))
            }
        });
        let read = read.collect::<Result<Vec<_>, Failure>>()?;
        let mut allocator = shared.allocator();
        let mut copied = Vec::new();
        let mut make = || {
            for read in &read {
                copied.push(match read {
                    Some((layout, surface)) => {
                        Some(Copied::new(shared, &mut allocator, *layout, surface)?)
                    }
                    None => None,
                });
            }
            let points: Vec<_> = wanted
                .points
                .iter()
                .zip(&copied)
                .filter_map(|(form, copied)| match form {
                    Form::OnDevice(points) => Some(*points),
                    Form::InProgram(..) => copied.as_ref().map(Copied::points),
                })
                .collect();
            let info = wanted.info(&points);
            Ok(shared.solver.surface(&shared.device, &mut allocator, &info)?)
        };
        match make() {
            Ok(surface) => {
                let edge_rule = wanted.edge_rule;
                Ok(Self { shared: Arc::clone(shared), surface, edge_rule, copied })
            }
            Err(failure) => {
                for copied in copied.iter_mut().flatten() {
                    copied.destroy(shared, &mut allocator);
                }
                Err(failure)
            }
        }
    }
}

calls! {
    /// Computes the bytes of device memory that a surface will take, before it is created: 36 per grid point and
    /// 4 more for each slot; a buffer of 16 per point up to 4 MiB, or on larger grids of 6 per point up to 16
    /// MiB; and, for points in the program's memory, 12 per point (4 for heights), with a slowness 4 more.
    fn geosweep_surface_bytes_for(
        solver: *const GeosweepSolver,
        info: *const GeosweepSurfaceInfo,
        bytes: *mut u64,
    ) {
        let wanted = Wanted::new(reference(info, "info")?)?;
        write(bytes, "bytes", wanted.bytes(object(solver)?)?)?;
    }

    /// Creates a surface. Allocates device memory. `geosweep_surface_destroy` destroys the surface.
    fn geosweep_surface_create(
        solver: *const GeosweepSolver,
        info: *const GeosweepSurfaceInfo,
        surface: *mut *mut GeosweepSurface,
    ) {
        let output = Output::new(surface, "surface")?;
        let (shared, wanted) = (object(solver)?, Wanted::new(reference(info, "info")?)?);
        hand_out(output, GeosweepSurface::new(&wanted, shared)?);
    }

    /// Returns the bytes of device memory that a surface takes.
    fn geosweep_surface_bytes(surface: *const GeosweepSurface, bytes: *mut u64) {
        let surface = object(surface)?;
        let copied = surface.copied.iter().flatten().map(Copied::bytes).sum::<u64>();
        write(bytes, "bytes", surface.surface.bytes() + copied)?;
    }

    /// Replaces points that were copied from the program's memory by others with the same offset and stride. No
    /// submitted work may still read the old points; a solver with checks verifies that. So create the surface
    /// with one entry of points for each frame in flight. Later recordings that measure these points read the new
    /// values.
    fn geosweep_surface_write_points(
        surface: *mut GeosweepSurface,
        number: u32,
        data: *const f32,
        mask: *const u8,
    ) {
        let surface = exclusive(surface)?;
        let at = number as usize;
        let has_checks = surface.shared.has_checks();
        if has_checks && surface.surface.points_in_flight(at).unwrap_or(false) {
            let what = format!("is {number}, and a recording that reads these points has not run");
            return Err(in_flight("number", &what));
        }
        let (chart, edge_rule) = (surface.surface.chart(), surface.edge_rule);
        let count = surface.copied.len();
        let copied = surface.copied.get_mut(at).ok_or_else(|| {
            Failure::argument("number", format!("is {number}, and there are {count} points"))
        })?;
        let copied = copied.as_mut().ok_or_else(|| {
            let reason = format!("is {number}, and those points are in memory of yours");
            Failure::argument("number", reason)
        })?;
        let read = copied.layout.read(Arrays { data, mask }, chart, edge_rule, "")?;
        copied.write(&read);
    }

    /// Replaces points in your own buffer or image by others, which later recordings read. The new points may
    /// have a slowness only if some points of the surface had a slowness when the surface was created. Frames in
    /// flight continue to read the points for which they were recorded, so keep these alive until the frames have
    /// run. It is an error if more frames are in flight than the surface has slots. Edges keep the lengths of the
    /// old points until they are measured. Contours and paths are lifted to the new points after
    /// `geosweep_contours_rebind` and `geosweep_paths_rebind`. Command buffers that are submitted repeatedly must
    /// be recorded anew.
    fn geosweep_surface_set_points(
        surface: *mut GeosweepSurface,
        number: u32,
        points: *const GeosweepPoints,
    ) {
        let (surface, points) = (exclusive(surface)?, reference(points, "points")?);
        let Form::OnDevice(points) = Form::of(points, "points")? else {
            let reason = "is not null, and only points in a buffer or an image can be set: write \
                          others by geosweep_surface_write_points";
            return Err(Failure::argument("points->data", reason));
        };
        let number = number as usize;
        if surface.copied.get(number).is_some_and(Option::is_some) {
            let reason = format!(
                "is {number}, and those points were copied from the program's memory: write others by \
                 geosweep_surface_write_points"
            );
            return Err(Failure::argument("number", reason));
        }
        let Shared { device, solver, .. } = &*surface.shared;
        surface.surface.set_points(device, solver, number, &points)?;
    }

    /// Replaces a buffer of sources, as `geosweep_surface_set_points` does for points. Paths, regions, directions
    /// and log maps then need `geosweep_paths_rebind`, `geosweep_regions_rebind`, `geosweep_directions_rebind`
    /// and `geosweep_log_map_rebind`.
    fn geosweep_surface_set_sources(
        surface: *mut GeosweepSurface,
        number: u32,
        sources: *const GeosweepSourceBuffer,
    ) {
        let (surface, sources) = (exclusive(surface)?, (*reference(sources, "sources")?).into());
        let Shared { device, solver, .. } = &*surface.shared;
        surface.surface.set_sources(device, solver, number as usize, &sources)?;
    }

    /// Replaces your own image for the distances of a slot. The surface must have been created with your images.
    /// Later recordings write the new image, and frames in flight continue to write the old one. Replace an
    /// image at most once for each recording of its slot.
    fn geosweep_surface_set_result(
        surface: *mut GeosweepSurface,
        slot: u32,
        image: *const GeosweepHostImage,
    ) {
        let (surface, image) = (exclusive(surface)?, (*reference(image, "image")?).into());
        surface.surface.set_result(&surface.shared.device, slot as usize, image)?;
    }

    /// Returns the image of distances of a slot. `layout` is the layout of the reader for which the image was
    /// recorded last.
    fn geosweep_surface_result(
        surface: *const GeosweepSurface,
        slot: u32,
        layout: vk::ImageLayout,
        result: *mut GeosweepImage,
    ) {
        let image = object(surface)?.surface.result(slot as usize, layout)?;
        write(result, "result", image.into())?;
    }

    /// Returns the packed distances that all slots share. Until the next recording, these are the distances of
    /// the last one. Read them after `geosweep_record_end`.
    fn geosweep_surface_packed(surface: *const GeosweepSurface, packed: *mut GeosweepPackedTimes) {
        let embed::PackedTimes { image, layer, border } = object(surface)?.surface.packed();
        write(packed, "packed", GeosweepPackedTimes { image: image.into(), layer, border })?;
    }

    /// Returns the outcome of the last recording for a slot, after the fence of its submission. If that recording
    /// has not run, the status is `GEOSWEEP_STATUS_NOT_READY`.
    fn geosweep_surface_outcome(
        surface: *const GeosweepSurface,
        slot: u32,
        outcome: *mut GeosweepOutcome,
    ) {
        let (surface, output) = (object(surface)?, Output::new(outcome, "outcome")?);
        output.write(surface.surface.outcome(slot as usize)?.into());
    }

    /// Tells a solver with checks that the last recording for a slot was discarded and will never run.
    fn geosweep_surface_discard(surface: *const GeosweepSurface, slot: u32) {
        object(surface)?.surface.discard(slot as usize)?;
    }

    /// Tells a solver with checks that the last recording for the surface into a command buffer was discarded and
    /// will never run, whatever its kind.
    fn geosweep_surface_discard_commands(
        surface: *const GeosweepSurface,
        commands: vk::CommandBuffer,
    ) {
        object(surface)?.surface.discard_commands(commands);
    }

    /// Destroys a surface with its images. No submitted work may still use it; a solver with checks verifies
    /// that. Null is allowed.
    fn geosweep_surface_destroy(surface: *mut GeosweepSurface) {
        let check = |of: &GeosweepSurface| {
            let landed = check_landed::<GeosweepSurface>(of, of.surface.is_in_flight());
            landed.map_err(|failure| match of.surface.in_flight() {
                Some(slot) => {
                    let what = format!("is destroyed and its last recording for slot {slot} has not run");
                    in_flight("surface", &what)
                }
                None => failure,
            })
        };
        let Some(GeosweepSurface { shared, mut surface, mut copied, .. }) = take(surface, check)? else {
            return Ok(());
        };
        let mut allocator = shared.allocator();
        surface.destroy(&shared.device, &mut allocator);
        for copied in copied.iter_mut().flatten() {
            copied.destroy(&shared, &mut allocator);
        }
    }
}
