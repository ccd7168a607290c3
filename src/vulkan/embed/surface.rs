//! Holds the surface of a renderer: its images, and the host's memory that it reads.

use crate::vulkan::device::device_memory::DeviceMemory;
use std::sync::Arc;

use ash::vk;

use super::inputs::{Points, SourceBuffer};
use super::names::{SurfaceLabels, name_of_surface};
use super::numbered::nth;
use super::outcome::Outcome;
use super::outputs::HostImage;
use super::solver::{PipelineSet, Solver};
use super::state::State;
use super::surface_info::SurfaceInfo;
use super::surface_sets::HostSets;
use crate::constants::{BORDER, FARTHEST_SPLIT, SOURCES_TOGETHER, SPLIT_REACH, TIME};
use crate::surface::{Chart, EdgeRule, Glued, Gluing, GluingError, SurfaceError, UNGLUED};
use crate::update::Wavefront;
use crate::vulkan::VulkanError;
use crate::vulkan::copies::CopyList;
use crate::vulkan::device::bands::{POINT_BYTES, bands, frame_bytes};
use crate::vulkan::device::memory::{FORMAT, RESULT_FORMAT};
use crate::vulkan::device::passes::Variant;
use crate::vulkan::flight::Flight;
use crate::vulkan::grid_images::{GridImages, INLINE_SOURCES, Purpose};
use crate::vulkan::schedules::progress::Record;

/// Surface on the host's device. It has the edge lengths, curvature and fronts, which all recordings share,
/// and an image of distances for each slot.
///
/// Dropping a surface frees nothing. The host calls [`FrameSurface::destroy`] once no submitted work uses it.
#[derive(Debug)]
pub struct FrameSurface {
    pub(super) grid: GridImages,
    pub(super) sets: HostSets,
    /// Images of the host for the distances; empty if the surface has its own.
    pub(super) results: Vec<HostImage>,
    pub(super) points: Vec<Points>,
    pub(super) sources: Vec<SourceBuffer>,
    pub(super) lookup_counts: Vec<u32>,
    pub(super) state: State,
    pub(super) flight: Arc<Flight>,
    pub(super) edge_rule: EdgeRule,
    pub(super) gluing: Option<Gluing>,
    /// See [`SurfaceInfo::has_skewed_cells`].
    pub(super) has_skewed_cells: bool,
    /// Whether the solver has [`super::Tools::checks`].
    checks: bool,
    /// Labels of recordings, if the solver has [`super::Tools::labels`].
    pub(super) labels: Option<SurfaceLabels>,
}

/// Image that holds distances. It belongs to the surface, with the usages `SAMPLED`, `STORAGE` and
/// `TRANSFER_SRC`, or to the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResultImage {
    /// Image handle.
    pub image: vk::Image,
    /// View of the whole image.
    pub view: vk::ImageView,
    /// R32_SFLOAT, or R32G32B32A32_SFLOAT for packed times. All devices can sample R32_SFLOAT, but some
    /// cannot filter it.
    pub format: vk::Format,
    /// Width and height in texels.
    pub extent: vk::Extent2D,
    /// Layout of the image after the recording.
    pub layout: vk::ImageLayout,
}

/// Arrival times as the passes store them: 2 x 2 grid points per texel, inside a border of texels that are
/// never reached. They are not suited to filtering.
///
/// The point at row r and column c is component 2 (r mod 2) + c mod 2 of the texel (c / 2 + border, r / 2 +
/// border), in layer `layer`. Points that are not reached hold 1e30 or more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PackedTimes {
    /// Image, always in the layout `GENERAL`. The view is an array. Its other layers do not hold times.
    pub image: ResultImage,
    /// Layer of the view that holds the times.
    pub layer: u32,
    /// Width of the border around the grid in texels.
    pub border: u32,
}

/// Largest [`Outcome::seam_gap`] that checks accept.
const LARGEST_GAP: f64 = 0.1;

