//! Recording: each function appends commands to a command buffer that the caller has begun, and
//! ends with a barrier after which the next function may be recorded. None submits or waits.

use std::ops::Range;

use ash::vk;
use bytemuck::{NoUninit, bytes_of};

use super::barrier::{self, CLEAR, COPY, HOST_READ, NOTHING, PASS, SHADER, SHADER_WRITE, TRANSFER};
use super::grid_images::GridImages;
use super::pipelines::{Pipelines, SchedulePipelines};
use super::plan::{Scan, ScanPass, Step};
use super::profile::{
    self, PassKind, PassRecord, Presence, Profile, Scope, StepCounter, Watch, Work,
};
use super::progress::{self, DeviceProgress, Outcome, VISIT_BYTES, VISITS, offset};
use super::upload::SeedTexel;
use super::{Schedule, TexelChart};
use crate::constants::{BORDER, CURVATURE, FAR, LAYERS, TIME, WORKGROUP};
use crate::cpu::Stop;
use crate::surface::{Chart, EdgeRule, Spacing};

/// A command buffer that is being recorded for one surface.
#[derive(Clone, Copy)]
pub(crate) struct Recorder<'a> {
    /// The device of everything else.
    pub(crate) device: &'a ash::Device,
    /// Begun, on a queue family for compute, outside a render pass.
    pub(crate) commands: vk::CommandBuffer,
    /// Alive until the commands have run.
    pub(crate) pipelines: &'a Pipelines,
    /// The surface's.
    pub(crate) grid: &'a GridImages,
    /// Takes the passes down, if anyone looks on.
    pub(crate) profile: Option<&'a Profile>,
}

/// What edges are measured from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum EdgeSource {
    Positions,
    Heights,
    Metric,
}

impl EdgeSource {
    /// Numbers of a point, without its slowness.
    pub(crate) fn components(self) -> u64 {
        match self {
            Self::Positions | Self::Metric => 3,
            Self::Heights => 1,
        }
    }

    /// Bytes of a point in the upload buffer, which holds its slowness too.
    pub(crate) fn bytes(self) -> u64 {
        4 * (self.components() + 1)
    }
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct EdgesBand {
    grid: [i32; 2],
    first_row: i32,
    band_rows: i32,
    buffer_row: i32,
    dx: f32,
    dy: f32,
    arcs: i32,
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct FanSize {
    texels: [u32; 2],
    share_of_fan: f32,
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
pub(super) struct UnpackBand {
    pub(super) grid: [i32; 2],
    pub(super) first_row: i32,
    pub(super) band_rows: i32,
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct SeedCount {
    texels: [u32; 2],
    count: u32,
    follows: u32,
}

/// The constants of a block of lines of a scan.
#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
pub(super) struct Block {
    line: u32,
    lines: u32,
    first: u32,
    pub(super) count: u32,
    last: u32,
    pitch: u32,
    note: i32,
}

impl Block {
    pub(super) fn of(pass: &ScanPass, texels: TexelChart, lines: u32) -> Self {
        let by_rows = matches!(pass.scan, Scan::Down | Scan::Up);
        Self {
            line: pass.line,
            lines: pass.lines,
            first: pass.texels.start,
            count: pass.texels.len() as u32,
            last: if by_rows { texels.inner_cols() } else { texels.inner_rows() }.end - 1,
            pitch: texels.block_pitch(lines),
            note: -1,
        }
    }
}

/// Of a round its number, of a recording how many.
#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct Round {
    texels: [u32; 2],
    round: u32,
}

/// The rows whose points are needed to measure the edges of a band: two before, since an edge to
/// the north also depends on how the surface bends at its other end, and one after.
pub(crate) fn rows_around(band: &Range<usize>, chart: Chart) -> Range<usize> {
    band.start.saturating_sub(BEFORE)..(band.end + AFTER).min(chart.rows)
}

/// Blocks of lines that an update of a buffer starts: 3 KiB.
const BLOCKS_TOGETHER: usize = 256;

const BEFORE: usize = 2;
const AFTER: usize = 1;
/// Rows around a band, at most.
pub(crate) const HALO: usize = BEFORE + AFTER;

impl<'a> Recorder<'a> {
    /// To be kept while a pass is recorded: its label, and its place in the profile with what is
    /// known of it.
    pub(crate) fn pass_with(&self, record: PassRecord) -> Option<Scope<'a>> {
        Scope::open(self.watch(), || (record, Presence::Always))
    }

    /// The same of a copy of so many bytes.
    fn pass_of_copy(&self, kind: PassKind, bytes: u64) -> Option<Scope<'a>> {
        let work = Work::of_bytes(bytes, bytes);
        self.pass_with(PassRecord { work, ..PassRecord::new(kind) })
    }

    /// The same of a dispatch of so many invocations wide and high, with bytes read and written for
    /// each of them.
    pub(crate) fn pass_of_each(
        &self,
        kind: PassKind,
        invocations: [u32; 2],
        [read, written]: [u64; 2],
    ) -> Option<Scope<'a>> {
        let count = invocations.map(u64::from).iter().product::<u64>();
        let work = Work::of_bytes(count * read, count * written);
        self.pass_with(PassRecord { work, ..dispatched(kind, invocations) })
    }

