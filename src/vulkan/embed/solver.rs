//! Creates the pipelines of a device, which all its surfaces share.

use std::sync::atomic::{AtomicU16, Ordering};

use ash::{khr, vk};

use super::plan::Plan;
use crate::surface::Chart;
use crate::update::{Setting, Wavefront};
use crate::vulkan::device::labels::Labels;
use crate::vulkan::device::limits::Limits;
use crate::vulkan::device::passes::{
    COMMON, EXCHANGE, GLUED_POINTS_FROM_BUFFER, GLUED_POINTS_FROM_IMAGE, SHARE_CURVATURE,
    SURROUNDINGS, Splits, Variant,
};
use crate::vulkan::device::pipelines::{Cache, Pipeline, Pipelines};
use crate::vulkan::device::requirements;
use crate::vulkan::device::shaders::surroundings;
use crate::vulkan::device::tile_lanes;
use crate::vulkan::profile;
use crate::vulkan::{Method, Schedule, Tuning, VulkanError};

/// Pipelines of a device of the host. Each pipeline is created once and serves all surfaces. The pipelines of
/// contours, paths, regions, directions and log maps are created with the first object of each kind.
///
/// A solver holds no reference to the device: the host passes the device to each method. The host keeps the
/// device alive until it has called [`Solver::destroy`].
#[derive(Debug)]
pub struct Solver {
    pub(crate) pipelines: Pipelines,
    pub(crate) limits: Limits,
    /// See [`Tools::checks`].
    pub(super) checks: bool,
    /// Bit mask of the pipeline sets that exist, by their numbers.
    pipeline_sets: AtomicU16,
}

/// Properties of a surface on which its pipelines depend.
#[derive(Clone, Copy, Debug)]
pub(super) struct PipelineSet {
    /// Whether the surface has a slowness.
    pub(super) slowed: bool,
    /// Whether its grid is small, and has smaller tiles than other grids.
    pub(super) small_tiles: bool,
    /// Whether sides of its grid are glued.
    pub(super) glued: bool,
    /// Whether its cells may be skewed ([`super::SurfaceInfo::has_skewed_cells`]).
    pub(super) skewed: bool,
}

impl PipelineSet {
    /// Returns all sets, in the order of their numbers.
    fn all() -> impl Iterator<Item = Self> {
        (0..16).map(|number| {
            let [slowed, small_tiles, glued, skewed] = [1, 2, 4, 8].map(|bit| number & bit != 0);
            Self { slowed, small_tiles, glued, skewed }
        })
    }

    fn bit(self) -> u16 {
        let Self { slowed, small_tiles, glued, skewed } = self;
        let bits = [slowed, small_tiles, glued, skewed].map(u16::from);
        1 << bits.into_iter().rev().fold(0, |number, bit| 2 * number + bit)
    }

    /// Returns the passes of maps of surfaces with these properties.
    fn passes(
        self,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> impl Iterator<Item = (usize, Variant)> {
        let exchange = self.glued.then(|| (EXCHANGE.number(), wavefront.into()));
        let all = passes_of(schedule, wavefront, self.slowed).chain(exchange);
        all.map(move |(pass, variant)| (pass, self.variant(variant)))
    }

    /// Returns the variant of pipelines for surfaces with these properties.
    pub(super) fn variant(self, of: Variant) -> Variant {
        let splits = if self.skewed { Splits::Far } else { of.splits };
        Variant { slowed: self.slowed, small_tiles: self.small_tiles, splits, ..of }
    }
}

/// Features for tools that the host has enabled on its instance and device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tools {
    /// Use `VK_EXT_debug_utils`: passes get labels, and images, buffers and pipelines get names.
    pub labels: bool,
    /// Use `VK_KHR_pipeline_executable_properties` with the feature `pipelineExecutableInfo`:
    /// [`Solver::executables`] returns the driver's statistics of the pipelines.
    pub executables: bool,
    /// Check recordings for mistakes that can only be found by reading mapped memory. This is for development.
    /// With several slots, it is then an error to record a slot whose last recording has not run. A recording
    /// that was discarded also counts as not run, unless its command buffer is recorded anew or
    /// [`super::FrameSurface::discard`] is called. Recordings without an outcome are tracked too
    /// ([`super::FrameSurface::is_in_flight`]), at the cost of one fill and two barriers each. A barrier then
    /// separates raster scans that go in a pair ([`crate::vulkan::Tuning::scan_pairs`]). Without it,
    /// synchronization validation may report a hazard between the two.
    pub checks: bool,
}

