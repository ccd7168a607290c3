//! Defines the surface of a renderer: its images, and the host's memory that it reads.

use crate::vulkan::device::device_memory::DeviceMemory;
use std::sync::Arc;

use ash::vk;

use super::inputs::{Lookup, Points, SourceBuffer};
use super::names::{SurfaceLabels, name_of_surface};
use super::numbered::nth;
use super::outputs::HostImage;
use super::solver::{PipelineSet, Solver};
use super::state::State;
use super::surface_sets::HostSets;
use crate::constants::{
    BORDER, FARTHEST_SPLIT, NEVER_MEASURED, SOURCES_TOGETHER, SPLIT_REACH, TIME,
};
use crate::surface::{
    Chart, EdgeRule, Glued, Gluing, GluingError, Resolution, SurfaceError, UNGLUED, Unresolved,
};
use crate::update::Wavefront;
use crate::vulkan::copies::CopyList;
use crate::vulkan::device::bands::{POINT_BYTES, bands, frame_bytes};
use crate::vulkan::device::memory::{FORMAT, RESULT_FORMAT};
use crate::vulkan::device::passes::Variant;
use crate::vulkan::flight::Flight;
use crate::vulkan::grid_images::{GridImages, INLINE_SOURCES, Purpose};
use crate::vulkan::point_kind::PointKind;
use crate::vulkan::schedules::progress::{Record, offset};
use crate::vulkan::setters::setters;
use crate::vulkan::{TexelChart, VulkanError};

/// Parameters of a surface. The host's images and buffers still belong to the host. They must be alive
/// whenever a recording that uses them runs. Their contents may change from frame to frame.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct SurfaceInfo<'a> {
    /// Size of the grid.
    pub chart: Chart,
    /// Rule by which edges are measured.
    pub edge_rule: EdgeRule,
    /// Number of frames in flight, at least 1. The surface has one image of distances and one record of the outcome
    /// for each; frames write them in turn.
    pub slots: usize,
    /// Queue families that use the images of distances and the packed times: the family of the queue to which
    /// recordings are submitted and the families of the readers, which may be the same. If this lists
    /// different families, their queues share the images without ownership transfers. If it is empty, other
    /// families need ownership transfers.
    pub queue_families: &'a [u32],
    /// Sides of the grid that coincide, so that distances pass from one to the other; see
    /// [`crate::Surface::with_gluing`]. Both sides hold the points of the seam. Copies of a point take the values
    /// of the first copy, and are holes if any copy is a hole. [`Outcome::seam_gap`] says how far copies lie apart.
    /// Plans for the surface are made with [`super::Plan::over_seams`]. The gluing cannot be [`Gluing::Charts`],
    /// which depends on positions.
    pub gluing: Option<&'a Gluing>,
    /// Whether cells may be so skewed that fronts arrive from points more than six rows or columns away. Updates then look
    /// for points up to 16 away, which resolves axes of the metric with a ratio of 30 instead of 10. Creating the surface
    /// then also creates pipelines of its own for all schedules and wavefronts that the solver has at that time. An update
    /// takes longer only where cells are that skewed. [`Outcome::unresolved`] says whether it is enough. The sides of such
    /// a grid cannot be glued.
    pub has_skewed_cells: bool,
    /// Images of the host for the distances, one per slot. If this is empty, the surface allocates them. See
    /// [`HostImage`].
    pub results: &'a [HostImage],
    /// Points that recordings select by number, for instance one entry for each frame in flight. If any of
    /// them has a slowness, the surface takes 4 more bytes per point. Creating the surface then also creates
    /// pipelines with slowness for all schedules and wavefronts that the solver has at that time. Planar
    /// fronts take the place of circular ones.
    pub points: &'a [Points],
    /// Source buffers that recordings select by number.
    pub sources: &'a [SourceBuffer],
    /// Buffers for lookups, which recordings select by number.
    pub lookups: &'a [Lookup],
    /// Name of the surface in labels and names of objects, for debugging tools and the validation layers
    /// ([`super::Tools::labels`]). With `None` it is `surface` and a number.
    pub name: Option<&'a str>,
}

