//! Recording the steps of a batch.

use ash::vk;
use bytemuck::{NoUninit, bytes_of};

use super::layout::{BatchLayout, fan_numbers, numbers};
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
use crate::vulkan::profile::{
    PassKind, PassRecord, Presence, Profile, Scope, StepCounter, Watch, Work,
};
use crate::vulkan::record::{Block, UnpackBand};

/// A command buffer that is being recorded for one batch.
#[derive(Clone, Copy)]
pub(super) struct Recorder<'a> {
    pub(super) device: &'a ash::Device,
    pub(super) commands: vk::CommandBuffer,
    pub(super) pipelines: &'a Pipelines,
    pub(super) passes: &'a Passes,
    pub(super) resources: &'a Resources,
    pub(super) layout: &'a BatchLayout,
    pub(super) texels: TexelChart,
    /// Maps in the batch.
    pub(super) maps: u32,
    /// Takes the passes down, if anyone looks on.
    pub(super) profile: Option<&'a Profile>,
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct FanSize {
    grid: [u32; 2],
    scan: u32,
}

impl<'a> Recorder<'a> {
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
            // A pair's fan, out of the images and into its place.
            let pairs = u64::from(points.div_ceil(2)) * u64::from(lines);
            let bytes = 4 * fan_numbers(self.layout.wavefront) * pairs;
            let record = PassRecord {
                groups: Some(groups),
                work: Work::of_bytes(bytes, bytes),
                ..PassRecord::new(PassKind::Fans)
            };
            let _pass = Scope::open(self.watch(), || (record, Presence::Always));
            self.dispatch(&FanSize { grid: self.grid(), scan }, groups);
        }
        self.barrier(SHADER_WRITE, SHADER);
    }

    /// The records of passes over maps in images are those of one map.
    pub(super) fn steps(&self, steps: &[Step]) {
        let mut open = None;
        let has_two_layers = self.layout.wavefront.has_two_layers();
        let mut counter = StepCounter::new(self.texels, self.pipelines.tuning, has_two_layers);
        for step in steps {
            match step {
                Step::Barrier(before, after) => {
                    self.barrier(*before, *after);
                    continue;
                }
                Step::Raster(plan::Step::Barrier) => {
                    self.barrier(PASS, PASS);
                    continue;
                }
                _ => {}
            }
            Scope::go_on(&mut open, self.watch(), || {
                (self.record_of(step, &mut counter), Presence::Always)
            });
            match step {
                Step::Begin => self.copy(self.resources.staging(), self.resources.progress()),
                Step::Start => {
                    self.bind(self.passes.start(), 0);
                    self.dispatch(&self.grid(), self.start_groups());
                }
                Step::Workgroups => {
                    self.bind(self.passes.workgroups(), 0);
                    self.dispatch(&[0u32; 0], [self.maps, 1, 1]);
                }
                Step::Raster(plan::Step::Scan(pass)) => self.scan(pass),
                Step::Raster(plan::Step::Count) => {
                    self.bind(self.passes.count(), 0);
                    self.dispatch(&self.maps, self.count_groups());
                }
                Step::Raster(other) => unreachable!("{other:?} is of another schedule"),
                Step::Unpack => self.unpack(),
                Step::Report => self.copy(self.resources.progress(), self.resources.outcome()),
                Step::Barrier(..) => {}
            }
        }
    }

    fn record_of(&self, step: &Step, counter: &mut StepCounter) -> PassRecord {
        let progress = progress::bytes(self.maps);
        let copied = |kind, bytes| PassRecord {
            work: Work::of_bytes(bytes, bytes),
            ..PassRecord::new(kind)
        };
        let dispatched =
            |kind, groups| PassRecord { groups: Some(groups), ..PassRecord::new(kind) };
        match step {
            Step::Begin => copied(PassKind::Start, progress),
            Step::Report => copied(PassKind::Outcome, progress),
            Step::Start => {
                let TexelChart { rows, cols } = self.texels;
                let texels = u64::from(rows) * u64::from(cols);
                // Two images.
                let written = 2 * 16 * texels * u64::from(numbers(self.layout.wavefront));
                let work = Work::of_bytes(0, written);
                PassRecord { work, ..dispatched(PassKind::Seed, self.start_groups()) }
            }
            Step::Workgroups => PassRecord {
                iteration: Some(0),
                ..dispatched(PassKind::Workgroups, [self.maps, 1, 1])
            },
            Step::Raster(step) => {
                let (record, _) = counter.next(step);
                let groups = match step {
                    plan::Step::Count => Some(self.count_groups()),
                    _ => record.groups.map(|[x, y, _]| [x, y, self.maps]),
                };
                PassRecord { groups, ..record }
            }
            Step::Unpack => {
                let bytes = 4 * u64::from(self.maps) * self.layout.chart.points() as u64;
                let groups = Some(self.unpack_groups());
                PassRecord { groups, ..copied(PassKind::Unpack, bytes) }
            }
            Step::Barrier(..) => unreachable!("barriers are no passes"),
        }
    }

    fn start_groups(&self) -> [u32; 3] {
        let TexelChart { rows, cols } = self.texels;
        [cols.div_ceil(WORKGROUP), rows, self.maps]
    }

    fn count_groups(&self) -> [u32; 3] {
        [self.maps.div_ceil(WORKGROUP), 1, 1]
    }

    fn unpack_groups(&self) -> [u32; 3] {
        let [cols, rows] = self.grid();
        [cols.div_ceil(2).div_ceil(WORKGROUP), rows.div_ceil(2), self.maps]
    }

    fn watch(&self) -> Watch<'a> {
        let Self { device, commands, pipelines, profile, .. } = *self;
        Watch { device, commands, profile, labels: pipelines.labels.as_ref() }
    }

    fn scan(&self, pass: &ScanPass) {
        self.bind(self.passes.scan(pass.scan), pass.writes);
        let block = Block::of(pass, self.texels, self.pipelines.tuning.scan_lines);
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
        self.dispatch(&band, self.unpack_groups());
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
