//! Recording the steps of a batch.

use ash::vk;
use bytemuck::{NoUninit, bytes_of};

use super::layout::Layout;
use super::pipelines::Passes;
use super::progress::{self, offset};
use super::resources::Resources;
use super::steps::Step;
use crate::constants::WORKGROUP;
use crate::vulkan::TexelChart;
use crate::vulkan::barrier::{self, NOTHING, PASS, SHADER, SHADER_WRITE};
use crate::vulkan::memory::Buffer;
use crate::vulkan::pipelines::Pipelines;
use crate::vulkan::plan::{self, Scan, ScanPass};
use crate::vulkan::record::{Block, UnpackBand};

/// A command buffer that is being recorded for one batch.
#[derive(Clone, Copy)]
pub(super) struct Recorder<'a> {
    pub(super) device: &'a ash::Device,
    pub(super) commands: vk::CommandBuffer,
    pub(super) pipelines: &'a Pipelines,
    pub(super) passes: &'a Passes,
    pub(super) resources: &'a Resources,
    pub(super) layout: &'a Layout,
    pub(super) texels: TexelChart,
    /// Maps in the batch.
    pub(super) maps: u32,
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct FanSize {
    grid: [u32; 2],
    scan: u32,
}

impl Recorder<'_> {
    /// Once, before the first batch: brings images into their layout, or puts the surface's fans into
    /// the order of the scans.
    pub(super) fn prepare(&self) {
        let layouts = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        for image in &self.resources.fronts {
            barrier::image(self.device, self.commands, image.image, NOTHING, SHADER, layouts);
        }
        if self.layout.workgroup.is_none() {
            return;
        }
        self.bind(self.passes.fans(), 0);
        let [cols, rows] = self.grid();
        for scan in 0..Scan::ALL.len() as u32 {
            let (points, lines) = if scan < 2 { (cols, rows) } else { (rows, cols) };
            let groups = [points.div_ceil(2).div_ceil(WORKGROUP), lines, 1];
            self.dispatch(&FanSize { grid: self.grid(), scan }, groups);
        }
        self.barrier(SHADER_WRITE, SHADER);
    }

    pub(super) fn steps(&self, steps: &[Step]) {
        for step in steps {
            match step {
                Step::Begin => self.copy(self.resources.staging(), self.resources.progress()),
                Step::Start => {
                    self.bind(self.passes.start(), 0);
                    let TexelChart { rows, cols } = self.texels;
                    self.dispatch(&self.grid(), [cols.div_ceil(WORKGROUP), rows, self.maps]);
                }
                Step::Workgroups => {
                    self.bind(self.passes.workgroups(), 0);
                    self.dispatch(&[0u32; 0], [self.maps, 1, 1]);
                }
                Step::Raster(plan::Step::Scan(pass)) => self.scan(pass),
                Step::Raster(plan::Step::Count) => {
                    self.bind(self.passes.count(), 0);
                    self.dispatch(&self.maps, [self.maps.div_ceil(WORKGROUP), 1, 1]);
                }
                Step::Raster(plan::Step::Barrier) => self.barrier(PASS, PASS),
                Step::Raster(other) => unreachable!("{other:?} is of another schedule"),
                Step::Unpack => self.unpack(),
                Step::Report => self.copy(self.resources.progress(), self.resources.outcome()),
                Step::Barrier(before, after) => self.barrier(*before, *after),
            }
        }
    }

    fn scan(&self, pass: &ScanPass) {
        self.bind(self.passes.scan(pass.scan), pass.writes);
        let block = Block::of(pass, self.texels);
        if pass.always {
            let groups = block.count.div_ceil(self.pipelines.tuning.scan_texels());
            self.dispatch(&block, [groups, 1, self.maps]);
            return;
        }
        self.push(&block);
        let by_rows = matches!(pass.scan, Scan::Down | Scan::Up);
        let offset = if by_rows { offset::ROW_GROUPS } else { offset::COL_GROUPS };
        let progress = self.resources.progress().buffer;
        // SAFETY: a pipeline with the common layout is bound, and three numbers are at the offset.
        unsafe { self.device.cmd_dispatch_indirect(self.commands, progress, offset) };
    }

    fn unpack(&self) {
        // The set that writes image 1 reads image 0.
        self.bind(self.pipelines.unpack, 1);
        let [cols, rows] = self.grid();
        let grid = [cols as i32, rows as i32];
        let band = UnpackBand { grid, first_row: 0, band_rows: rows as i32 };
        let groups = [cols.div_ceil(2).div_ceil(WORKGROUP), rows.div_ceil(2), self.maps];
        self.dispatch(&band, groups);
    }

    /// Columns and rows of points.
    fn grid(&self) -> [u32; 2] {
        [self.layout.chart.cols as u32, self.layout.chart.rows as u32]
    }

    fn copy(&self, from: &Buffer, to: &Buffer) {
        let copy = [vk::BufferCopy::default().size(progress::bytes(self.maps))];
        // SAFETY: both buffers have room for the progress of a full batch.
        unsafe { self.device.cmd_copy_buffer(self.commands, from.buffer, to.buffer, &copy) };
    }

    fn barrier(&self, before: barrier::Access, after: barrier::Access) {
        barrier::memory(self.device, self.commands, before, after);
    }

    fn bind(&self, pipeline: vk::Pipeline, writes: usize) {
        let compute = vk::PipelineBindPoint::COMPUTE;
        let (layout, sets) = (self.pipelines.layout, [self.resources.sets[writes]]);
        // SAFETY: pipeline, layout and set belong together and are alive.
        unsafe {
            self.device.cmd_bind_pipeline(self.commands, compute, pipeline);
            self.device.cmd_bind_descriptor_sets(self.commands, compute, layout, 0, &sets, &[]);
        }
    }

    fn dispatch(&self, constants: &impl NoUninit, [x, y, z]: [u32; 3]) {
        self.push(constants);
        // SAFETY: a pipeline with the common layout is bound.
        unsafe { self.device.cmd_dispatch(self.commands, x, y, z) };
    }

    fn push(&self, constants: &impl NoUninit) {
        let bytes = bytes_of(constants);
        if bytes.is_empty() {
            return;
        }
        let (layout, stages) = (self.pipelines.layout, vk::ShaderStageFlags::COMPUTE);
        // SAFETY: the layout has room for the constants of every pass.
        unsafe {
            self.device.cmd_push_constants(self.commands, layout, stages, 0, bytes);
        }
    }
}