impl FrameSurface {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        solver: &Solver,
        info: &SurfaceInfo,
    ) -> Result<Self, VulkanError> {
        let families = info.families();
        let (size, purpose, glued) = info.wanted(solver, &families)?;
        let pipelines = &solver.pipelines;
        let name = name_of_surface(info.name);
        let purpose = Purpose { owner: &name, ..purpose };
        let slowed = purpose.slowed;
        let small_tiles = solver.tuning().has_small_tiles(size.1);
        let (glued_sides, skewed) = (glued.is_some(), info.has_skewed_cells);
        let pipeline_set = PipelineSet { slowed, small_tiles, glued: glued_sides, skewed };
        solver.make_passes_for(device, pipeline_set)?;
        let mut grid = GridImages::new(device, allocator, pipelines, size, purpose)?;
        let host = (info.results, info.points, info.sources, info.lookups);
        let list = glued.map(|glued| CopyList::with_rings(info.chart, &glued));
        let made = match list {
            Some(list) => grid.glue(device, allocator, pipelines, list),
            None => Ok(()),
        };
        let made =
            made.and_then(|()| HostSets::new(device, pipelines, &solver.limits, &grid, host));
        match made {
            Ok(sets) => Ok(Self {
                sets,
                results: info.results.to_vec(),
                points: info.points.to_vec(),
                sources: info.sources.to_vec(),
                lookup_counts: info.lookups.iter().map(|lookup| lookup.count).collect(),
                edge_rule: info.edge_rule,
                gluing: info.gluing.cloned(),
                has_skewed_cells: info.has_skewed_cells,
                checks: solver.checks,
                labels: pipelines.labels.is_some().then(|| SurfaceLabels::new(&name)),
                state: State::new(info.slots.max(1)),
                flight: Arc::new(Flight::new(grid.records())),
                grid,
            }),
            Err(error) => {
                grid.destroy(device, allocator);
                Err(error)
            }
        }
    }

    pub(super) fn bytes_for(
        device: &ash::Device,
        solver: &Solver,
        info: &SurfaceInfo,
    ) -> Result<u64, VulkanError> {
        let families = info.families();
        let (size, purpose, glued) = info.wanted(solver, &families)?;
        let bytes = GridImages::bytes_for(device, solver.pipelines.tuning, size, purpose)?;
        let list = glued.map(|glued| CopyList::with_rings(info.chart, &glued).buffer_info());
        Ok(bytes + list.map_or(Ok(0), |info| info.bytes(device))?)
    }

    /// Returns the size of the grid.
    pub fn chart(&self) -> Chart {
        self.grid.chart
    }

    /// Returns the number of bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        self.grid.bytes()
    }

    /// Returns whether sides of the grid are glued.
    pub fn is_glued(&self) -> bool {
        self.gluing.is_some()
    }

    /// Returns the variant of passes over a finished map of this surface.
    pub(super) fn finished_map(&self, wavefront: Wavefront) -> Variant {
        Variant { glued: self.is_glued(), ..wavefront.into() }
    }

    /// Returns an error if the surface is glued. `what` is not available then.
    pub(super) fn check_open(&self, what: &'static str) -> Result<(), VulkanError> {
        match self.is_glued() {
            true => {
                Err(SurfaceError::from(GluingError::Unsupported { what, instead: UNGLUED }).into())
            }
            false => Ok(()),
        }
    }

    /// Returns the number of slots. Each has an image of distances.
    pub fn slots(&self) -> usize {
        self.grid.slots
    }

    /// Returns the image of distances of a slot. It has one texel per grid point, with columns to the right
    /// and rows downwards. `layout` is the layout of the [`super::Reader`] for which the image was last
    /// recorded. The view is valid from the start, for descriptor sets that are written early.
    ///
    /// # Errors
    /// If there is no such slot.
    pub fn result(&self, slot: usize, layout: vk::ImageLayout) -> Result<ResultImage, VulkanError> {
        nth(&self.sets.results, "slots", slot)?;
        let (image, view) = match self.results.get(slot) {
            Some(image) => (image.image, image.view),
            None => (self.grid.results[slot].image, self.grid.results[slot].view),
        };
        let Chart { rows, cols } = self.grid.chart;
        let extent = vk::Extent2D { width: cols as u32, height: rows as u32 };
        let format = RESULT_FORMAT;
        Ok(ResultImage { image, view, format, extent, layout })
    }

    /// Returns the packed arrival times, which all slots share. They are valid from one recording to the
    /// next.
    pub fn packed(&self) -> PackedTimes {
        let (image, extent) = (&self.grid.fronts[0], self.grid.texels.fronts_extent());
        let image = ResultImage {
            image: image.image,
            view: image.view,
            format: FORMAT,
            extent: vk::Extent2D { width: extent.width, height: extent.height },
            layout: vk::ImageLayout::GENERAL,
        };
        PackedTimes { image, layer: TIME, border: BORDER }
    }

    /// Returns the outcome of the last recording for a slot. Call it after the fence of the submission.
    ///
    /// # Errors
    /// If there is no such slot. [`VulkanError::NotRun`] if the last recording for it has not run. If a
    /// command buffer is submitted repeatedly, the result is that of the last run that has ended.
    /// [`VulkanError::PreparationLost`] if [`super::Recording::prepare`] has not run before the recording.
    /// [`VulkanError::SeamGap`] with [`super::Tools::checks`], if [`Outcome::seam_gap`] is above a tenth.
    pub fn outcome(&self, slot: usize) -> Result<Outcome, VulkanError> {
        self.check_slot(slot)?;
        let record = self.grid.record(slot);
        if !self.state.has_run(slot, record.serial) {
            return Err(VulkanError::NotRun { slot });
        }
        match self.state.was_prepared_by(slot, record.prepared) {
            true => self.checked(&record),
            false => Err(VulkanError::PreparationLost),
        }
    }

    /// Returns the outcome in a record. With checks, it is an error if copies of a point lie apart.
    fn checked(&self, record: &Record) -> Result<Outcome, VulkanError> {
        let seen = if self.has_skewed_cells { FARTHEST_SPLIT } else { SPLIT_REACH };
        let outcome = Outcome::of(record, self.grid.chart, seen as usize);
        if self.checks && outcome.seam_gap > LARGEST_GAP {
            return Err(VulkanError::SeamGap {
                gap: outcome.seam_gap,
                place: record.seam_gap().1.and_then(|group| self.first_copy(group)),
            });
        }
        Ok(outcome)
    }

    /// Returns the row and column of the first copy in a group.
    fn first_copy(&self, group: usize) -> Option<(usize, usize)> {
        let chart = self.grid.chart;
        let glued = Glued::of_grid(chart, self.gluing.as_ref()?).ok()?;
        let first = *glued.groups().iter().nth(group)?.first()?;
        Some(chart.position(first as usize))
    }

    /// Notes that the next recording measures the edges.
    pub(super) fn measures(&self, solver: &Solver) {
        self.state.measure(solver.is_curved(), self.flight.coming());
    }

    /// With checks, returns an error if the surface's current edges were measured over copies that lie apart, as far as
    /// a recording that has run has shown it.
    pub(super) fn check_seams(&self) -> Result<(), VulkanError> {
        if !self.checks || !self.is_glued() {
            return Ok(());
        }
        let last = (0..self.slots()).map(|slot| (slot, self.grid.record(slot)));
        let last = last.filter(|(slot, record)| self.state.has_run_since(*slot, record.serial));
        last.map(|(_, record)| self.checked(&record)).try_for_each(|checked| checked.map(drop))
    }

    /// Returns the outcome that [`super::Recording::outcome_to`] has copied to a buffer of the host.
    ///
    /// # Errors
    /// [`VulkanError::PreparationLost`] if the surface's last recorded [`super::Recording::prepare`] has not
    /// run before the copy. The error is the same for bytes that are not an outcome, or the outcome of
    /// another surface.
    pub fn outcome_from(&self, bytes: &[u8; Outcome::BYTES]) -> Result<Outcome, VulkanError> {
        let mut record = [0; size_of::<Record>()];
        record[..Outcome::BYTES].copy_from_slice(bytes);
        let record: Record = bytemuck::pod_read_unaligned(&record);
        match self.state.is_prepared_by(record.prepared) {
            true => self.checked(&record),
            false => Err(VulkanError::PreparationLost),
        }
    }

    /// Returns a slot whose last recording may still be pending, if there is one. Nothing that the recording uses may
    /// be destroyed yet, unless the recording was never submitted.
    pub fn in_flight(&self) -> Option<usize> {
        (0..self.slots()).find(|&slot| self.state.is_in_flight(slot, self.grid.record(slot).serial))
    }

    /// Returns whether a tracked recording may still be pending. Recordings with an outcome are tracked, and with
    /// [`super::Tools::checks`] all recordings. At most 64 command buffers of a surface are tracked at once. A command
    /// buffer that is submitted repeatedly is tracked until its first run has ended.
    pub fn is_in_flight(&self) -> bool {
        self.flight.waiting().is_some()
    }

    /// Returns whether a tracked recording that reads the surface's points with this number may still be pending.
    ///
    /// # Errors
    /// If there are no such points.
    pub fn points_in_flight(&self, number: usize) -> Result<bool, VulkanError> {
        Ok(nth(&self.sets.points, "point inputs", number)?.are_in_flight(&self.flight))
    }

    /// Declares that the last recording for a slot was discarded and will never run. The surface no longer
    /// waits for it.
    ///
    /// # Errors
    /// If there is no such slot.
    pub fn discard(&self, slot: usize) -> Result<(), VulkanError> {
        self.check_slot(slot)?;
        self.state.discard(slot);
        self.flight.discard_slot(slot);
        Ok(())
    }

    /// Declares that everything recorded last into a command buffer, for a slot or not, was discarded and
    /// will never run.
    pub fn discard_commands(&self, commands: vk::CommandBuffer) {
        self.state.discard_commands(commands);
        self.flight.discard_commands(commands);
    }

    /// Returns the largest number of passes of a frame in addition to those of its plan.
    pub(super) fn passes_around(&self) -> u32 {
        let (chart, is_glued) = (self.grid.chart, u32::from(self.grid.copies.is_some()));
        let wide = self.grid.lattice.with_halo(chart);
        let copies = self.grid.lattice.copies().count() as u32;
        let measured = 2 * bands(wide, POINT_BYTES, frame_bytes(chart)).count() as u32 + 2;
        let inline = INLINE_SOURCES as u32;
        let sources = self.sources.iter().map(|sources| sources.count).max();
        let sources = sources.unwrap_or(0).max(inline);
        // Sources are read, and their seeds set, in portions. The surroundings of sources are solved, merged and
        // set. The other five passes forget the map, start it, reset the points beyond its limit, copy the
        // outcome, and unpack the distances. On a glued surface, copies share their curvatures and exchange their
        // seeds.
        2 * is_glued + measured + 1 + 2 * copies * sources.div_ceil(SOURCES_TOGETHER) + 3 + 5
    }

    /// Returns an error if there is no such slot. `Recording::check_slot` checks whether the slot is in flight.
    pub(super) fn check_slot(&self, slot: usize) -> Result<(), VulkanError> {
        self.result(slot, vk::ImageLayout::UNDEFINED).map(drop)
    }

    /// Frees everything. `device` and `allocator` are those that the surface was made with. No submitted work
    /// may still use the surface: the host waits for the fences of the frames in flight, or frees the surface
    /// after the same number of further frames. A second call does nothing.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        self.state.destroy();
        self.flight.land();
        self.sets.destroy(device);
        self.grid.destroy(device, allocator);
    }
}

impl Solver {
    /// Returns the number of bytes that a surface takes from the allocator's memory blocks on this device. No
    /// memory is allocated.
    ///
    /// # Errors
    /// If the grid is empty or too large for the device, the images in [`SurfaceInfo::results`] cannot be
    /// used, or a Vulkan call fails.
    pub fn bytes_for(&self, device: &ash::Device, info: &SurfaceInfo) -> Result<u64, VulkanError> {
        FrameSurface::bytes_for(device, self, info)
    }

    /// Creates a surface. This is the only call that allocates for a surface. The first recording for it must
    /// be [`super::Recording::prepare`].
    ///
    /// # Errors
    /// If the grid is empty or too large for the device, memory runs out, or a buffer or image of the host
    /// cannot be used as described. Nothing is left behind then.
    pub fn surface(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        info: &SurfaceInfo,
    ) -> Result<FrameSurface, VulkanError> {
        FrameSurface::new(device, allocator, self, info)
    }
}