impl Solver {
    /// Creates a solver with the pipelines for the given schedules and wavefronts. [`Solver::add_passes`] can
    /// add others later. The call takes long and may run on a thread of its own.
    ///
    /// A solver cannot know whether a surface on the device is a floor plan. [`Wavefront::Anchored`]
    /// therefore means [`Wavefront::Curved`], here and in all other methods.
    ///
    /// # Errors
    /// [`VulkanError::Unusable`] with everything that the device lacks, or if a Vulkan call fails.
    pub fn new(
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: &ash::Device,
        passes: &[(Schedule, Wavefront)],
    ) -> Result<Self, VulkanError> {
        Self::with_tools(instance, physical_device, device, passes, Tools::default())
    }

    /// Creates a solver as [`Solver::new`] does, with features for tools.
    ///
    /// # Errors
    /// As for [`Solver::new`].
    pub fn with_tools(
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: &ash::Device,
        passes: &[(Schedule, Wavefront)],
        tools: Tools,
    ) -> Result<Self, VulkanError> {
        let cache = vk::PipelineCache::null();
        Self::with_cache(instance, physical_device, device, passes, tools, cache)
    }

    /// Creates a solver as [`Solver::with_tools`] does, with a pipeline cache of the host. See
    /// [`Solver::set_pipeline_cache`] for how the cache is used.
    ///
    /// # Errors
    /// As for [`Solver::new`].
    pub fn with_cache(
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: &ash::Device,
        passes: &[(Schedule, Wavefront)],
        tools: Tools,
        cache: vk::PipelineCache,
    ) -> Result<Self, VulkanError> {
        let cache = Cache::of_host(cache);
        Self::made_with(instance, physical_device, device, passes, tools, cache)
    }

    pub(crate) fn made_with(
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: &ash::Device,
        passes: &[(Schedule, Wavefront)],
        tools: Tools,
        cache: Cache,
    ) -> Result<Self, VulkanError> {
        // SAFETY: the physical device is from this instance.
        let properties = unsafe { instance.get_physical_device_properties(physical_device) };
        let mut unmet = requirements::unmet(instance, physical_device);
        if requirements::is_for_vulkan_1_0(instance, device) {
            unmet.push(requirements::FOR_VULKAN_1_0.into());
        }
        if !unmet.is_empty() {
            let name = properties.device_name_as_c_str().unwrap_or(c"unnamed");
            let device = name.to_string_lossy().into_owned();
            return Err(VulkanError::Unusable { device, unmet: unmet.join("; ") });
        }
        let labels = tools.labels.then(|| Labels::new(instance, device));
        let tuning = Tuning::of(instance, physical_device);
        let limits = Limits::of(instance, physical_device);
        let on_processor = limits.kind == vk::PhysicalDeviceType::CPU;
        let mut pipelines =
            Pipelines::new(device, (tuning, on_processor), labels, tools.executables)?;
        pipelines.separates_pairs = tools.checks;
        pipelines.set_cache(cache);
        let pipeline_sets = AtomicU16::new(0);
        let mut new = Self { pipelines, limits, checks: tools.checks, pipeline_sets };
        match new.make_first(device, passes) {
            Ok(()) => Ok(new),
            Err(error) => {
                new.destroy(device);
                Err(error)
            }
        }
    }

    /// Makes the common pipelines, and those for the given schedules and wavefronts. One call creates all of
    /// them, so that several threads can share the work.
    fn make_first(
        &self,
        device: &ash::Device,
        passes: &[(Schedule, Wavefront)],
    ) -> Result<(), VulkanError> {
        let mut wanted: Vec<_> =
            COMMON.iter().map(|&pass| (pass, Wavefront::Planar.into())).collect();
        for &(schedule, wavefront) in passes {
            wanted.extend(passes_of(schedule, over_any(wavefront), false));
        }
        self.pipelines.make_each(device, &wanted)
    }

    /// Returns the sizes of the portions in which the solver visits the grid.
    pub fn tuning(&self) -> Tuning {
        self.pipelines.tuning
    }

