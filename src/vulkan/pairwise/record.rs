//! Records the steps of a batch.

use std::ops::Deref;

use ash::vk;
use bytemuck::Pod;

use super::layout::{BatchLayout, fan_numbers, numbers};
use super::pipelines::BatchPipelines::{self, Images, SharedMemory};
use super::progress::{self, offset};
use super::resources::Resources;
use super::steps::Step;
use crate::constants::WORKGROUP;
use crate::vulkan::TexelChart;
use crate::vulkan::copies::Copies;
use crate::vulkan::device::barrier::{NOTHING, PASS, SHADER, SHADER_WRITE, TRANSFER_WRITE};
use crate::vulkan::device::descriptors::Sets;
use crate::vulkan::device::memory::Buffer;
use crate::vulkan::device::passes::UNPACK;
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::shaders::{
    pairwise_count, pairwise_exchange, pairwise_fans, pairwise_scan, pairwise_shared,
    pairwise_start, unpack,
};
use crate::vulkan::record::{Commands, Groups, OpenPass, PassKind, PlannedSteps, StepsOf};
use crate::vulkan::schedules::block_of;
use crate::vulkan::schedules::plan;
use crate::vulkan::schedules::plan::{Scan, ScanPass};

/// Recorder of one batch.
#[derive(Clone, Copy)]
pub(super) struct BatchRecorder<'a> {
    pub(super) commands: Commands<'a>,
    pub(super) passes: &'a BatchPipelines,
    pub(super) resources: &'a Resources,
    pub(super) layout: &'a BatchLayout,
    pub(super) texels: TexelChart,
    /// Number of maps in the batch.
    pub(super) maps: u32,
}

impl<'a> Deref for BatchRecorder<'a> {
    type Target = Commands<'a>;

    fn deref(&self) -> &Self::Target {
        &self.commands
    }
}

