//! A surface in a renderer: its images, and the host's memory that it reads.

use crate::vulkan::device_memory::DeviceMemory;
use std::sync::Arc;

use ash::vk;

use super::flight::Flight;
use super::host_sets::HostSets;
use super::inputs::{Lookup, Points, SourceBuffer};
use super::outputs::HostImage;
use super::recording::nth;
use super::solver::Solver;
use super::state::State;
use crate::constants::{BORDER, NEVER_MEASURED, SOURCES_TOGETHER, TIME};
use crate::surface::{Chart, EdgeRule, Resolution, SurfaceError};
use crate::vulkan::VulkanError;
use crate::vulkan::grid_images::{
    GridImages, INLINE_SOURCES, POINT_BYTES, Purpose, bands, frame_bytes,
};
use crate::vulkan::memory::{FORMAT, RESULT_FORMAT};
use crate::vulkan::progress::{Record, offset};

/// What a surface is made for. The host's images and buffers stay the host's: they must be alive
/// whenever a recording that reads them runs, and their contents may change from frame to frame.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInfo<'a> {
    /// Size of the grid.
    pub chart: Chart,
    /// How edges are measured.
    pub edge_rule: EdgeRule,
    /// How many frames are in flight: so many images of distances, and records of how iterations
    /// went, are there to be written in turn. At least 1.
    pub slots: usize,
    /// Queue families that use the images of distances and the packed times: ours and those of the
    /// readers, which may be the same. If they differ, no ownership needs to be transferred between
    /// them; if this is empty, it does.
    pub queue_families: &'a [u32],
    /// Images of the host's for the distances, one a slot; none for images that the surface makes. See
    /// [`HostImage`].
    pub results: &'a [HostImage],
    /// Where points may come from, by number: one for each frame in flight, say. If any has a slowness, the surface takes
    /// 4 bytes a point more, pipelines are made for it of all schedules and wavefronts that the solver has then, and
    /// planar fronts take the place of circular ones.
    pub points: &'a [Points],
    /// Buffers that sources may come from, by number.
    pub sources: &'a [SourceBuffer],
    /// Buffers for lookups, by number.
    pub lookups: &'a [Lookup],
}

impl SurfaceInfo<'_> {
    /// A grid with one slot, and none of the host's memory.
    pub fn new(chart: Chart) -> Self {
        Self {
            chart,
            edge_rule: EdgeRule::default(),
            slots: 1,
            queue_families: &[],
            results: &[],
            points: &[],
            sources: &[],
            lookups: &[],
        }
    }

    /// Each queue family once.
    fn families(&self) -> Vec<u32> {
        let mut families = self.queue_families.to_vec();
        families.sort_unstable();
        families.dedup();
        families
    }

    fn purpose<'a>(&self, families: &'a [u32]) -> Purpose<'a> {
        let slowed = self.points.iter().any(|points| points.slowness.is_some());
        let slots = self.slots.max(1);
        let results = if self.results.is_empty() { slots } else { 0 };
        Purpose::Embedded { slots, results, families, slowed }
    }

    fn check(&self) -> Result<(), VulkanError> {
        let Chart { rows, cols } = self.chart;
        if rows == 0 || cols == 0 {
            return Err(SurfaceError::Empty { rows, cols }.into());
        }
        let (given, slots) = (self.results.len(), self.slots.max(1));
        if given != 0 && given != slots {
            let reason = format!("there are {given} of them for {slots} slots");
            return Err(VulkanError::HostBuffer { what: "distances", reason });
        }
        self.results.iter().try_for_each(HostImage::check)
    }
}

/// A surface on the host's device: edge lengths, curvature and fronts, which all recordings share,
/// and an image of distances for each slot.
///
/// Dropping it frees nothing: the host calls [`Surface::destroy`], once no submitted work uses it.
#[derive(Debug)]
pub struct Surface {
    pub(super) grid: GridImages,
    pub(super) sets: HostSets,
    /// Images of the host's for distances, if the surface has none of its own.
    pub(super) results: Vec<HostImage>,
    pub(super) points: Vec<Points>,
    pub(super) sources: Vec<SourceBuffer>,
    pub(super) lookup_counts: Vec<u32>,
    pub(super) state: State,
    pub(super) flight: Arc<Flight>,
    pub(super) edge_rule: EdgeRule,
}

/// An image that holds distances: the surface's, made with usage `SAMPLED`, `STORAGE` and `TRANSFER_SRC`, or the
/// host's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResultImage {
    /// The image.
    pub image: vk::Image,
    /// A view of all of it.
    pub view: vk::ImageView,
    /// R32_SFLOAT, which all devices sample but some without filtering; or R32G32B32A32_SFLOAT.
    pub format: vk::Format,
    /// Width and height in texels.
    pub extent: vk::Extent2D,
    /// The layout that it has after the recording.
    pub layout: vk::ImageLayout,
}

