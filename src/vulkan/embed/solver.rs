//! The pipelines of a device, shared by all its surfaces.

use ash::{khr, vk};
use gpu_allocator::vulkan::Allocator;

use super::contours::Contours;
use super::paths::{Paths, PathsInfo};
use super::plan::Plan;
use super::recording::Recording;
use super::regions::Regions;
use super::surface::{Surface, SurfaceInfo};
use crate::surface::Chart;
use crate::update::{Setting, Wavefront};
use crate::vulkan::limits::Limits;
use crate::vulkan::pipelines::{Pipelines, SchedulePipelines};
use crate::vulkan::profile::{self, Labels};
use crate::vulkan::{Method, Schedule, Tuning, VulkanError, requirements};

/// The pipelines of a device of the host's.
///
/// It keeps no reference to the device: the host passes it in, and calls [`Solver::destroy`] before
/// the device goes.
#[derive(Debug)]
pub struct Solver {
    pub(crate) pipelines: Pipelines,
    /// By schedule and wavefront.
    passes: [[Option<SchedulePipelines>; Wavefront::EVERY.len()]; Schedule::ALL.len()],
    /// The passes that solve the surroundings of sources, by wavefront, for raster scans.
    surroundings: [Option<vk::Pipeline>; Wavefront::EVERY.len()],
    pub(crate) limits: Limits,
}