    fn watch(&self) -> Watch<'a> {
        let Self { device, commands, pipelines, profile, .. } = *self;
        Watch { device, commands, profile, labels: pipelines.labels.as_ref() }
    }

    /// The same, with bytes read and written for each texel of the images, border included.
    fn pass_over_images(&self, kind: PassKind, read: u64, written: u64) -> Option<Scope<'a>> {
        let extent = self.grid.texels.fronts_extent();
        let texels = u64::from(extent.width) * u64::from(extent.height);
        let work = Work::of_bytes(texels * read, texels * written);
        self.pass_with(PassRecord { work, ..PassRecord::new(kind) })
    }

    /// Brings new images into their layout, with no edge and no point reached.
    pub(crate) fn prepare(&self) {
        // Four points' edges, the surface's curvature and two images of fronts.
        let written = (4 + 1 + 2 * u64::from(LAYERS)) * 16;
        let _pass = self.pass_over_images(PassKind::Prepare, 0, written);
        let grid = self.grid;
        let layouts = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        for image in [&grid.edges, &grid.gaussian, &grid.fronts[0], &grid.fronts[1]] {
            self.image_barrier(image.image, NOTHING, CLEAR, layouts);
        }
        self.clear(grid.edges.image, 0, FAR);
        self.clear(grid.gaussian.image, 0, 0.0);
        self.clear_fronts();
        self.barrier(CLEAR, SHADER);
    }

    /// Measures the edges of a band of rows; the points of [`rows_around`] it are in the upload
    /// buffer.
    pub(crate) fn measure(
        &self,
        source: EdgeSource,
        spacing: Spacing,
        arcs: bool,
        rows: Range<usize>,
    ) {
        let (pipelines, chart) = (self.pipelines, self.grid.chart);
        let size = [chart.cols as u32, rows.len() as u32];
        let around = rows_around(&rows, chart);
        // Four lengths of each point.
        let [read, written] = [source.bytes() * around.len() as u64, 16 * rows.len() as u64]
            .map(|bytes| bytes * chart.cols as u64);
        let work = Work::of_bytes(read, written);
        let _pass = self.pass_with(PassRecord { work, ..dispatched(PassKind::Edges, size) });
        let pipeline = match source {
            EdgeSource::Positions => pipelines.edges_from_positions,
            EdgeSource::Heights => pipelines.edges_from_heights,
            EdgeSource::Metric => pipelines.edges_from_metric,
        };
        let band = EdgesBand {
            grid: [chart.cols as i32, chart.rows as i32],
            first_row: rows.start as i32,
            band_rows: rows.len() as i32,
            buffer_row: around.start as i32,
            dx: spacing.dx as f32,
            dy: spacing.dy as f32,
            arcs: arcs.into(),
        };
        self.bind(pipeline, 0);
        self.dispatch(&band, size);
        self.barrier(SHADER_WRITE, SHADER);
    }

    /// Computes the surface's Gaussian curvature, once all edges are measured by the rule.
    pub(crate) fn bend(&self, rule: EdgeRule) {
        let texels = self.grid.texels.inner();
        let size = FanSize { texels, share_of_fan: rule.share_of_fan() as f32 };
        for pipeline in [self.pipelines.fan_curvature, self.pipelines.gaussian_curvature] {
            // Lengths of the edges of four points, and a number of each besides in the second pass.
            let read = if pipeline == self.pipelines.fan_curvature { 64 } else { 64 + 16 };
            let _pass = self.pass_of_each(PassKind::Curvature, texels, [read, 16]);
            self.bind(pipeline, 0);
            self.dispatch(&size, texels);
            self.barrier(SHADER_WRITE, SHADER);
        }
    }

    /// Forgets the map: no point is reached in either image.
    pub(crate) fn forget(&self) {
        let _pass = self.pass_over_images(PassKind::Forget, 0, 2 * u64::from(LAYERS) * 16);
        self.barrier(SHADER, CLEAR);
        self.clear_fronts();
        self.barrier(CLEAR, SHADER);
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

    /// Runs the steps of a plan.
    pub(crate) fn steps(&self, passes: &SchedulePipelines, steps: &[Step]) {
        let mut bound = None;
        let mut open: Option<Scope> = None;
        let texels = self.grid.texels.inner();
        let progress = self.grid.progress.buffer;
        let mut counter = StepCounter::new(self.grid.texels, self.pipelines.tuning, passes.curved);
        let notes = self.forget_visits();
        let mut scans = 0;
        self.decided(0, 0, profile::BEFORE_BYTES);
        for step in steps {
            let (pipeline, writes) = match *step {
                Step::Scan(ref pass) => (passes.passes[pipeline_index(pass.scan)], pass.writes),
                Step::AllPoints { writes } => (passes.passes[0], writes),
                Step::Tiles { .. } => (passes.passes[0], 0),
                Step::Settle { .. } => (self.pipelines.settle, 0),
                Step::Count => (self.pipelines.progress, 0),
                Step::Barrier => {
                    self.barrier(PASS, PASS);
                    continue;
                }
            };
            Scope::go_on(&mut open, self.watch(), || counter.next(step));
            if bound != Some((pipeline, writes)) {
                self.bind(pipeline, writes);
                bound = Some((pipeline, writes));
            }
            match *step {
                Step::Scan(ref pass) => {
                    self.scan(pass, if notes.contains(&scans) { scans as i32 } else { -1 });
                    scans += 1;
                }
                Step::AllPoints { .. } => {
                    self.dispatch_while(&texels, progress, offset::GRID_GROUPS)
                }
                Step::Tiles { round } => {
                    self.dispatch_while(&Round { texels, round }, progress, offset::round(round));
                    self.tile_list(round);
                }
                Step::Settle { rounds } => {
                    let [cols, rows] = self.grid.texels.tiles(self.pipelines.tuning.tile);
                    self.dispatch_groups(&Round { texels, round: rounds }, cols * rows);
                }
                Step::Count => self.dispatch_groups(&0u32, 1),
                Step::Barrier => {}
            }
        }
        drop(open);
        self.decided(profile::BEFORE_BYTES, 0, progress::BYTES);
    }

    /// After the steps of a plan, and what belongs to them.
    pub(crate) fn end_portion(&self) {
        if let Some(profile) = self.profile {
            profile.end_portion(self.device, self.commands);
        }
    }

    /// The dispatches of scans that are to note whether they have visited something: as many as there
    /// is room for, if a profile wants to know.
    fn forget_visits(&self) -> Range<u32> {
        if self.profile.and_then(Profile::decisions).is_none() {
            return 0..0;
        }
        self.barrier(PASS, CLEAR);
        self.fill(self.grid.progress.buffer, offset::VISITS, VISIT_BYTES);
        0..VISITS
    }

    /// Copies part of the progress to where a profile finds what the device has decided.
    fn decided(&self, to: u64, from: u64, size: u64) {
        let Some((buffer, offset)) = self.profile.and_then(Profile::decisions) else { return };
        let _pass = self.pass_of_copy(PassKind::Decisions, size);
        self.copy_for_host(self.grid.progress.buffer, from, (buffer, offset + to), size);
    }

    /// Copies the list of tiles of a round to where a profile finds it.
    fn tile_list(&self, round: u32) {
        let Some((buffer, offset)) = self.profile.and_then(Profile::tile_lists) else { return };
        let bytes = self.tile_bytes();
        let from = (2 + u64::from(round % 2)) * bytes;
        let to = (buffer, offset + u64::from(round) * bytes);
        self.copy_for_host(self.grid.tiles.buffer, from, to, bytes);
    }

    /// Bytes of one number for each tile.
    fn tile_bytes(&self) -> u64 {
        let [cols, rows] = self.grid.texels.tiles(self.pipelines.tuning.tile);
        u64::from(cols) * u64::from(rows) * size_of::<u32>() as u64
    }

    /// Blocks of lines of all scans, with those beyond the grid.
    fn block_words(&self) -> u64 {
        let pitch = self.grid.texels.block_pitch(self.pipelines.tuning.scan_lines);
        Scan::ALL.len() as u64 * u64::from(pitch)
    }

    fn copy_for_host(&self, from: vk::Buffer, start: u64, to: (vk::Buffer, u64), size: u64) {
        self.barrier(PASS, COPY);
        let copy = [vk::BufferCopy::default().src_offset(start).dst_offset(to.1).size(size)];
        // SAFETY: the progress and the tiles hold so much, and the host has said that its buffer
        // has room.
        unsafe { self.device.cmd_copy_buffer(self.commands, from, to.0, &copy) };
        let after = (PASS.0 | HOST_READ.0, PASS.1 | HOST_READ.1);
        self.barrier(TRANSFER, after);
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

    /// Writes part of a buffer, which has room for it; no more than 65 536 bytes, a multiple of 4.
    pub(crate) fn update(&self, buffer: vk::Buffer, offset: u64, bytes: &[u8]) {
        // SAFETY: the part lies in the buffer, which nothing else uses until the next barrier.
        unsafe { self.device.cmd_update_buffer(self.commands, buffer, offset, bytes) };
    }

    /// Copies part of a buffer to one that has room for it there, and does not overlap it.
    pub(crate) fn copy(&self, from: (vk::Buffer, u64), to: (vk::Buffer, u64), size: u64) {
        let copy = [vk::BufferCopy::default().src_offset(from.1).dst_offset(to.1).size(size)];
        // SAFETY: both buffers hold so many bytes there, of the host's as the host has promised.
        unsafe { self.device.cmd_copy_buffer(self.commands, from.0, to.0, &copy) };
    }

    /// Runs a pass that also sees something of the host's: so many invocations wide and high.
    pub(crate) fn host_pass(
        &self,
        pipeline: vk::Pipeline,
        set: vk::DescriptorSet,
        constants: &impl NoUninit,
        invocations: [u32; 2],
    ) {
        let (compute, stages) = (vk::PipelineBindPoint::COMPUTE, vk::ShaderStageFlags::COMPUTE);
        // The set that writes image 1 reads image 0.
        let (layout, sets) = (self.pipelines.host_layout, [self.grid.sets[1], set]);
        // SAFETY: pipeline, layout and sets belong together and are alive, and the layout has
        // room for the constants.
        unsafe {
            self.device.cmd_bind_pipeline(self.commands, compute, pipeline);
            self.device.cmd_bind_descriptor_sets(self.commands, compute, layout, 0, &sets, &[]);
            let constants = bytes_of(constants);
            self.device.cmd_push_constants(self.commands, layout, stages, 0, constants);
            let [x, y, z] = groups(invocations);
            self.device.cmd_dispatch(self.commands, x, y, z);
        }
    }

    /// Brings an image from one layout into another between two kinds of access.
    pub(crate) fn image_barrier(
        &self,
        image: vk::Image,
        before: barrier::Access,
        after: barrier::Access,
        layouts: (vk::ImageLayout, vk::ImageLayout),
    ) {
        barrier::image(self.device, self.commands, image, before, after, layouts);
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

    fn scan(&self, pass: &ScanPass, note: i32) {
        let tuning = self.pipelines.tuning;
        let block = Block { note, ..Block::of(pass, self.grid.texels, tuning.scan_lines) };
        if pass.always {
            self.dispatch_groups(&block, block.count.div_ceil(tuning.scan_texels()));
        } else {
            let number = 1 + (block.line - BORDER) / tuning.scan_lines;
            let number = pipeline_index(pass.scan) as u32 * block.pitch + number;
            let offset = u64::from(number) * size_of::<[u32; 3]>() as u64;
            self.dispatch_while(&block, self.grid.blocks.buffer, offset);
        }
    }

    pub(crate) fn barrier(&self, before: barrier::Access, after: barrier::Access) {
        barrier::memory(self.device, self.commands, before, after);
    }

    fn clear_fronts(&self) {
        for image in &self.grid.fronts {
            self.clear(image.image, TIME, FAR);
            self.clear(image.image, CURVATURE, 0.0);
        }
    }

    /// Fills a layer of an image.
    fn clear(&self, image: vk::Image, layer: u32, value: f64) {
        let value = vk::ClearColorValue { float32: [value as f32; 4] };
        let range =
            vk::ImageSubresourceRange { base_array_layer: layer, layer_count: 1, ..barrier::COLOR };
        // SAFETY: the image has the layer, is in this layout, and the layer is used by nothing else
        // until the next barrier.
        unsafe {
            let layout = vk::ImageLayout::GENERAL;
            self.device.cmd_clear_color_image(self.commands, image, layout, &value, &[range]);
        }
    }

    /// Zeroes part of a buffer.
    pub(crate) fn fill(&self, buffer: vk::Buffer, offset: u64, size: u64) {
        // SAFETY: the part lies in the buffer, which nothing else uses until the next barrier.
        unsafe { self.device.cmd_fill_buffer(self.commands, buffer, offset, size, 0) };
    }

    /// Writes part of the progress.
    fn write(&self, offset: u64, bytes: &[u8]) {
        self.update(self.grid.progress.buffer, offset, bytes);
    }

    fn bind(&self, pipeline: vk::Pipeline, writes: usize) {
        let compute = vk::PipelineBindPoint::COMPUTE;
        let (layout, sets) = (self.pipelines.layout, [self.grid.sets[writes]]);
        // SAFETY: pipeline, layout and set belong together and are alive.
        unsafe {
            self.device.cmd_bind_pipeline(self.commands, compute, pipeline);
            self.device.cmd_bind_descriptor_sets(self.commands, compute, layout, 0, &sets, &[]);
        }
    }

    /// Dispatches so many invocations wide and high, in groups along the width.
    fn dispatch(&self, constants: &impl NoUninit, invocations: [u32; 2]) {
        self.push(constants);
        let [x, y, z] = groups(invocations);
        // SAFETY: a pipeline with the common layout is bound.
        unsafe { self.device.cmd_dispatch(self.commands, x, y, z) };
    }

    fn dispatch_groups(&self, constants: &impl NoUninit, groups: u32) {
        self.push(constants);
        // SAFETY: a pipeline with the common layout is bound.
        unsafe { self.device.cmd_dispatch(self.commands, groups, 1, 1) };
    }

    /// Dispatches as many groups as a buffer says here.
    fn dispatch_while(&self, constants: &impl NoUninit, buffer: vk::Buffer, offset: u64) {
        self.push(constants);
        // SAFETY: a pipeline with the common layout is bound, and three numbers are at the offset.
        unsafe { self.device.cmd_dispatch_indirect(self.commands, buffer, offset) };
    }

    fn push(&self, constants: &impl NoUninit) {
        let (layout, stages) = (self.pipelines.layout, vk::ShaderStageFlags::COMPUTE);
        // SAFETY: the layout has room for the constants of every pass.
        unsafe {
            self.device.cmd_push_constants(self.commands, layout, stages, 0, bytes_of(constants));
        }
    }
}

/// The record of a dispatch of so many invocations wide and high, in groups along the width.
pub(crate) fn dispatched(kind: PassKind, invocations: [u32; 2]) -> PassRecord {
    PassRecord { groups: Some(groups(invocations)), ..PassRecord::new(kind) }
}

/// Groups of so many invocations wide and high.
fn groups([width, height]: [u32; 2]) -> [u32; 3] {
    [width.div_ceil(WORKGROUP), height, 1]
}

pub(super) fn pipeline_index(scan: Scan) -> usize {
    Scan::ALL.iter().position(|&other| other == scan).expect("all scans are listed")
}