/// The arrival times as the passes keep them: 2 x 2 grid points a texel, in a border of texels
/// that are never reached. Not for filtering.
///
/// The point at row r and column c is component 2 (r mod 2) + c mod 2 of texel
/// (c / 2 + border, r / 2 + border), in layer `layer`. What is not reached is 1e30 or more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PackedTimes {
    /// The image, always in the layout `GENERAL`. The view is an array; other layers are not times.
    pub image: ResultImage,
    /// Of the view.
    pub layer: u32,
    /// Texels around the grid's.
    pub border: u32,
}

/// How the iterations of a recording went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Iterations since the start of the map, or rounds of tiles.
    pub iterations: u32,
    /// Largest relative change of a front in the last of them.
    pub residual: f64,
    /// Whether the map has converged, over edges that were measured. If it has not, it takes
    /// [`super::Recording::resume`].
    pub converged: bool,
    /// Whether the surface's edges have been measured on the device: not if the recording that measures them
    /// has never run.
    pub measured: bool,
    /// How many grid points are holes: those with something that is not finite, too large, beyond an image
    /// that is too small, or a slowness that is negative.
    pub holes: u32,
    /// How many edges between points that can be used have no length: 0, as between points at one place, or
    /// more than fits a number. A pole or a seam has its own, of which the host knows; more of them are vertices
    /// that were zeroed, or not written yet.
    pub edges_without_length: u32,
    /// How many of the map's sources reach no point: those off the grid, in holes, or with a time that is no
    /// number below 1e30. Unused entries of a buffer count.
    pub passed_over: u32,
    /// How well the grid resolves the surface, by the points measured last, as
    /// [`crate::Surface::resolution`] tells of others: `None` of a metric, or if the grid is too small to tell.
    pub resolution: Option<Resolution>,
}

