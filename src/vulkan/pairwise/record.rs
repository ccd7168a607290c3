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
use crate::vulkan::profile::{PassKind, PassRecord, Presence, Scope, StepCounter, Work};
use crate::vulkan::record::{Commands, Groups};
use crate::vulkan::schedules::plan;
use crate::vulkan::schedules::plan::{Scan, ScanPass};
use crate::vulkan::schedules::{account, block_of};

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
            let record = PassRecord {
                groups: Some(groups),
                work: Work::of_bytes(bytes, bytes),
                ..PassRecord::new(PassKind::Fans)
            };
            let _pass = Scope::open(self.watch(), || (record, Presence::Always));
            let push = pairwise_fans::Push { grid: self.signed_grid(), scan: scan as i32 };
            self.dispatch(fans, &push, Groups::These(groups));
        }
        self.barrier(SHADER_WRITE, SHADER);
    }

    /// Records steps. For passes over maps in images, the profile's records hold the work of one map.
    pub(super) fn steps(&self, steps: &[Step]) {
        let mut open = None;
        let has_two_layers = self.layout.wavefront.has_two_layers();
        let exchanged = self.resources.copies.as_ref().map(Copies::bytes_moved);
        let counter = StepCounter::new(self.texels, self.pipelines.tuning, has_two_layers);
        let mut counter = counter.exchanging(exchanged);
        // A recording that does not begin a batch continues one.
        if steps.first() != Some(&Step::Begin) {
            self.barrier(PASS, PASS);
        }
        for step in steps {
            for &(before, after) in step.barriers_before() {
                self.barrier(before, after);
            }
            Scope::go_on(&mut open, self.watch(), || {
                (self.record_of(step, &mut counter), Presence::Always)
            });
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
                // Both images are written.
                let written = 2 * 16 * texels * u64::from(numbers(self.layout.wavefront));
                let work = Work::of_bytes(0, written);
                PassRecord { work, ..dispatched(PassKind::Seed, self.start_groups()) }
            }
            Step::ExchangeSources => {
                let (record, _) = counter.exchange(None);
                PassRecord { work: record.work, ..dispatched(PassKind::Seed, [1, 1, self.maps]) }
            }
            Step::Workgroups => PassRecord {
                iteration: Some(0),
                ..dispatched(PassKind::Workgroups, [self.maps, 1, 1])
            },
            Step::Raster(step) => {
                let (record, _) = account(counter, step);
                let groups = match step {
                    plan::Step::Count => Some(self.count_groups()),
                    _ => record.groups.map(|[x, y, _]| [x, y, self.maps]),
                };
                PassRecord { groups, ..record }
            }
            Step::Unpack => {
                let groups = Some(self.unpack_groups());
                PassRecord { groups, ..copied(PassKind::Unpack, self.distance_bytes()) }
            }
            Step::Bring(_) => {
                let record = copied(PassKind::Unpack, self.distance_bytes());
                PassRecord { dispatches: 0, ..record }
            }
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
