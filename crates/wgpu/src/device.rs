//! The solver and the memory that all maps on a device of wgpu share.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use geosweep::Wavefront;
use geosweep::ash;
use geosweep::gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use geosweep::vulkan::embed::{Solver, SurfaceFrame, Tools};
use geosweep::vulkan::{Schedule, VulkanError};

use crate::hal::{RawDevice, with_commands};
use crate::{DistanceMap, Error, MapFrame};

/// The pipelines of a device, and the memory of its maps. All maps on the device share one `MapDevice`.
pub struct MapDevice {
    pub(crate) solver: Solver,
    allocator: Mutex<Allocator>,
    pub(crate) raw: ash::Device,
    /// Device of wgpu. It is the last member, so that the others are dropped before it.
    pub(crate) device: wgpu::Device,
}

impl MapDevice {
    /// Creates the pipelines of maps with curved fronts by raster scans, which run on any device. This call takes long,
    /// and may run on another thread.
    ///
    /// # Errors
    /// If wgpu does not drive the device through Vulkan, or a Vulkan call fails.
    pub fn new(device: &wgpu::Device) -> Result<Arc<Self>, Error> {
        Self::with_passes(device, &[(Schedule::Raster, Wavefront::Curved)])
    }

    /// Creates the pipelines of these schedules and wavefronts. [`Schedule::best_on`] names the schedule for a kind of
    /// device; maps take the best of those that are here.
    ///
    /// # Errors
    /// As for [`MapDevice::new`].
    pub fn with_passes(
        device: &wgpu::Device,
        passes: &[(Schedule, Wavefront)],
    ) -> Result<Arc<Self>, Error> {
        let RawDevice { instance, physical_device, device: raw, labels } = RawDevice::of(device)?;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: raw.clone(),
            physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        })?;
        let tools = Tools { labels, ..Tools::default() };
        let solver = Solver::with_tools(&instance, physical_device, &raw, passes, tools)?;
        let device = device.clone();
        Ok(Arc::new(Self { solver, allocator: Mutex::new(allocator), raw, device }))
    }

    /// Records maps of several surfaces side by side, with the outputs that they have. That is faster than one after
    /// another where they are small. The encoder is for maps alone, as in [`DistanceMap::record`].
    ///
    /// # Errors
    /// As for [`DistanceMap::record`], or if a map is listed twice, or made on another device.
    ///
    /// # Panics
    /// If the encoder has recorded commands of wgpu.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        maps: &[(&DistanceMap, MapFrame<'_>)],
    ) -> Result<(), Error> {
        let frames: Vec<_> = maps
            .iter()
            .map(|(map, frame)| SurfaceFrame::new(map.surface(), map.frame(frame)))
            .collect();
        with_commands(encoder, |commands| -> Result<(), VulkanError> {
            self.solver.record_frames(&self.raw, commands, &frames)?;
            maps.iter().try_for_each(|(map, frame)| map.record_outputs(commands, frame))
        })??;
        Ok(())
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for MapDevice {
    fn drop(&mut self) {
        self.solver.destroy(&self.raw);
    }
}