/// What the host has enabled on its instance and device for tools that look on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tools {
    /// `VK_EXT_debug_utils`: passes get labels, and images, buffers and pipelines names.
    pub labels: bool,
    /// `VK_KHR_pipeline_executable_properties` with the feature `pipelineExecutableInfo`: drivers
    /// tell what they have made of pipelines, by [`Solver::executables`].
    pub executables: bool,
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
        // SAFETY: the physical device is from this instance.
        let properties = unsafe { instance.get_physical_device_properties(physical_device) };
        let unmet = requirements::unmet(instance, physical_device);
        if !unmet.is_empty() {
            let name = properties.device_name_as_c_str().unwrap_or(c"unnamed");
            let device = name.to_string_lossy().into_owned();
            return Err(VulkanError::Unusable { device, unmet: unmet.join("; ") });
        }
        let labels = tools.labels.then(|| Labels::new(instance, device));
        let tuning = Tuning::of(&properties);
        let pipelines = Pipelines::new(device, tuning, labels, tools.executables)?;
        let limits = Limits::of(instance, physical_device);
        let surroundings = Default::default();
        let mut new = Self { pipelines, passes: Default::default(), surroundings, limits };
        for &(schedule, wavefront) in passes {
            if let Err(error) = new.add_passes(device, schedule, wavefront) {
                new.destroy(device);
                return Err(error);
            }
        }
        Ok(new)
    }

    /// Creates the pipelines of one more schedule and wavefront, unless they are there.
    pub fn add_passes(
        &mut self,
        device: &ash::Device,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> Result<(), VulkanError> {
        let wavefront = over_any(wavefront);
        self.make_passes(device, schedule, wavefront)?;
        let surroundings = &mut self.surroundings[wavefront as usize];
        // Headless solvers, which do without this, start from `Wavefront::seeds`.
        if surroundings.is_none() && have_surroundings(schedule, wavefront) {
            let pipeline = self.pipelines.surroundings(device, wavefront)?;
            self.pipelines.name(&surroundings_name(wavefront), pipeline);
            *surroundings = Some(pipeline);
        }
        Ok(())
    }

    /// The same, where it is known whether fronts have anchors.
    pub(crate) fn make_passes(
        &mut self,
        device: &ash::Device,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> Result<(), VulkanError> {
        let passes = &mut self.passes[schedule as usize][wavefront as usize];
        if passes.is_none() {
            let new = SchedulePipelines::new(device, &self.pipelines, schedule, wavefront)?;
            for (name, pipeline) in new.named(schedule, wavefront) {
                self.pipelines.name(&name, pipeline);
            }
            *passes = Some(new);
        }
        Ok(())
    }

    /// Most records that [`Recording::frame`] makes for a surface, and [`Recording::resume`] with
    /// the same plan: room for so many in a [`profile::Profile`]. What else is recorded with them
    /// comes on top: [`Contours::passes`], [`Paths::passes`], [`Regions::passes`], and one for each
    /// lookup.
    pub fn passes_of_frame(&self, surface: &Surface, plan: &Plan, grain: profile::Grain) -> u32 {
        surface.passes_around() + plan.records(grain)
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
        let plain = self.pipelines.named().map(|(name, pipeline)| (name.to_owned(), pipeline));
        let mut all = Vec::new();
        for schedule in Schedule::ALL {
            for wavefront in Wavefront::EVERY {
                if let Some(passes) = self.passes(schedule, wavefront) {
                    all.extend(passes.named(schedule, wavefront));
                }
            }
        }
        for wavefront in Wavefront::EVERY {
            let pipeline = self.surroundings[wavefront as usize];
            all.extend(pipeline.map(|pipeline| (surroundings_name(wavefront), pipeline)));
        }
        all.extend(plain);
        profile::executables(&loader, &all)
    }

    pub(crate) fn passes(
        &self,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> Option<&SchedulePipelines> {
        self.passes[schedule as usize][wavefront as usize].as_ref()
    }

    /// The pass that solves a source's surroundings, if maps gain by it.
    pub(super) fn surroundings(
        &self,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> Option<vk::Pipeline> {
        self.surroundings[wavefront as usize].filter(|_| have_surroundings(schedule, wavefront))
    }

    pub(super) fn all_surroundings(&self) -> impl Iterator<Item = vk::Pipeline> {
        self.surroundings.iter().copied().flatten()
    }

    pub(super) fn all_passes(&self) -> impl Iterator<Item = &SchedulePipelines> {
        self.passes.iter().flatten().flatten()
    }

    /// Whether some wavefront needs the surface's Gaussian curvature.
    pub(super) fn is_curved(&self) -> bool {
        let mut curved = Wavefront::EVERY.into_iter().filter(|wavefront| wavefront.is_curved());
        curved.any(|which| self.passes.iter().any(|of| of[which as usize].is_some()))
    }

    /// The passes of a map on a grid of this size, with this many iterations (or rounds of tiles) a
    /// recording: at most 128 for tiles, and no more than [`Method::stop`] allows in all. More
    /// than one recording goes on where the last has left off: [`Recording::resume`]. Without a
    /// schedule it is [`Schedule::best_on`] the device if the solver was made for it, else another.
    ///
    /// # Errors
    /// If the solver was not made for the method's schedule and wavefront, or the grid is too large.
    pub fn plan(&self, chart: Chart, method: Method, iterations: u32) -> Result<Plan, VulkanError> {
        let method = Method { wavefront: over_any(method.wavefront), ..method };
        let best = Schedule::best_on(self.limits.kind, chart);
        let made = |schedule: &Schedule| self.passes(*schedule, method.wavefront).is_some();
        let or_else = || [best].into_iter().chain(Schedule::ALL).find(made).unwrap_or(best);
        let schedule = method.schedule.unwrap_or_else(or_else);
        if !made(&schedule) {
            return Err(VulkanError::NoPasses { schedule, wavefront: method.wavefront });
        }
        let texels = self.limits.texels(chart)?;
        let portions = self.pipelines.tuning.portions(method.wavefront, texels);
        Ok(Plan::new(portions, texels, schedule, method, iterations))
    }

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
        allocator: &mut Allocator,
        info: &SurfaceInfo,
    ) -> Result<Surface, VulkanError> {
        Surface::new(device, allocator, self, info)
    }

    /// Bytes that contours take from the allocator's memory blocks on this device, before they are
    /// made.
    ///
    /// # Errors
    /// As [`Solver::contours`].
    pub fn bytes_for_contours(
        &self,
        device: &ash::Device,
        chart: Chart,
        vertices: u32,
    ) -> Result<u64, VulkanError> {
        Contours::bytes_for(device, &self.limits, chart, vertices)
    }

    /// Makes room for contours of a surface, of so many vertices, two for each of their segments:
    /// 24 bytes a vertex and 260 a row of the grid. The one call that allocates for contours, and
    /// creates their pipelines.
    ///
    /// # Errors
    /// If there is no room for a segment, more than shaders see in one buffer, or memory runs out.
    /// Nothing is left behind then.
    pub fn contours(
        &self,
        device: &ash::Device,
        allocator: &mut Allocator,
        surface: &Surface,
        vertices: u32,
    ) -> Result<Contours, VulkanError> {
        Contours::new(device, allocator, (self, surface), vertices)
    }

    /// Bytes that paths take from the allocator's memory blocks on this device, before they are
    /// made.
    ///
    /// # Errors
    /// As [`Solver::paths`].
    pub fn bytes_for_paths(
        &self,
        device: &ash::Device,
        info: PathsInfo,
    ) -> Result<u64, VulkanError> {
        Paths::bytes_for(device, &self.limits, info)
    }

    /// Makes room for paths on a surface: 24 bytes a vertex and 104 a path. The one call that
    /// allocates for paths, and creates their pipelines.
    ///
    /// # Errors
    /// If there is no room for a path, more than shaders see in one buffer, or memory runs out.
    /// Nothing is left behind then.
    pub fn paths(
        &self,
        device: &ash::Device,
        allocator: &mut Allocator,
        surface: &Surface,
        info: PathsInfo,
    ) -> Result<Paths, VulkanError> {
        Paths::new(device, allocator, (self, surface), info)
    }

    /// Bytes that regions take from the allocator's memory blocks on this device, before they are
    /// made.
    ///
    /// # Errors
    /// As [`Solver::regions`].
    pub fn bytes_for_regions(
        &self,
        device: &ash::Device,
        chart: Chart,
    ) -> Result<u64, VulkanError> {
        Regions::bytes_for(device, &self.limits, chart)
    }

    /// Makes room for the regions of maps of a surface with one wavefront: 24 bytes a grid point. The
    /// one call that allocates for regions, and creates their pipelines.
    ///
    /// # Errors
    /// If shaders do not see so much in one buffer, or memory runs out. Nothing is left behind then.
    pub fn regions(
        &self,
        device: &ash::Device,
        allocator: &mut Allocator,
        surface: &Surface,
        wavefront: Wavefront,
    ) -> Result<Regions, VulkanError> {
        Regions::new(device, allocator, (self, surface), over_any(wavefront))
    }

    /// Records for a surface into a command buffer that the host has begun, on a queue family for
    /// compute and outside a render pass. Costs nothing by itself.
    pub fn record<'a>(
        &'a self,
        device: &'a ash::Device,
        commands: vk::CommandBuffer,
        surface: &'a Surface,
    ) -> Recording<'a> {
        Recording::new(device, commands, self, surface)
    }

    /// Destroys the pipelines. No submitted work may still use them; the solver is of no use
    /// afterwards.
    pub fn destroy(&mut self, device: &ash::Device) {
        for passes in self.passes.iter_mut().flatten() {
            if let Some(mut passes) = passes.take() {
                passes.destroy(device);
            }
        }
        for pipeline in self.surroundings.iter_mut().filter_map(Option::take) {
            // SAFETY: the caller has made sure that nothing uses it.
            unsafe { device.destroy_pipeline(pipeline, None) };
        }
        self.pipelines.destroy(device);
    }
}

/// Whether maps from between grid points take fewer iterations if the surroundings of sources are solved
/// first. With tiles and updates of all points no scan waits for another's next iteration.
fn have_surroundings(schedule: Schedule, wavefront: Wavefront) -> bool {
    schedule == Schedule::Raster && wavefront != Wavefront::Planar
}

fn surroundings_name(wavefront: Wavefront) -> String {
    format!("surroundings, {wavefront}")
}

/// The wavefront over a surface of which it is not known whether it is a floor plan.
fn over_any(wavefront: Wavefront) -> Wavefront {
    wavefront.or_curved(Setting::of_engine(false))
}
