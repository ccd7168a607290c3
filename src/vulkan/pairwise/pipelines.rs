//! The passes over the maps of one surface, specialized for its size.

use ash::vk;

use super::layout::BatchLayout;
use crate::vulkan::VulkanError;
use crate::vulkan::pipelines::{Pass, Pipelines, SchedulePipelines, constant::*, scan_pass, spirv};
use crate::vulkan::plan::Scan;
use crate::vulkan::record::pipeline_index;

/// The passes of a batch.
#[derive(Debug)]
pub(super) struct Passes(SchedulePipelines);

/// Places of the passes over maps in shared memory.
const FANS: usize = 0;
const WORKGROUPS: usize = 1;
/// Places of the passes over maps in images, after the four scans.
const START: usize = 4;
const COUNT: usize = 5;

impl Passes {
    /// Creates them. [`Passes::destroy`] must be called before the device is destroyed.
    pub(super) fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        layout: &BatchLayout,
    ) -> Result<Self, VulkanError> {
        let wavefront = (WAVEFRONT, layout.wavefront as i32);
        let maps = (MAPS, layout.maps as i32);
        let mut passes: Vec<Pass> = Vec::new();
        if let Some(workgroup) = layout.workgroup {
            let constants = [
                wavefront,
                (WIDTH, workgroup.invocations as i32),
                (REPEATS, workgroup.iterations as i32),
                (ROWS, layout.chart.rows as i32),
                (COLS, layout.chart.cols as i32),
                (PITCH, workgroup.pitch as i32),
            ];
            passes.push((spirv!("pairwise_fans"), vec![wavefront]));
            passes.push((spirv!("pairwise_shared"), constants.to_vec()));
        } else {
            let width = (WIDTH, pipelines.tuning.scan_width as i32);
            let lines = (REPEATS, pipelines.tuning.scan_lines as i32);
            let cols = (COLS, layout.chart.cols as i32);
            let constants = [wavefront, maps, width, lines, cols];
            passes
                .extend(Scan::ALL.map(|scan| scan_pass(spirv!("pairwise_scan"), scan, &constants)));
            passes.push((spirv!("pairwise_start"), vec![wavefront, maps]));
            passes.push((spirv!("pairwise_count"), Vec::new()));
        }
        let new = SchedulePipelines::of(device, pipelines, &passes).map(Self)?;
        let names = match layout.workgroup {
            Some(_) => ["fans", "shared"].map(str::to_owned).to_vec(),
            None => {
                let scans = Scan::ALL.map(|scan| format!("scan {}", scan.name()));
                scans.into_iter().chain(["start", "count"].map(str::to_owned)).collect()
            }
        };
        for (name, &pipeline) in names.iter().zip(&new.0.passes) {
            pipelines.name(&format!("pairwise {name}, {}", layout.wavefront), pipeline);
        }
        Ok(new)
    }

    pub(super) fn fans(&self) -> vk::Pipeline {
        self.0.passes[FANS]
    }

    pub(super) fn workgroups(&self) -> vk::Pipeline {
        self.0.passes[WORKGROUPS]
    }

    pub(super) fn scan(&self, scan: Scan) -> vk::Pipeline {
        self.0.passes[pipeline_index(scan)]
    }

    pub(super) fn start(&self) -> vk::Pipeline {
        self.0.passes[START]
    }

    pub(super) fn count(&self) -> vk::Pipeline {
        self.0.passes[COUNT]
    }

    /// Destroys them. No submitted work may still use them.
    pub(super) fn destroy(&mut self, device: &ash::Device) {
        self.0.destroy(device);
    }
}
