//! The pipelines of a device, shared by all its surfaces.

use ash::{khr, vk};

use super::plan::Plan;
use crate::surface::Chart;
use crate::update::{Setting, Wavefront};
use crate::vulkan::limits::Limits;
use crate::vulkan::passes::{COMMON, SURROUNDINGS, Variant};
use crate::vulkan::pipelines::{Cache, Pipeline, Pipelines};
use crate::vulkan::profile::{self, Labels};
use crate::vulkan::shaders::surroundings;
use crate::vulkan::{Method, Schedule, Tuning, VulkanError, requirements};

/// The pipelines of a device of the host's: each is made once, those of contours, paths and regions when
/// the first of these are made, and serves all surfaces.
///
/// It keeps no reference to the device: the host passes it in, and calls [`Solver::destroy`] before
/// the device goes.
#[derive(Debug)]
pub struct Solver {
    pub(crate) pipelines: Pipelines,
    pub(crate) limits: Limits,
    /// See [`Tools::checks`].
    pub(super) checks: bool,
}

/// What the host has enabled on its instance and device for tools that look on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tools {
    /// `VK_EXT_debug_utils`: passes get labels, and images, buffers and pipelines names.
    pub labels: bool,
    /// `VK_KHR_pipeline_executable_properties` with the feature `pipelineExecutableInfo`: drivers
    /// tell what they have made of pipelines, by [`Solver::executables`].
    pub executables: bool,
    /// Recordings are checked for what costs a look at mapped memory: with several slots, a slot that is
    /// recorded while its last recording has not run is an error, and recordings without an outcome are followed
    /// too ([`super::Surface::is_in_flight`]), for which each gets a fill and two barriers more. While you develop;
    /// a recording that is thrown away counts, unless its command buffer is recorded anew.
    pub checks: bool,
}

impl Solver {
    /// Creates the pipelines for these schedules and wavefronts; others can be added later with
    /// [`Solver::add_passes`].
    ///
    /// No one knows here whether a surface of the host's is a floor plan: [`Wavefront::Anchored`] stands for
    /// [`Wavefront::Curved`], as in all that follows.
    ///
    /// # Errors
    /// [`VulkanError::Unusable`] with all that the device lacks, or a call of Vulkan's that fails.
    pub fn new(
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: &ash::Device,
        passes: &[(Schedule, Wavefront)],
    ) -> Result<Self, VulkanError> {
        Self::with_tools(instance, physical_device, device, passes, Tools::default())
    }

    /// The same, for tools that look on.
    ///
    /// # Errors
    /// As [`Solver::new`].
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

