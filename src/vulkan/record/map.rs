//! A map: its start, its sources, and what is read of it.

use std::ops::Range;

use ash::vk;
use bytemuck::{NoUninit, bytes_of};

use super::{Recorder, dispatched};
use crate::Stop;
use crate::constants::{CARRIED, FAR, LAYERS, TIME, WORKGROUP};
use crate::vulkan::Schedule;
use crate::vulkan::barrier::{CLEAR, COPY, HOST_READ, PASS, SHADER, SHADER_WRITE, TRANSFER};
use crate::vulkan::pipelines::{Pipelines, SchedulePipelines};
use crate::vulkan::plan::{Scan, Step};
use crate::vulkan::profile::{PassKind, PassRecord, Work};
use crate::vulkan::progress::{DeviceProgress, Outcome, offset};
use crate::vulkan::upload::SeedTexel;

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct SeedCount {
    texels: [u32; 2],
    count: u32,
    follows: u32,
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
pub(in crate::vulkan) struct UnpackBand {
    pub(in crate::vulkan) grid: [i32; 2],
    pub(in crate::vulkan) first_row: i32,
    pub(in crate::vulkan) band_rows: i32,
}

/// Blocks of lines that an update of a buffer starts: 3 KiB.
const BLOCKS_TOGETHER: usize = 256;

impl Recorder<'_> {
    /// Forgets the map: no point is reached in either image.
    pub(crate) fn forget(&self) {
        let _pass = self.pass_over_images(PassKind::Forget, 0, 2 * u64::from(LAYERS) * 16);
        self.barrier(SHADER, CLEAR);
        self.clear_fronts();
        self.barrier(CLEAR, SHADER);
    }

    pub(super) fn clear_fronts(&self) {
        for image in &self.grid.fronts {
            self.clear(image.image, TIME, FAR);
            self.clear(image.image, CARRIED, 0.0);
        }
    }

    /// Before the seeds of a map, or of what is added to one: no iteration is done. All blocks of
    /// lines are due in all scans of what is added, since the images of fronts may be out of step
    /// where the map has converged, and since other schedules know of no blocks.
    pub(crate) fn start(&self, stop: Stop, schedule: Schedule, is_added: bool) {
        // The progress, of each tile its state, the round it waits for and two lists, and for scans
        // by what each block is dispatched.
        let is_raster = schedule == Schedule::Raster;
        let blocks = if is_raster { 3 * self.block_words() } else { 0 };
        let written = size_of::<DeviceProgress>() as u64 + 4 * self.tile_bytes() + 4 * blocks;
        let work = Work::of_bytes(0, written);
        let _pass = self.pass_with(PassRecord { work, ..PassRecord::new(PassKind::Start) });
        let texels = self.grid.texels.inner();
        let grid = [texels[0].div_ceil(WORKGROUP), texels[1]];
        let progress = DeviceProgress::start(stop, grid);
        self.barrier(COPY, CLEAR);
        self.barrier(PASS, CLEAR);
        self.write(0, bytes_of(&progress));
        self.fill(self.grid.tiles.buffer, 0, vk::WHOLE_SIZE);
        if is_raster {
            self.start_blocks(is_added);
        }
        self.barrier(CLEAR, PASS);
    }

    /// Writes by what blocks of lines are dispatched, whether all are due or none.
    fn start_blocks(&self, are_due: bool) {
        let tuning = self.pipelines.tuning;
        let groups = self.grid.texels.inner().map(|length| length.div_ceil(tuning.scan_texels()));
        let both = 2 * u64::from(self.grid.texels.block_pitch(tuning.scan_lines));
        // Rows are as long as there are columns.
        for (first, groups) in [0, both].into_iter().zip(groups) {
            let blocks = [[groups, are_due.into(), 1]; BLOCKS_TOGETHER];
            for from in (0..both).step_by(BLOCKS_TOGETHER) {
                let count = BLOCKS_TOGETHER.min((both - from) as usize);
                let bytes = bytemuck::cast_slice(&blocks[..count]);
                let offset = (first + from) * size_of::<[u32; 3]>() as u64;
                self.update(self.grid.blocks.buffer, offset, bytes);
            }
        }
    }

    /// Before more iterations of a map, by a recording as long as the last. For rounds of tiles,
    /// the list that the last have left is the first.
    pub(crate) fn go_on(&self, steps: &[Step]) {
        let is_round = |step: &&Step| matches!(step, Step::Tiles { .. });
        let rounds = steps.iter().filter(is_round).count() as u32;
        if rounds == 0 {
            return;
        }
        let later = DeviceProgress::before_rounds();
        let later = &bytes_of(&later)[offset::round(1) as usize..];
        let (list, tiles) = (size_of::<u32>() as u64, self.tile_bytes());
        let work = Work::of_bytes(list, list + later.len() as u64 + tiles);
        let _pass = self.pass_with(PassRecord { work, ..PassRecord::new(PassKind::Resume) });
        let progress = &self.grid.progress;
        self.barrier(PASS, TRANSFER);
        let (from, to) = (offset::round(rounds), offset::round(0));
        self.copy((progress.buffer, from), (progress.buffer, to), list);
        self.barrier(COPY, CLEAR);
        self.write(offset::round(1), later);
        // Where tiles wait; their states are zero after they have settled, and the lists stay.
        self.fill(self.grid.tiles.buffer, tiles, tiles);
        self.barrier(CLEAR, PASS);
    }

    /// Dispatches no group of every pass of a map, since drivers may compile a pipeline at its first
    /// dispatch.
    pub(crate) fn warm_up(&self, passes: &SchedulePipelines) {
        let Pipelines { seed, progress, settle, .. } = *self.pipelines;
        for &pipeline in passes.passes.iter().chain(&[seed, progress, settle]) {
            self.bind(pipeline, 0);
            self.dispatch_groups(&[0u32; 8], 0);
            self.barrier(PASS, PASS);
        }
    }

    /// Sets the texels with sources, `count` of which are in the upload buffer, in image 0, and
    /// has the schedule begin with the tiles, or blocks of lines, around them.
    pub(crate) fn seed(&self, count: u32, schedule: Schedule) {
        // A texel's seeds, and its fronts in one image and the other.
        let fronts = 16 * u64::from(LAYERS);
        let each = [SeedTexel::BYTES + fronts, fronts];
        let _pass = self.pass_of_each(PassKind::Seed, [count, 1], each);
        let texels = self.grid.texels.inner();
        self.bind(self.pipelines.seed, 0);
        self.dispatch(&SeedCount { texels, count, follows: schedule as u32 }, [count, 1]);
        self.barrier(SHADER_WRITE, PASS);
    }

    /// Writes sources into the buffer from which `sources.comp` reads them.
    pub(crate) fn write_sources(&self, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let work = Work::of_bytes(0, bytes.len() as u64);
        let record = PassRecord { dispatches: 0, work, ..PassRecord::new(PassKind::Sources) };
        let _pass = self.pass_with(record);
        self.barrier(SHADER, CLEAR);
        self.update(self.grid.download.buffer, 0, bytes);
        self.barrier(CLEAR, SHADER);
    }

    /// Copies how the iterations have gone to one of the records that the host reads.
    pub(crate) fn outcome(&self, number: usize) {
        let offset = (number * size_of::<Outcome>()) as u64;
        self.outcome_to(self.grid.outcome.buffer, offset);
        self.barrier(CLEAR, HOST_READ);
    }

    /// Copies how the iterations have gone to a buffer that has room for it there.
    pub(crate) fn outcome_to(&self, to: vk::Buffer, offset: u64) {
        let size = size_of::<Outcome>() as u64;
        let _pass = self.pass_of_copy(PassKind::Outcome, size);
        self.barrier(PASS, COPY);
        self.copy((self.grid.progress.buffer, 0), (to, offset), size);
    }

    /// Unpacks the arrival times in image 0, a band of rows, into the read-back buffer.
    pub(crate) fn unpack(&self, rows: Range<usize>) {
        let chart = self.grid.chart;
        let points = (rows.len() * chart.cols) as u64;
        let work = Work::of_bytes(4 * points, 4 * points);
        let size = [chart.cols.div_ceil(2) as u32, rows.len().div_ceil(2) as u32];
        let _pass = self.pass_with(PassRecord { work, ..dispatched(PassKind::Unpack, size) });
        let band = UnpackBand {
            grid: [chart.cols as i32, chart.rows as i32],
            first_row: rows.start as i32,
            band_rows: rows.len() as i32,
        };
        // The set that writes image 1 reads image 0.
        self.bind(self.pipelines.unpack, 1);
        self.dispatch(&band, size);
        self.barrier(SHADER_WRITE, HOST_READ);
    }

    /// Bytes of one number for each tile.
    pub(super) fn tile_bytes(&self) -> u64 {
        let [cols, rows] = self.grid.texels.tiles(self.pipelines.tuning.tile);
        u64::from(cols) * u64::from(rows) * size_of::<u32>() as u64
    }

    /// Blocks of lines of all scans, with those beyond the grid.
    fn block_words(&self) -> u64 {
        let pitch = self.grid.texels.block_pitch(self.pipelines.tuning.scan_lines);
        Scan::ALL.len() as u64 * u64::from(pitch)
    }
}