/// Size of the grid and of its images, the purpose of these, and the gluing.
type Wanted<'f> = ((Chart, TexelChart), Purpose<'f>, Option<Glued>);

impl<'a> SurfaceInfo<'a> {
    /// Returns the parameters of a grid with one slot, and with no memory of the host.
    pub fn new(chart: Chart) -> Self {
        Self {
            chart,
            edge_rule: EdgeRule::default(),
            slots: 1,
            queue_families: &[],
            gluing: None,
            has_skewed_cells: false,
            results: &[],
            points: &[],
            sources: &[],
            lookups: &[],
            name: None,
        }
    }

    /// Sets [`SurfaceInfo::name`].
    pub fn with_name(self, name: impl Into<Option<&'a str>>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Sets [`SurfaceInfo::gluing`].
    pub fn with_gluing(self, gluing: impl Into<Option<&'a Gluing>>) -> Self {
        Self { gluing: gluing.into(), ..self }
    }

    setters! {
        with_edge_rule(edge_rule: EdgeRule);
        with_slots(slots: usize);
        with_skewed_cells(has_skewed_cells: bool);
        with_queue_families(queue_families: &'a [u32]);
        with_results(results: &'a [HostImage]);
        with_points(points: &'a [Points]);
        with_sources(sources: &'a [SourceBuffer]);
        with_lookups(lookups: &'a [Lookup]);
    }

    /// Returns each queue family once.
    fn families(&self) -> Vec<u32> {
        let mut families = self.queue_families.to_vec();
        families.sort_unstable();
        families.dedup();
        families
    }

    /// Returns the gluing of the grid, after checking that all points allow it.
    fn glued(&self) -> Result<Option<Glued>, VulkanError> {
        let Some(gluing) = self.gluing else { return Ok(None) };
        if self.has_skewed_cells {
            let what = "the search for points far away in skewed cells";
            return Err(
                SurfaceError::from(GluingError::Unsupported { what, instead: UNGLUED }).into()
            );
        }
        self.points.iter().try_for_each(|points| check_kind(gluing, points.kind))?;
        Ok(Some(Glued::of_grid(self.chart, gluing).map_err(SurfaceError::from)?))
    }

    /// Checks the parameters, and returns the values that follow from them.
    fn wanted<'f>(&self, solver: &Solver, families: &'f [u32]) -> Result<Wanted<'f>, VulkanError> {
        self.check()?;
        let size = (self.chart, solver.limits.texels(self.chart)?);
        let glued = self.glued()?;
        let lattice = glued.as_ref().map(Glued::lattice).unwrap_or_default();
        let slowed = self.points.iter().any(|points| points.slowness.is_some());
        let slots = self.slots.max(1);
        let results = if self.results.is_empty() { slots } else { 0 };
        Ok((
            size,
            Purpose { slowed, slots: Some(slots), results, families, lattice, owner: "" },
            glued,
        ))
    }

    fn check(&self) -> Result<(), VulkanError> {
        let Chart { rows, cols } = self.chart;
        if rows == 0 || cols == 0 {
            return Err(SurfaceError::Empty { rows, cols }.into());
        }
        let (given, slots) = (self.results.len(), self.slots.max(1));
        if given != 0 && given != slots {
            let reason = format!("{given} results are given for {slots} slots");
            return Err(VulkanError::HostBuffer { what: "distances", reason });
        }
        self.results.iter().try_for_each(|image| image.check("distances"))
    }
}

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

/// Returns an error if points of a kind do not allow a gluing.
pub(super) fn check_kind(gluing: &Gluing, kind: PointKind) -> Result<(), VulkanError> {
    let is_in_space = matches!(kind, PointKind::Positions);
    let checked = gluing.check_geometry(kind.has_positions(), is_in_space);
    Ok(checked.map_err(SurfaceError::from)?)
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

/// Outcome of the iterations of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Number of iterations, or of rounds of tiles, since the start of the map.
    pub iterations: u32,
    /// Largest relative change of a front in the last iteration.
    pub residual: f64,
    /// Number of visits since the start of the map, each by one workgroup: to a tile, or to the part of a block
    /// of lines that a workgroup updates. A smaller radius takes fewer visits.
    pub visits: u32,
    /// Whether the map has converged, over edges that were measured. If it has not,
    /// [`super::Recording::resume`] continues it.
    pub converged: bool,
    /// Whether the surface's edges have been measured on the device. They have not if the recording that
    /// measures them has never run.
    pub measured: bool,
    /// Number of grid points that are holes. A point is a hole if one of its values is not finite or too
    /// large, if it lies outside an image that is too small, or if its slowness is negative.
    pub holes: u32,
    /// Number of edges without a length between points that are not holes. The measured length of such an
    /// edge is 0, as between points at the same place, or too large. A pole or a seam has a number of such
    /// edges, which the host knows. A larger number means that vertices were zeroed or not written yet.
    pub edges_without_length: u32,
    /// Number of the map's sources that reach no point: those off the grid, in holes, or with a time that is
    /// NaN or not below 1e30. Unused entries of a buffer count.
    pub passed_over: u32,
    /// Largest gap between copies of a point of a glued surface, relative to the longest edge at these copies; 0 if the
    /// surface is not glued. It is rounded down by up to a sixteenth. A gap above a twentieth usually means that
    /// other sides are glued than those that coincide, or that one side runs in the reverse order. For a metric it
    /// is the difference between entries, relative to the larger diagonal entry.
    pub seam_gap: f64,
    /// Resolution of the surface by the grid, for the points that were measured last.
    /// [`crate::Surface::resolution`] is the same on the CPU. It is `None` for a metric, or if the grid is too
    /// small to tell.
    pub resolution: Option<Resolution>,
    /// Place whose cells are skewed most, of some thousands that were looked at, if that is too much for updates: then
    /// fronts may be late around it. [`SurfaceInfo::has_skewed_cells`] lets updates look farther. If that is set already,
    /// the grid has to follow the direction in which lengths are short. [`crate::Surface::unresolved`] is the same on the
    /// CPU.
    pub unresolved: Option<Unresolved>,
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
        let outcome = self.outcome_in(record);
        if self.checks && outcome.seam_gap > LARGEST_GAP {
            return Err(VulkanError::SeamGap {
                gap: outcome.seam_gap,
                place: record.seam_gap().1.and_then(|group| self.first_copy(group)),
            });
        }
        Ok(outcome)
    }

    fn outcome_in(&self, record: &Record) -> Outcome {
        let seen = if self.has_skewed_cells { FARTHEST_SPLIT } else { SPLIT_REACH };
        let outcome = Outcome::of(record);
        // Before a measurement, the word holds no skew.
        let found = if outcome.measured { record.skew } else { 0 };
        let unresolved = Unresolved::found_by_device(self.grid.chart, found, seen as usize);
        Outcome { unresolved, ..outcome }
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

impl Outcome {
    /// Size in bytes of the record that [`super::Recording::outcome_to`] copies.
    pub const BYTES: usize = offset::SERIAL_IN_RECORD as usize;

    fn of(record: &Record) -> Self {
        let Record { outcome, holes, no_length, passed_over, .. } = *record;
        let Record { sharp, compared, continued, turns, .. } = *record;
        let measured = holes != NEVER_MEASURED;
        let resolution = Resolution::counted(sharp, compared, continued, turns);
        Self {
            iterations: outcome.iterations,
            residual: outcome.residual(),
            visits: outcome.visited,
            converged: outcome.has_converged() && measured,
            measured,
            holes: if measured { holes } else { 0 },
            edges_without_length: if measured { no_length } else { 0 },
            passed_over,
            seam_gap: if measured { record.seam_gap().0.into() } else { 0.0 },
            resolution: resolution.filter(|_| measured),
            unresolved: None,
        }
    }
}
