//! Allocates the resources for the maps of many sources of a surface.

use std::sync::Arc;

use ash::vk;

use super::super::device::passes::Variant;
use super::super::headless::context::{Flight, Unwatched};
use super::super::{HeadlessSolver, SurfaceOnDevice, VulkanError};
use super::layout::{BatchLayout, BatchLimits};
use super::pipelines::BatchPipelines;
use super::resources::Resources;
use super::{PairwiseOnDevice, PairwiseSchedule};
use crate::update::Wavefront;

impl HeadlessSolver {
    /// Allocates resources for the maps of many sources of a surface. A batch has as many maps as suit the
    /// device and the grid. Curved fronts replace anchored ones. If the slowness is not the same everywhere,
    /// they replace circular ones too. `schedule` is for measurements. By default maps lie in shared memory
    /// where they fit. If the slowness is not the same everywhere, or the surface is glued or has obtuse triangles,
    /// they lie in images, whatever `schedule` is.
    ///
    /// # Errors
    /// If a batch does not fit the device's memory, or shared memory was requested and a map does not fit it.
    ///
    /// # Panics
    /// If another solver has uploaded the surface.
    pub fn pairwise(
        &self,
        surface: &SurfaceOnDevice,
        wavefront: Wavefront,
        schedule: Option<PairwiseSchedule>,
    ) -> Result<PairwiseOnDevice, VulkanError> {
        let (context, grid) = (&self.context, &surface.images);
        assert!(Arc::ptr_eq(context, &surface.context), "a surface of another solver");
        let (chart, texels) = (grid.chart, grid.texels);
        let wavefront = surface.suited(wavefront, false);
        // Updates in shared memory read nothing but a point's neighbours and the lengths between them.
        let schedule = match surface.slowed || surface.splits.any() || grid.copies.is_some() {
            true => Some(PairwiseSchedule::Images),
            false => schedule,
        };
        let (rows, cols, device) = (chart.rows, chart.cols, context.info.name.clone());
        let mut subgroups = vk::PhysicalDeviceSubgroupProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut subgroups);
        let instance = &context.instance.handle;
        // SAFETY: the physical device is from this instance, and supports Vulkan 1.1 as all devices in use
        // do.
        unsafe {
            instance.get_physical_device_properties2(context.physical_device, &mut properties)
        };
        let properties = properties.properties;
        let limits = BatchLimits::of(&properties, subgroups.subgroup_size);
        let layout = BatchLayout::new(chart, texels, wavefront, schedule, &limits);
        let Some(layout) = layout else {
            let available = limits.shared_memory;
            return Err(VulkanError::NotInSharedMemory { rows, cols, device, available });
        };
        let list = grid.copies.as_ref().map(|copies| copies.list().of_batch(layout.maps));
        let layout = BatchLayout { copies: list.map_or(0, |list| list.bytes()), ..layout };
        let available = self.for_device.limits.heap;
        if layout.bytes() > available || layout.distances() > limits.buffer {
            let (needed, available) = (layout.bytes() >> 20, available.min(limits.buffer) >> 20);
            return Err(VulkanError::TooMuchMemory { rows, cols, device, needed, available });
        }
        self.pairwise_in(surface, layout)
    }

    /// Allocates the resources for a layout that fits the device.
    pub(super) fn pairwise_in(
        &self,
        surface: &SurfaceOnDevice,
        layout: BatchLayout,
    ) -> Result<PairwiseOnDevice, VulkanError> {
        let (context, grid) = (&self.context, &surface.images);
        let (texels, wavefront) = (grid.texels, layout.wavefront);
        let flight = Flight::new(context)?;
        let SurfaceOnDevice { slowed, splits, .. } = *surface;
        let variant = Variant { slowed, splits, ..wavefront.into() };
        let pipelines = &self.for_device.pipelines;
        let is_glued = grid.copies.is_some();
        let passes = BatchPipelines::new(&context.device, pipelines, &layout, variant, is_glued)?;
        let resources =
            Resources::new(&context.device, &mut context.allocator(), pipelines, grid, &layout)?;
        let mut new = PairwiseOnDevice {
            context: Arc::clone(context),
            edges: grid.edges.image,
            texels,
            wavefront,
            layout,
            passes,
            resources,
            flight,
        };
        new.start(self, 0, &mut Unwatched, |recorder| recorder.prepare())?;
        new.flight.wait()?;
        context.check_validation()?;
        Ok(new)
    }
}
