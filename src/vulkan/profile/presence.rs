//! What becomes of the passes of a plan: what the device decides of them, and how they are counted as
//! they are recorded.

use super::blocks::Blocks;
use super::pass::{Area, PassKind, PassRecord};
use super::work::Work;
use crate::constants::LAYERS;
use crate::vulkan::plan::Scan;
use crate::vulkan::{TexelChart, Tuning};

/// Bytes of a texel of four 32-bit numbers.
const TEXEL: u64 = 16;
/// What a count of an iteration reads of the progress, and what it writes: `glsl/progress.comp`.
/// Whether the map is done, the change, its tolerance, iterations and their limit, those since a
/// point was first reached, and whether fronts may be renewed; without the first and both limits, and
/// with the last iteration's change.
const COUNT: Work = Work::of_bytes(4 * 7, 4 * 5);
/// What it reads if the map is done.
const COUNT_BEYOND: Work = Work::of_bytes(4, 0);
/// What it writes besides if the map is done now: that, and no groups for the grid.
const COUNT_LAST: Work = Work::of_bytes(0, 4 * 2);

/// What decides whether a pass visits anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Presence {
    /// Nothing: it is dispatched as recorded.
    Always,
    /// Which blocks of lines are due.
    Scans(Blocks),
    /// Whether the map has converged before the iteration of the portion.
    Iteration,
    /// The same of the count that ends an iteration, and whether it was the last.
    Count,
    /// How many texels of so many tiles lie in the other image after the rounds of the portion.
    Settle { tiles: u64 },
    /// The list of this round of the portion, of tiles of so many texels, so many in all.
    Round { round: u32, texels: u64, tiles: u64, curved: bool },
}

impl Presence {
    /// Of a pass with the next of the same scan or iteration.
    pub(crate) fn absorb(&mut self, next: Self) {
        if let (Self::Scans(blocks), Self::Scans(next)) = (self, next) {
            blocks.absorb(next);
        }
    }
}

/// What the device has decided in a portion of steps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Decisions<'a> {
    /// Iterations of the map before the portion.
    pub before: u32,
    /// And after it.
    pub after: u32,
    /// Whether the map is done then.
    pub is_done: bool,
    /// Tiles on the list of each round of the portion, and how many of them have waited for the next.
    pub rounds: &'a [[u32; 2]],
    /// Texels brought back to one image after them.
    pub settled: u32,
    /// A bit for each dispatch of a scan in the portion: whether it has visited its block.
    pub visits: &'a [u32],
}

/// The record of a pass once it is known what the device has decided.
pub(crate) fn decided(
    record: PassRecord,
    presence: Presence,
    decisions: Option<Decisions>,
) -> PassRecord {
    let Some(Decisions { before, after, is_done, rounds, settled, visits }) = decisions else {
        return match presence {
            Presence::Always => record,
            Presence::Count | Presence::Settle { .. } => {
                PassRecord { work: Work::default(), ..record }
            }
            _ => PassRecord { groups: None, work: Work::default(), ..record },
        };
    };
    let number = record.iteration.unwrap_or(0);
    // A part of an iteration has no count, and the map goes on.
    let is_beyond = is_done && number >= after - before;
    let record = PassRecord { iteration: record.iteration.map(|_| before + number), ..record };
    let record = match presence {
        Presence::Scans(blocks) if is_beyond => {
            let groups = Some([blocks.beyond(&record), 1, 1]);
            PassRecord { groups, work: record.work.none(), ..record }
        }
        Presence::Iteration if is_beyond => {
            PassRecord { groups: Some([0, 1, 1]), work: record.work.none(), ..record }
        }
        Presence::Count if is_beyond => PassRecord { work: record.work.none(), ..record },
        Presence::Always | Presence::Iteration | Presence::Count => record,
        Presence::Scans(blocks) => blocks.visited(record, visits).unwrap_or(PassRecord {
            groups: None,
            work: Work::default(),
            ..record
        }),
        Presence::Settle { tiles } => {
            let bytes = 4 * tiles + u64::from(LAYERS) * TEXEL * u64::from(settled);
            PassRecord { work: Work::of_bytes(bytes, bytes), ..record }
        }
        Presence::Round { round, texels, tiles, curved } => {
            let [listed, waited] = rounds.get(round as usize).copied().unwrap_or_default();
            let visited = listed - waited;
            let skipped = texels * (tiles - u64::from(visited));
            // How many iterations a tile has taken inside, only its workgroup knows.
            let work = Work::of_updates(texels * u64::from(visited), skipped, curved, None);
            PassRecord { groups: Some([listed, 1, 1]), work, ..record }
        }
    };
    let counts = match record.kind {
        PassKind::Count | PassKind::Iteration => true,
        // What comes before the iterations has no number, and rounds of tiles are not counted.
        PassKind::Portion => {
            record.iteration.is_some() && !matches!(presence, Presence::Round { .. })
        }
        _ => false,
    };
    if !counts {
        return record;
    }
    let more = match is_beyond {
        true => COUNT_BEYOND,
        false if is_done && before + number + 1 == after => COUNT_LAST,
        false => Work::of_bytes(0, 0),
    };
    PassRecord { work: record.work.and(more), ..record }
}

/// Counts the steps of a recording, in their order.
pub(crate) struct StepCounter {
    pub(crate) texels: TexelChart,
    pub(crate) tuning: Tuning,
    pub(crate) curved: bool,
    pub(crate) iteration: u32,
    /// Dispatches of scans so far.
    pub(crate) scans: u32,
    /// The scan of the last block of lines, and its iteration.
    pub(crate) last: Option<(u32, Scan)>,
}

impl StepCounter {
    pub(crate) fn new(texels: TexelChart, tuning: Tuning, curved: bool) -> Self {
        Self { texels, tuning, curved, iteration: 0, scans: 0, last: None }
    }

    /// A record of the iteration.
    pub(crate) fn inside(&self, kind: PassKind) -> PassRecord {
        PassRecord { iteration: Some(self.iteration), ..PassRecord::new(kind) }
    }

    /// The grid's texels.
    pub(crate) fn everywhere(&self) -> Area {
        Area::new(self.texels.inner_rows(), self.texels.inner_cols())
    }

    /// The count that ends an iteration.
    pub(crate) fn count(&mut self) -> (PassRecord, Presence) {
        let record =
            PassRecord { groups: Some([1; 3]), work: COUNT, ..self.inside(PassKind::Count) };
        self.iteration += 1;
        (record, Presence::Count)
    }
}
