//! Plans and records the schedule of tiles: rounds of scans inside the tiles beside which something has
//! changed.

use super::order::{ScheduleKind, Steps};
use super::plan::{Portions, Reached, Step};
use super::progress;
use super::progress::offset;
use crate::constants::ROUNDS;
use crate::vulkan::TexelChart;
use crate::vulkan::device::barrier::{PASS, TRANSFER, TRANSFER_READ, TRANSFER_WRITE};
use crate::vulkan::device::passes::{SETTLE, TILES};
use crate::vulkan::device::shaders::{settle, tiles};
use crate::vulkan::record::{Groups, PassKind, Recorder};

pub(super) struct Tiles;

/// Number of rounds of a recording in addition to one for each tile along both sides of the grid. Fronts from a
/// corner of the grid cross one side of a tile in a round, and settle in one or two more rounds. A round without
/// tiles costs a GPU 4 us, and another submission 100 us or more.
const ROUNDS_TO_SETTLE: u32 = 4;

/// Returns an estimate of the average number of tiles that a round visits, divided by the number of tiles along both
/// sides of the grid. `tile` is the number of points on a side of a tile. Measured with curved fronts: with tiles of 16
/// points, 2.2 and 3.4 on spheres of 256 and 512 points a side, and 1.1 in a maze of 1024; with tiles of 32 points, 1.5
/// on a sphere of 1200.
fn tiles_in_a_round(tile: u32) -> u32 {
    if tile > 16 { 2 } else { 4 }
}

impl ScheduleKind for Tiles {
    fn passes(&self) -> &'static [usize] {
        const PASSES: [usize; 1] = [TILES.number()];
        &PASSES
    }

    fn has_rounds(&self) -> bool {
        true
    }

    fn plan(
        &self,
        texels: TexelChart,
        portions: Portions,
        _: Option<Reached>,
        most: u32,
    ) -> Vec<Step> {
        let across: u32 = texels.tiles(portions.tile).iter().sum();
        let wanted = portions.rounds.unwrap_or(across.max(4) + ROUNDS_TO_SETTLE);
        let rounds = wanted.min(ROUNDS).next_multiple_of(2).min(most);
        let all = (0..rounds).map(|round| Step::Tiles { round });
        all.chain([Step::Settle { rounds }]).collect()
    }

    fn together(&self, texels: TexelChart, portions: Portions) -> u32 {
        let across: u32 = texels.tiles(portions.tile).iter().sum();
        let of_round = u64::from(across * tiles_in_a_round(portions.tile))
            * u64::from(portions.tile / 2).pow(2);
        let rounds = portions.visits / of_round / 2 * 2;
        rounds.clamp(2, ROUNDS.into()) as u32
    }

    /// Turns the list of tiles that the last recording has left into the list of the first round.
    fn go_on(&self, recorder: &Recorder) {
        let (list, tiles) = (offset::round(1) - offset::round(0), recorder.tile_bytes());
        let _pass = recorder.pass(PassKind::Resume);
        let progress = recorder.grid.progress.buffer;
        recorder.barrier(PASS, TRANSFER);
        // `settle.comp` has put the list into the last entry, `ROUNDS`, whatever the number of rounds in its recording.
        let (from, to) = (offset::round(ROUNDS), offset::round(0));
        recorder.copy((progress, from), (progress, to), list);
        recorder.barrier(TRANSFER_READ, TRANSFER_WRITE);
        recorder.write_progress(&progress::before_rounds(recorder.tiles()), offset::round(1));
        // The command clears the rounds for which tiles are listed. The tiles' states are zero after `settle.comp`, and
        // the lists stay.
        recorder.fill(recorder.grid.tiles.buffer, tiles, tiles);
        recorder.barrier(TRANSFER_WRITE, PASS);
    }

    fn record(&self, recording: &mut Steps, step: &Step) {
        let recorder = recording.recorder;
        let grid = recorder.grid;
        let texels = grid.texels.inner().map(|texels| texels as i32);
        match *step {
            Step::Tiles { round } => {
                let groups = Groups::From(grid.progress.buffer, offset::round(round));
                recording.dispatch(TILES, 0, &tiles::Push { texels, round }, groups);
            }
            Step::Settle { rounds: count } => {
                let groups = Groups::in_columns(recorder.tiles());
                let tile_texels = recorder.tile() as i32 / 2;
                let settle = settle::Push { texels, count, tile_texels };
                recording.dispatch(SETTLE.pass(), 0, &settle, groups);
            }
            _ => {}
        }
    }
}