    /// Sets other sizes of portions than those that [`Tuning::of`] returns for the device, and makes the
    /// pipelines of the solver's schedules and wavefronts anew. Call it before the solver makes a surface:
    /// surfaces and plans that were made before can no longer be used.
    ///
    /// # Errors
    /// [`VulkanError::Tuning`] if the device has no room for these sizes, or the error of a Vulkan call that
    /// fails. After the latter the solver can only be destroyed.
    pub fn set_tuning(
        &mut self,
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: &ash::Device,
        tuning: Tuning,
    ) -> Result<(), VulkanError> {
        let passes: Vec<_> = self.all_passes().collect();
        self.start_with(instance, physical_device, device, tuning, &passes)
    }

    /// Sets the sizes of portions, and makes the pipelines for the given schedules and wavefronts.
    pub(crate) fn start_with(
        &mut self,
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: &ash::Device,
        tuning: Tuning,
        passes: &[(Schedule, Wavefront)],
    ) -> Result<(), VulkanError> {
        // SAFETY: the physical device is from this instance.
        let properties = unsafe { instance.get_physical_device_properties(physical_device) };
        let shuffles = tile_lanes::shuffles(instance, physical_device);
        tuning.check(&properties.limits, shuffles)?;
        self.pipelines.set_tuning(device, tuning);
        self.pipeline_sets = AtomicU16::new(0);
        self.make_first(device, passes)
    }

    /// Sets the pipeline cache of the host with which pipelines are created from now on. A null handle means
    /// no cache.
    ///
    /// The cache belongs to the host, which fills it from a file, merges it, saves it and destroys it. It must
    /// be alive whenever this solver creates pipelines: in [`Solver::with_cache`], [`Solver::set_tuning`] and
    /// [`Solver::add_passes`], with the first surface that has a slowness, a small grid
    /// ([`Tuning::small_grid`]), skewed cells or glued sides, and with the first [`super::Contours`], [`super::Paths`],
    /// [`super::Regions`] (of each wavefront), [`super::Directions`] and [`super::LogMapImage`]. Pipelines do
    /// not need it once they are created. This solver uses the cache from one thread at a time. For other uses
    /// at the same time, the rules of `vkCreateComputePipelines` apply.
    pub fn set_pipeline_cache(&self, cache: vk::PipelineCache) {
        self.pipelines.set_cache(Cache::of_host(cache));
    }

