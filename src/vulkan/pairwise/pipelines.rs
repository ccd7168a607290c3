//! The pipelines over the maps of one surface, specialized for its size.

use ash::vk;
use bytemuck::Pod;

use super::layout::BatchLayout;
use crate::vulkan::VulkanError;
use crate::vulkan::passes::{
    BatchSizes, PAIRWISE_COUNT, PAIRWISE_FANS, PAIRWISE_SCANS, PAIRWISE_SHARED, PAIRWISE_START,
    Pass,
};
use crate::vulkan::pipelines::{Pipeline, Pipelines};
use crate::vulkan::shaders::{
    pairwise_count, pairwise_fans, pairwise_scan, pairwise_shared, pairwise_start,
};

/// The pipelines of a batch; which there are depends on where its maps lie.
#[derive(Debug, Default)]
pub(super) struct BatchPipelines {
    /// Puts the surface's fans into order, and runs maps in shared memory.
    pub(super) in_shared_memory:
        Option<(Pipeline<pairwise_fans::Push>, Pipeline<pairwise_shared::Push>)>,
    /// The four scans of maps in images.
    pub(super) scans: Vec<Pipeline<pairwise_scan::Push>>,
    pub(super) start: Option<Pipeline<pairwise_start::Push>>,
    pub(super) count: Option<Pipeline<pairwise_count::Push>>,
    made: Vec<vk::Pipeline>,
}

impl BatchPipelines {
    /// Creates them. [`BatchPipelines::destroy`] must be called before the device is destroyed.
    pub(super) fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        layout: &BatchLayout,
    ) -> Result<Self, VulkanError> {
        let mut new = Self::default();
        match new.create(device, pipelines, layout) {
            Ok(()) => Ok(new),
            Err(error) => {
                new.destroy(device);
                Err(error)
            }
        }
    }

    fn create(
        &mut self,
        device: &ash::Device,
        pipelines: &Pipelines,
        layout: &BatchLayout,
    ) -> Result<(), VulkanError> {
        let sizes = sizes(layout);
        if layout.workgroup.is_some() {
            let fans = self.make(device, pipelines, PAIRWISE_FANS, (layout, sizes))?;
            let shared = self.make(device, pipelines, PAIRWISE_SHARED, (layout, sizes))?;
            self.in_shared_memory = Some((fans, shared));
        } else {
            for scan in PAIRWISE_SCANS {
                let scan = self.make(device, pipelines, scan, (layout, sizes))?;
                self.scans.push(scan);
            }
            self.start = Some(self.make(device, pipelines, PAIRWISE_START, (layout, sizes))?);
            self.count = Some(self.make(device, pipelines, PAIRWISE_COUNT, (layout, sizes))?);
        }
        Ok(())
    }

    fn make<P: Pod>(
        &mut self,
        device: &ash::Device,
        pipelines: &Pipelines,
        pass: Pass<P>,
        (layout, sizes): (&BatchLayout, BatchSizes),
    ) -> Result<Pipeline<P>, VulkanError> {
        let made = pipelines.make_for_batch(device, pass, layout.wavefront, sizes)?;
        self.made.push(made.handle);
        Ok(made)
    }

    /// Destroys them. No submitted work may still use them.
    pub(super) fn destroy(&mut self, device: &ash::Device) {
        for pipeline in self.made.drain(..) {
            // SAFETY: the caller has made sure that nothing uses it.
            unsafe { device.destroy_pipeline(pipeline, None) };
        }
    }
}

fn sizes(layout: &BatchLayout) -> BatchSizes {
    let (pitch, invocations, iterations) =
        layout.workgroup.map_or((0, 0, 0), |of| (of.pitch, of.invocations, of.iterations));
    BatchSizes {
        maps: layout.maps,
        rows: layout.chart.rows as u32,
        cols: layout.chart.cols as u32,
        pitch,
        invocations,
        iterations,
    }
}