    /// The same, with a pipeline cache of the host's, which [`Solver::set_pipeline_cache`] says more of.
    ///
    /// # Errors
    /// As [`Solver::new`].
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
        let tuning = Tuning::of(&properties);
        let limits = Limits::of(instance, physical_device);
        let on_processor = limits.kind == vk::PhysicalDeviceType::CPU;
        let pipelines = Pipelines::new(device, (tuning, on_processor), labels, tools.executables)?;
        pipelines.set_cache(cache);
        let mut new = Self { pipelines, limits, checks: tools.checks };
        // All at once, for as many threads as there are.
        let mut wanted: Vec<_> =
            COMMON.iter().map(|&pass| (pass, Wavefront::Planar.into())).collect();
        for &(schedule, wavefront) in passes {
            wanted.extend(passes_of(schedule, over_any(wavefront)));
        }
        let made = new.pipelines.make_each(device, &wanted);
        match made {
            Ok(()) => Ok(new),
            Err(error) => {
                new.destroy(device);
                Err(error)
            }
        }
    }

    /// Has pipelines be made with a pipeline cache of the host's from now on; with none if it is null.
    ///
    /// The cache stays the host's, which fills it from a file, merges it, saves and destroys it. It
    /// has to be alive whenever this solver makes pipelines: in [`Solver::with_cache`],
    /// [`Solver::add_passes`], with the first surface that has a slowness, and where the first [`super::Contours`],
    /// [`super::Paths`] and [`super::Regions`] (of each wavefront) are made. Once they are made, no pipeline needs it. One thread at a time uses it in
    /// this solver; for other uses of it at the same time the rules of `vkCreateComputePipelines` hold.
    pub fn set_pipeline_cache(&self, cache: vk::PipelineCache) {
        self.pipelines.set_cache(Cache::of_host(cache));
    }

    /// Creates the pipelines of one more schedule and wavefront, unless they are there.
    ///
    /// # Errors
    /// If a call of Vulkan's fails.
    pub fn add_passes(
        &mut self,
        device: &ash::Device,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> Result<(), VulkanError> {
        let wanted: Vec<_> = passes_of(schedule, over_any(wavefront)).collect();
        self.pipelines.make_each(device, &wanted)
    }

    /// The same, where it is known whether fronts have anchors.
    pub(crate) fn make_passes(
        &mut self,
        device: &ash::Device,
        schedule: Schedule,
        variant: impl Into<Variant>,
    ) -> Result<(), VulkanError> {
        self.pipelines.make_all(device, schedule.passes(), variant)
    }

    /// What the driver has made of the pipelines; [`Tools::executables`] must be set.
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

    /// Whether the pipelines of a schedule and a variant are there.
    pub(crate) fn has_passes(&self, schedule: Schedule, variant: impl Into<Variant>) -> bool {
        self.pipelines.have(schedule.passes(), variant.into())
    }

    /// The pass that solves a source's surroundings, if maps gain by it: of sources inside cells, or of several.
    pub(super) fn surroundings(
        &self,
        schedule: Schedule,
        variant: Variant,
    ) -> Option<Pipeline<surroundings::Push>> {
        let made = self.pipelines.made(SURROUNDINGS, variant);
        made.filter(|_| have_surroundings(schedule, variant.wavefront))
    }

    /// Makes the pipelines of all schedules and wavefronts that it has for surfaces with a slowness too.
    pub(super) fn make_passes_with_slowness(
        &self,
        device: &ash::Device,
    ) -> Result<(), VulkanError> {
        let slowed = |(pass, variant)| (pass, Variant { slowed: true, ..variant });
        let all =
            self.all_passes().flat_map(|(schedule, wavefront)| passes_of(schedule, wavefront));
        self.pipelines.make_each(device, &all.map(slowed).collect::<Vec<_>>())
    }

    /// The schedules and wavefronts that it has pipelines for.
    pub(super) fn all_passes(&self) -> impl Iterator<Item = (Schedule, Wavefront)> {
        let of = |schedule| Wavefront::EVERY.map(|wavefront| (schedule, wavefront));
        let all = Schedule::ALL.into_iter().flat_map(of);
        all.filter(|&(schedule, wavefront)| self.has_passes(schedule, wavefront))
    }

    /// Whether some wavefront needs the surface's Gaussian curvature.
    pub(super) fn is_curved(&self) -> bool {
        self.all_passes().any(|(_, wavefront)| wavefront.is_curved())
    }

    /// The passes of a map on a grid of this size, with this many iterations (or rounds of tiles) a
    /// recording, and no more than [`Method::stop`] allows in all. Of tiles a recording holds as many rounds
    /// at most as there are tiles along both sides of the grid together, and 8 to 128: 8 at 48 x 48 points,
    /// 16 at 120 x 120, 32 at 256 x 256. [`Plan::iterations`] says how many it holds, of those
    /// [`Plan::asked`] for. More than one recording goes on where the last has left off:
    /// [`super::Recording::resume`]. Without a schedule it is [`Schedule::best_on`] the device if the solver
    /// was made for it, else another.
    ///
    /// # Errors
    /// If the solver was not made for the method's schedule and wavefront, or the grid is too large.
    pub fn plan(&self, chart: Chart, method: Method, iterations: u32) -> Result<Plan, VulkanError> {
        let method = Method { wavefront: over_any(method.wavefront), ..method };
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

    /// Destroys the pipelines. No submitted work may still use them; the solver is of no use
    /// afterwards.
    pub fn destroy(&mut self, device: &ash::Device) {
        self.pipelines.destroy(device);
    }
}

/// The passes of a schedule and wavefront, with that which solves surroundings of sources. Headless solvers, which do
/// without it, start from `Wavefront::seeds`.
fn passes_of(schedule: Schedule, wavefront: Wavefront) -> impl Iterator<Item = (usize, Variant)> {
    let around = have_surroundings(schedule, wavefront).then_some(SURROUNDINGS.number());
    let all = schedule.passes().iter().copied().chain(around);
    all.map(move |pass| (pass, wavefront.into()))
}

/// Whether maps from between grid points take fewer iterations if the surroundings of sources are solved
/// first, or fronts of several sources are more accurate.
fn have_surroundings(schedule: Schedule, wavefront: Wavefront) -> bool {
    wavefront.is_curved() || schedule.gains_by_surroundings() && wavefront != Wavefront::Planar
}

/// The wavefront over a surface of which it is not known whether it is a floor plan.
pub(super) fn over_any(wavefront: Wavefront) -> Wavefront {
    wavefront.or_curved(Setting::of_engine(false))
}