impl BatchRecorder<'_> {
    /// Prepares the resources once, before the first batch. It transitions the images into their layout, or
    /// arranges the surface's fans in the order of the scans.
    pub(super) fn prepare(&self) {
        let layouts = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        for image in &self.resources.fronts {
            self.image_barrier(image.image, NOTHING, SHADER, layouts);
        }
        if let Some(copies) = &self.resources.copies {
            self.write_copies(copies);
            self.barrier(TRANSFER_WRITE, PASS);
        }
        let &SharedMemory { fans, .. } = self.passes else { return };
        self.bind(fans, self.sets(0));
        let [cols, rows] = self.grid();
        for scan in 0..Scan::ALL.len() as u32 {
            let (points, lines) = if scan < 2 { (cols, rows) } else { (rows, cols) };
            let groups = [points.div_ceil(2).div_ceil(WORKGROUP), lines, 1];
            // The fan of each pair of points is read from the images and written to its place in the buffer
            // of fans.
            let pairs = u64::from(points.div_ceil(2)) * u64::from(lines);
            let bytes = 4 * fan_numbers(self.layout.wavefront) * pairs;
            let _pass = self.pass_moving(PassKind::Fans, [Some(bytes); 2]);
            let push = pairwise_fans::Push { grid: self.signed_grid(), scan: scan as i32 };
            self.dispatch(fans, &push, Groups::These(groups));
        }
        self.barrier(SHADER_WRITE, SHADER);
    }

    /// Records steps.
    pub(super) fn steps(&self, steps: &[Step]) {
        if let Some(observer) = self.observer {
            observer.begin_steps(self, self.planned());
        }
        // A recording that does not begin a batch continues one.
        if steps.first() != Some(&Step::Begin) {
            self.barrier(PASS, PASS);
        }
        for step in steps {
            for &(before, after) in step.barriers_before() {
                self.barrier(before, after);
            }
            let _pass = self.pass_of(step);
            match (step, self.passes) {
                (Step::Begin, _) => {
                    self.copy_progress(self.resources.staging(), self.resources.progress())
                }
                (Step::Start, Images { start, .. }) => {
                    let push = pairwise_start::Push { grid: self.signed_grid() };
                    self.run(*start, &push, self.start_groups());
                }
                (Step::ExchangeSources, Images { exchange, .. }) => self.exchange(*exchange, 0),
                (Step::Workgroups, SharedMemory { maps, .. }) => {
                    let workgroup = self.layout.workgroup.expect("maps lie in shared memory");
                    let push = pairwise_shared::Push {
                        grid: self.signed_grid(),
                        pitch: workgroup.pitch as i32,
                        iterations: workgroup.iterations as i32,
                    };
                    self.run(*maps, &push, [self.maps, 1, 1]);
                }
                (Step::Raster(plan::Step::Scan(pass)), Images { scans, .. }) => {
                    self.scan(scans[pass.scan as usize], pass);
                }
                (&Step::Raster(plan::Step::Exchange { image, .. }), Images { exchange, .. }) => {
                    self.exchange(*exchange, image)
                }
                (Step::Raster(plan::Step::Count), Images { count, .. }) => {
                    let push = pairwise_count::Push { count: self.maps };
                    self.run(*count, &push, self.count_groups());
                }
                (Step::Unpack, _) => self.unpack(),
                (&Step::Bring(half), _) => {
                    let from = self.resources.distances();
                    self.copy(
                        (from.buffer, 0),
                        self.resources.staged_at(half),
                        self.distance_bytes(),
                    );
                }
                (Step::Report, _) => {
                    self.copy_progress(self.resources.progress(), self.resources.outcome())
                }
                (Step::Start | Step::ExchangeSources | Step::Workgroups | Step::Raster(_), _) => {
                    unreachable!("{step:?} is of another schedule")
                }
            }
            let (before, after) = step.barrier_after();
            self.barrier(before, after);
        }
        if let Some(observer) = self.observer {
            observer.end_steps(self);
        }
    }

    /// Returns the steps over maps in images for an observer.
    fn planned(&self) -> PlannedSteps<'_> {
        PlannedSteps {
            steps: &[],
            texels: self.texels,
            tuning: self.pipelines.tuning,
            carries: self.layout.wavefront.has_two_layers(),
            exchanged: self.resources.copies.as_ref().map(Copies::bytes_moved),
            of: StepsOf::Batch(self.maps),
        }
    }

    /// Begins the pass of a step.
    fn pass_of(&self, step: &Step) -> Option<OpenPass<'_>> {
        match step {
            Step::Begin => self.pass(PassKind::Start),
            Step::Report => self.pass(PassKind::Outcome),
            Step::Bring(_) => self.pass(PassKind::Unpack),
            Step::Unpack => self.pass_moving(PassKind::Unpack, [Some(self.distance_bytes()); 2]),
            Step::Workgroups => self.pass(PassKind::Workgroups),
            Step::Start => {
                let TexelChart { rows, cols } = self.texels;
                let texels = u64::from(rows) * u64::from(cols);
                // Both images are written.
                let written = 2 * 16 * texels * u64::from(numbers(self.layout.wavefront));
                self.pass_moving(PassKind::Seed, [Some(0), Some(written)])
            }
            Step::ExchangeSources => {
                let moved = self.resources.copies.as_ref().map(Copies::bytes_moved);
                self.pass_moving(PassKind::Seed, moved.unwrap_or_default().map(Some))
            }
            Step::Raster(step) => Some(self.step(step)),
        }
    }

    /// Returns the bytes of the distances of the batch.
    fn distance_bytes(&self) -> u64 {
        4 * u64::from(self.maps) * self.layout.chart.points() as u64
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
        [cols.div_ceil(WORKGROUP), rows.div_ceil(2), self.maps]
    }

    fn scan(&self, scan: Pipeline<pairwise_scan::Push>, pass: &ScanPass) {
        let tuning = self.pipelines.tuning;
        let block = block_of(pass, self.texels, tuning.scan_lines);
        let groups = if pass.always {
            let groups = (pass.texels.len() as u32).div_ceil(tuning.scan_texels());
            Groups::These([groups, 1, self.maps])
        } else {
            let by_rows = matches!(pass.scan, Scan::Down | Scan::Up);
            let offset = if by_rows { offset::ROW_GROUPS } else { offset::COL_GROUPS };
            Groups::From(self.resources.progress().buffer, offset)
        };
        self.bind(scan, self.sets(pass.writes));
        self.dispatch(scan, &block, groups);
    }

    /// Records an exchange between copies of points in one of the images, for each map.
    fn exchange(&self, exchange: Option<Pipeline<pairwise_exchange::Push>>, image: usize) {
        let copies = self.resources.copies.as_ref().zip(exchange);
        let (copies, exchange) = copies.expect("only glued surfaces have exchanges");
        self.bind(exchange, copies.sets(image));
        self.dispatch(exchange, &copies.push_of_batch(), Groups::These([1, 1, self.maps]));
    }

    fn unpack(&self) {
        let grid = self.signed_grid();
        let unpack = self.pipelines.of(UNPACK);
        // The sets of a pass that writes image 1 read image 0.
        self.bind(unpack, self.sets(1).with_host(self.resources.sets.read_back));
        let layers = numbers(self.layout.wavefront) as i32;
        let band = unpack::Push { grid, first_row: 0, band_rows: grid[1], layers };
        self.dispatch(unpack, &band, Groups::These(self.unpack_groups()));
    }

    /// Records a pass that writes image 0.
    fn run<P: Pod>(&self, pipeline: Pipeline<P>, constants: &P, groups: [u32; 3]) {
        self.bind(pipeline, self.sets(0));
        self.dispatch(pipeline, constants, Groups::These(groups));
    }

    fn sets(&self, writes: usize) -> Sets {
        self.resources.sets.writing[writes]
    }

    fn signed_grid(&self) -> [i32; 2] {
        self.grid().map(|points| points as i32)
    }

    /// Returns the columns and rows of points.
    fn grid(&self) -> [u32; 2] {
        [self.layout.chart.cols as u32, self.layout.chart.rows as u32]
    }

    fn copy_progress(&self, from: &Buffer, to: &Buffer) {
        self.copy((from.buffer, 0), (to.buffer, 0), progress::bytes(self.maps));
    }
}
