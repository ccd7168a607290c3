//! The steps of a plan, and what a profile learns of them.

use ash::vk;
use bytemuck::NoUninit;

use super::Recorder;
use crate::constants::BORDER;
use crate::vulkan::TexelChart;
use crate::vulkan::barrier::{COPY, PASS, PASS_AND_HOST, TRANSFER};
use crate::vulkan::pipelines::SchedulePipelines;
use crate::vulkan::plan::{Scan, ScanPass, Step};
use crate::vulkan::profile::{self, PassKind, PassRecord, Profile, Scope, StepCounter, Work};
use crate::vulkan::progress::{VISITS, offset};

/// The constants of a block of lines of a scan.
#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
pub(in crate::vulkan) struct Block {
    line: u32,
    lines: u32,
    first: u32,
    pub(in crate::vulkan) count: u32,
    last: u32,
    pitch: u32,
    note: i32,
}

impl Block {
    pub(in crate::vulkan) fn of(pass: &ScanPass, texels: TexelChart, lines: u32) -> Self {
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

impl Recorder<'_> {
    /// Runs the steps of a plan.
    pub(crate) fn steps(&self, passes: &SchedulePipelines, steps: &[Step]) {
        let mut bound = None;
        let mut open: Option<Scope> = None;
        let texels = self.grid.texels.inner();
        let progress = self.grid.progress.buffer;
        let mut counter =
            StepCounter::new(self.grid.texels, self.pipelines.tuning, passes.has_two_layers);
        let notes = self.visits_noted(steps);
        let visits = u64::from(notes.div_ceil(32)) * size_of::<u32>() as u64;
        let mut scans = 0;
        self.decided_before(visits);
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
                    self.scan(pass, if scans < notes { scans as i32 } else { -1 });
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
        self.decided_after(visits);
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

    /// After the steps of a plan, and what belongs to them.
    pub(crate) fn end_portion(&self) {
        if let Some(profile) = self.profile {
            profile.end_portion(self.device, self.commands);
        }
    }

    /// How many dispatches of scans, the first ones, are to note whether they have visited something:
    /// as many as there is room for, if a profile wants to know.
    fn visits_noted(&self, steps: &[Step]) -> u32 {
        if self.profile.and_then(Profile::decisions).is_none() {
            return 0;
        }
        let scans = steps.iter().filter(|step| matches!(step, Step::Scan(_))).count();
        (scans as u32).min(VISITS)
    }

    /// Copies how the iterations have gone so far to where a profile finds it, and forgets so many
    /// bytes of visits.
    fn decided_before(&self, visits: u64) {
        let Some((buffer, offset)) = self.profile.and_then(Profile::decisions) else { return };
        let work = Work::of_bytes(profile::BEFORE_BYTES, profile::BEFORE_BYTES + visits);
        let _pass = self.pass_with(PassRecord { work, ..PassRecord::new(PassKind::Decisions) });
        let progress = self.grid.progress.buffer;
        self.barrier(PASS, TRANSFER);
        self.copy((progress, 0), (buffer, offset), profile::BEFORE_BYTES);
        if visits > 0 {
            self.fill(progress, offset::VISITS, visits);
        }
        self.barrier(TRANSFER, PASS_AND_HOST);
    }

    /// Copies what the device has decided by now, with so many bytes of visits.
    fn decided_after(&self, visits: u64) {
        let Some((buffer, offset)) = self.profile.and_then(Profile::decisions) else { return };
        let bytes = offset::VISITS + visits;
        let _pass = self.pass_of_copy(PassKind::Decisions, bytes);
        let to = (buffer, offset + profile::BEFORE_BYTES);
        self.copy_for_host(self.grid.progress.buffer, 0, to, bytes);
    }

    /// Copies the list of tiles of a round to where a profile finds it.
    fn tile_list(&self, round: u32) {
        let Some((buffer, offset)) = self.profile.and_then(Profile::tile_lists) else { return };
        let bytes = self.tile_bytes();
        let from = (2 + u64::from(round % 2)) * bytes;
        let to = (buffer, offset + u64::from(round) * bytes);
        self.copy_for_host(self.grid.tiles.buffer, from, to, bytes);
    }

    fn copy_for_host(&self, from: vk::Buffer, start: u64, to: (vk::Buffer, u64), size: u64) {
        self.barrier(PASS, COPY);
        self.copy((from, start), to, size);
        self.barrier(TRANSFER, PASS_AND_HOST);
    }
}

pub(in crate::vulkan) fn pipeline_index(scan: Scan) -> usize {
    Scan::ALL.iter().position(|&other| other == scan).expect("all scans are listed")
}