    /// Creates the pipelines of one more schedule and wavefront, unless they exist.
    ///
    /// # Errors
    /// If a Vulkan call fails.
    pub fn add_passes(
        &mut self,
        device: &ash::Device,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> Result<(), VulkanError> {
        let mut wanted: Vec<_> = passes_of(schedule, over_any(wavefront), false).collect();
        let made = *self.pipeline_sets.get_mut();
        for set in PipelineSet::all().filter(|set| made & set.bit() != 0) {
            wanted.extend(set.passes(schedule, over_any(wavefront)));
        }
        self.pipelines.make_each(device, &wanted)
    }

    /// Returns the driver's statistics of the pipelines. The solver must have been made with
    /// [`Tools::executables`].
    ///
    /// # Errors
    /// If the driver fails.
    pub fn executables(
        &self,
        instance: &ash::Instance,
        device: &ash::Device,
    ) -> Result<Vec<profile::Executable>, VulkanError> {
        let loader = khr::pipeline_executable_properties::Device::new(instance, device);
        profile::executables(&loader, &self.pipelines.named().collect::<Vec<_>>())
    }

    /// Returns whether the pipelines of a schedule and a variant exist.
    pub(crate) fn has_passes(&self, schedule: Schedule, variant: impl Into<Variant>) -> bool {
        self.pipelines.have(schedule.passes(), variant.into())
    }

    /// Returns the pass that solves a source's surroundings, if maps gain by it. Maps can gain if sources lie
    /// inside cells, or if there are several sources.
    pub(super) fn surroundings(
        &self,
        schedule: Schedule,
        variant: Variant,
    ) -> Option<Pipeline<surroundings::Push>> {
        let made = self.pipelines.made(SURROUNDINGS, variant);
        made.filter(|_| have_surroundings(schedule, variant.wavefront, variant.slowed))
    }

    /// Creates the pipelines that surfaces with these properties need, for all present and future schedules and
    /// wavefronts of the solver.
    pub(super) fn make_passes_for(
        &self,
        device: &ash::Device,
        set: PipelineSet,
    ) -> Result<(), VulkanError> {
        self.pipeline_sets.fetch_or(set.bit(), Ordering::Relaxed);
        let mut wanted: Vec<_> = self
            .all_passes()
            .flat_map(|(schedule, wavefront)| set.passes(schedule, wavefront))
            .collect();
        if set.glued {
            wanted.extend(OF_GLUED.map(|pass| (pass, Wavefront::Curved.into())));
        }
        self.pipelines.make_each(device, &wanted)
    }

    /// Returns the schedules and wavefronts for which the solver has pipelines.
    pub(super) fn all_passes(&self) -> impl Iterator<Item = (Schedule, Wavefront)> {
        let of = |schedule| Wavefront::ALL.map(|wavefront| (schedule, wavefront));
        let all = Schedule::ALL.into_iter().flat_map(of);
        all.filter(|&(schedule, wavefront)| self.has_passes(schedule, wavefront))
    }

    /// Returns whether a wavefront of the solver needs the surface's Gaussian curvature.
    pub(super) fn is_curved(&self) -> bool {
        self.all_passes().any(|(_, wavefront)| wavefront.is_curved())
    }

    /// Returns the passes of a map on a grid of this size. A recording holds `iterations` iterations (or
    /// rounds of tiles), and no more than [`Method::stop`] allows in all. [`super::Recording::resume`]
    /// continues a map in further recordings.
    ///
    /// With tiles, a recording holds at most four rounds more than there are tiles along both sides of the grid
    /// together, limited to between 8 and 128: 10 at 48 x 48 points, 20 at 120 x 120, 36 at 256 x 256.
    /// [`Plan::iterations`] returns the number that the recording holds, and [`Plan::asked`] the number that
    /// was asked for.
    ///
    /// If the method names no schedule, the plan uses the schedule that [`Schedule::best_on`] returns for the
    /// device, if the solver was made for that schedule. Otherwise it uses another schedule of the solver.
    ///
    /// # Errors
    /// If the solver was not made for the method's schedule and wavefront, or the grid is too large.
    pub fn plan(&self, chart: Chart, method: Method, iterations: u32) -> Result<Plan, VulkanError> {
        let method = method.with_wavefront(over_any(method.wavefront));
        let best = Schedule::best_on(self.limits.kind, chart);
        let made = |schedule: &Schedule| self.has_passes(*schedule, method.wavefront);
        let or_else = || [best].into_iter().chain(Schedule::ALL).find(made).unwrap_or(best);
        let schedule = method.schedule.unwrap_or_else(or_else);
        if !made(&schedule) {
            return Err(VulkanError::NoPasses { schedule, wavefront: method.wavefront });
        }
        let texels = self.limits.texels(chart)?;
        let portions = self.pipelines.tuning.portions(method.wavefront, texels);
        Ok(Plan::new(portions, texels, schedule, method, iterations))
    }

    /// Destroys the pipelines. No submitted work may still use them. The solver cannot be used afterwards.
    pub fn destroy(&mut self, device: &ash::Device) {
        self.pipelines.destroy(device);
    }
}

/// Passes of glued surfaces for all wavefronts.
const OF_GLUED: [usize; 3] =
    [GLUED_POINTS_FROM_BUFFER.number(), GLUED_POINTS_FROM_IMAGE.number(), SHARE_CURVATURE.number()];

/// Returns the passes of a schedule and wavefront. If maps gain by it, the pass that solves the surroundings
/// of sources is among them. Headless solvers do without that pass, and start from `Wavefront::seeds`.
fn passes_of(
    schedule: Schedule,
    wavefront: Wavefront,
    slowed: bool,
) -> impl Iterator<Item = (usize, Variant)> {
    let around = have_surroundings(schedule, wavefront, slowed).then_some(SURROUNDINGS.number());
    let all = schedule.passes().iter().copied().chain(around);
    all.map(move |pass| (pass, wavefront.into()))
}

/// Returns whether maps gain if the surroundings of sources are solved first. Maps of sources between grid points then
/// take fewer iterations or are more accurate, or fronts of several sources are more accurate.
fn have_surroundings(schedule: Schedule, wavefront: Wavefront, slowed: bool) -> bool {
    wavefront.is_curved()
        || slowed
        || schedule.gains_by_surroundings() && wavefront != Wavefront::Planar
}

/// Returns the wavefront to use on a surface that may or may not be a floor plan.
pub(super) fn over_any(wavefront: Wavefront) -> Wavefront {
    wavefront.or_curved(Setting::of_device(false))
}
