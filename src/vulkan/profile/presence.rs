//! Completes the records of passes with the decisions that the device has made.

use super::blocks::Blocks;
use super::decisions::Decisions;
use super::pass::PassRecord;
use super::work::Work;
use crate::constants::LAYERS;
use crate::vulkan::record::PassKind;

/// Bytes of a texel of four 32-bit numbers.
const TEXEL: u64 = 16;
/// Work of the count of an iteration: the bytes of the progress that `glsl/passes/progress.comp` reads and
/// writes.
/// It reads whether the map is done, the change, its tolerance, the iterations and their limit, the
/// iterations since a point was first reached, and whether fronts may be renewed. It writes the change, the
/// iterations, the iterations since a point was first reached, whether fronts may be renewed, and the last
/// iteration's change.
pub(super) const COUNT: Work = Work::of_bytes(4 * 7, 4 * 5);
/// Work of a count whose map was done before.
const COUNT_BEYOND: Work = Work::of_bytes(4, 0);
/// Additional work of a count that ends the map: it writes `done`.
const COUNT_LAST: Work = Work::of_bytes(0, 4);

/// Condition that decides whether a pass visits anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Presence {
    /// Unconditional: the pass is dispatched as recorded.
    Always,
    /// Visits the blocks of lines that are due.
    Scans(Blocks),
    /// An exchange between copies of points, which moves nothing if the map converged before.
    Exchange,
    /// The count that ends an iteration. It depends on whether the map converged before, and on whether this
    /// iteration was the last.
    Count,
    /// Settling of `tiles` tiles. It depends on how many texels lie in the other image after the rounds of
    /// the portion.
    Settle { tiles: u64 },
    /// A round of the portion. It depends on the round's list. The grid has `tiles` tiles of `texels` texels
    /// each.
    Round { round: u32, texels: u64, tiles: u64, curved: bool },
}

impl Presence {
    /// Combines the condition of a pass with that of the next pass of the same scan or iteration.
    pub(super) fn absorb(&mut self, next: Self) {
        if let (Self::Scans(blocks), Self::Scans(next)) = (self, next) {
            blocks.absorb(next);
        }
    }
}

/// Returns the record of a pass once the device's decisions are known.
pub(super) fn decided(
    record: PassRecord,
    presence: Presence,
    decisions: Option<&Decisions>,
) -> PassRecord {
    let Some(decisions) = decisions else {
        return match presence {
            Presence::Always => record,
            Presence::Count | Presence::Exchange | Presence::Settle { .. } => {
                PassRecord { work: Work::default(), ..record }
            }
            _ => PassRecord { groups: None, work: Work::default(), ..record },
        };
    };
    let Decisions { before, after, is_done, settled, .. } = *decisions;
    let number = record.iteration.unwrap_or(0);
    // If the portion is only a part of an iteration, it has no count, so `after` equals `before` although the
    // map goes on. Then `is_done` is not set.
    let is_beyond = is_done && number >= after - before;
    let record = PassRecord { iteration: record.iteration.map(|_| before + number), ..record };
    let record = match presence {
        Presence::Scans(blocks) if is_beyond => {
            let groups = Some([blocks.beyond(&record), 1, 1]);
            PassRecord { groups, work: record.work.none(), ..record }
        }
        Presence::Count | Presence::Exchange if is_beyond => {
            PassRecord { work: record.work.none(), ..record }
        }
        Presence::Always | Presence::Exchange | Presence::Count => record,
        Presence::Scans(blocks) => blocks
            .visited(record, &decisions.visits)
            .unwrap_or(PassRecord { groups: None, work: Work::default(), ..record }),
        Presence::Settle { tiles } => {
            let bytes = 4 * tiles + u64::from(LAYERS) * TEXEL * u64::from(settled);
            PassRecord { work: Work::of_bytes(bytes, bytes), ..record }
        }
        Presence::Round { round, texels, tiles, curved } => {
            let [listed, waited] =
                decisions.rounds.get(round as usize).copied().unwrap_or_default();
            let visited = listed - waited;
            let skipped = texels * (tiles - u64::from(visited));
            // Only the workgroup of a tile knows how many iterations the tile took inside.
            let work = Work::of_updates(texels * u64::from(visited), skipped, curved, None);
            PassRecord { groups: Some([listed, 1, 1]), work, ..record }
        }
    };
    let counts = match record.kind {
        PassKind::Count | PassKind::Iteration => true,
        // Records before the iterations have no number, and rounds of tiles have no count.
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
    PassRecord { work: record.work.and_bytes(more), ..record }
}