impl Surface {
    pub(super) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        solver: &Solver,
        info: &SurfaceInfo,
    ) -> Result<Self, VulkanError> {
        info.check()?;
        let size = (info.chart, solver.limits.texels(info.chart)?);
        let (pipelines, families) = (&solver.pipelines, info.families());
        let purpose = info.purpose(&families);
        if let Purpose::Embedded { slowed: true, .. } = purpose {
            solver.make_passes_with_slowness(device)?;
        }
        let mut grid = GridImages::new(device, allocator, pipelines, size, purpose)?;
        let host = (info.results, info.points, info.sources, info.lookups);
        match HostSets::new(device, pipelines, &solver.limits, &grid, host) {
            Ok(sets) => Ok(Self {
                sets,
                results: info.results.to_vec(),
                points: info.points.to_vec(),
                sources: info.sources.to_vec(),
                lookup_counts: info.lookups.iter().map(|lookup| lookup.count).collect(),
                edge_rule: info.edge_rule,
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
        info.check()?;
        let size = (info.chart, solver.limits.texels(info.chart)?);
        let families = info.families();
        let purpose = info.purpose(&families);
        GridImages::bytes_for(device, solver.pipelines.tuning, size, purpose)
    }

    /// The grid's size.
    pub fn chart(&self) -> Chart {
        self.grid.chart
    }

    /// Bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        self.grid.bytes()
    }

    /// How many images of distances there are.
    pub fn slots(&self) -> usize {
        self.grid.slots
    }

    /// The image of distances of a slot, one texel a grid point: column to the right, row down.
    /// `layout` is that of the [`super::Reader`] it was last recorded for.
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

    /// The packed arrival times that all slots share: valid after a recording until the next one.
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

    /// How the iterations of the last recording for a slot went. To be called after the fence of
    /// its submission.
    ///
    /// # Errors
    /// If there is no such slot, or its last recording has not run: then [`VulkanError::NotRun`]. Of a
    /// command buffer that is submitted again and again, the last run that has ended counts.
    /// [`VulkanError::PreparationLost`] if [`super::Recording::prepare`] has not run before it.
    pub fn outcome(&self, slot: usize) -> Result<Outcome, VulkanError> {
        self.check_slot(slot)?;
        let record = self.grid.record(slot);
        if !self.state.has_run(slot, record.serial) {
            return Err(VulkanError::NotRun { slot });
        }
        match self.state.was_prepared_by(slot, record.prepared) {
            true => Ok(Outcome::of(&record)),
            false => Err(VulkanError::PreparationLost),
        }
    }

    /// How the iterations went, from what [`super::Recording::outcome_to`] has copied.
    ///
    /// # Errors
    /// [`VulkanError::PreparationLost`] if [`super::Recording::prepare`] of this surface, as it was recorded last,
    /// has not run before it; so it is of bytes that are no outcome's, or another surface's.
    pub fn outcome_from(&self, bytes: &[u8; Outcome::BYTES]) -> Result<Outcome, VulkanError> {
        let mut record = [0; size_of::<Record>()];
        record[..Outcome::BYTES].copy_from_slice(bytes);
        let record: Record = bytemuck::pod_read_unaligned(&record);
        match self.state.is_prepared_by(record.prepared) {
            true => Ok(Outcome::of(&record)),
            false => Err(VulkanError::PreparationLost),
        }
    }

    /// A slot of which the last recording has not run, if there is one: nothing that it uses may be destroyed
    /// yet, unless it was never submitted.
    pub fn in_flight(&self) -> Option<usize> {
        (0..self.slots()).find(|&slot| self.state.is_in_flight(slot, self.grid.record(slot).serial))
    }

    /// Whether something that was recorded may not have run, as far as recordings are followed: those with an
    /// outcome, and with [`super::Tools::checks`] all.
    pub fn is_in_flight(&self) -> bool {
        self.flight.waiting().is_some()
    }

    /// Whether a recording that reads the surface's points with this number may not have run, as far as
    /// recordings are followed.
    ///
    /// # Errors
    /// If there are no such points.
    pub fn points_in_flight(&self, number: usize) -> Result<bool, VulkanError> {
        Ok(nth(&self.sets.points, "point inputs", number)?.is_in_flight(&self.flight))
    }

    /// Says that the last recording for a slot was thrown away and will never run: it is not waited for.
    ///
    /// # Errors
    /// If there is no such slot.
    pub fn discard(&self, slot: usize) -> Result<(), VulkanError> {
        self.check_slot(slot)?;
        self.state.discard(slot);
        self.flight.discard_slot(slot);
        Ok(())
    }

    /// The same of all that was recorded last into a command buffer, for a slot or not.
    pub fn discard_commands(&self, commands: vk::CommandBuffer) {
        self.state.discard_commands(commands);
        self.flight.discard_commands(commands);
    }

    /// Most passes of a frame beside those of its plan.
    pub(super) fn passes_around(&self) -> u32 {
        let chart = self.grid.chart;
        let measured = 2 * bands(chart, POINT_BYTES, frame_bytes(chart)).count() as u32 + 2;
        let inline = INLINE_SOURCES as u32;
        let sources = self.sources.iter().map(|sources| sources.count).max();
        let sources = sources.unwrap_or(0).max(inline);
        // Sources are taken, found and set in portions, and their surroundings solved, merged and set; the rest is
        // forgotten, started, copied and unpacked.
        measured + 1 + 2 * sources.div_ceil(SOURCES_TOGETHER) + 3 + 4
    }

    pub(super) fn check_slot(&self, slot: usize) -> Result<(), VulkanError> {
        self.result(slot, vk::ImageLayout::UNDEFINED).map(drop)
    }

    /// Frees everything, with the device and the allocator that it was made with. No submitted work
    /// may still use the surface: in a renderer, wait for the fences of the frames in flight, or put
    /// it on the list of what is freed so many frames later. A second call does nothing.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        self.state.destroy();
        self.flight.land();
        self.sets.destroy(device);
        self.grid.destroy(device, allocator);
    }
}

impl Solver {
    /// Bytes that a surface takes from the allocator's memory blocks on this device, before it is
    /// made.
    pub fn bytes_for(&self, device: &ash::Device, info: &SurfaceInfo) -> Result<u64, VulkanError> {
        Surface::bytes_for(device, self, info)
    }

    /// Makes a surface: the one call that allocates.
    ///
    /// # Errors
    /// If the grid is too large for the device, memory runs out, or a buffer of the host's cannot
    /// be used as described. Nothing is left behind then.
    pub fn surface(
        &self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        info: &SurfaceInfo,
    ) -> Result<Surface, VulkanError> {
        Surface::new(device, allocator, self, info)
    }
}

impl Outcome {
    /// Bytes of the record that [`super::Recording::outcome_to`] copies.
    pub const BYTES: usize = offset::SERIAL_IN_RECORD as usize;

    fn of(record: &Record) -> Self {
        let Record { outcome, holes, no_length, passed_over, .. } = *record;
        let Record { sharp, compared, continued, turns, .. } = *record;
        let measured = holes != NEVER_MEASURED;
        let resolution = Resolution::counted(sharp, compared, continued, turns);
        Self {
            iterations: outcome.iterations,
            residual: outcome.residual(),
            converged: outcome.has_converged() && measured,
            measured,
            holes: if measured { holes } else { 0 },
            edges_without_length: if measured { no_length } else { 0 },
            passed_over,
            resolution: resolution.filter(|_| measured),
        }
    }
}
