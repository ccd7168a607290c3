//! Counts the work of the steps of plans, and the records that a profile keeps of them.

use super::blocks::Blocks;
use super::pass::{Area, Grain, PassRecord};
use super::presence::{COUNT, Presence};
use super::work::Work;
use crate::constants::WORKGROUP;
use crate::update::Wavefront;
use crate::vulkan::record::{PassKind, PlannedSteps, StepsOf};
use crate::vulkan::schedules::iteration::{Iteration, along, block_number};
use crate::vulkan::schedules::plan::{Scan, ScanPair, ScanPass, Step};
use crate::vulkan::{TexelChart, Tuning};

/// Counter of the steps of a recording, in their order.
pub(super) struct StepCounter {
    texels: TexelChart,
    tuning: Tuning,
    curved: bool,
    iteration: u32,
    /// Number of blocks of lines in the scans so far.
    scans: u32,
    /// Bytes that an exchange between copies of points reads and writes.
    exchanged: [u64; 2],
    /// Number of maps in the batch, if the steps are of a batch.
    batch: Option<u32>,
}

impl StepCounter {
    pub(super) fn new(steps: &PlannedSteps) -> Self {
        Self {
            texels: steps.texels,
            tuning: steps.tuning.on_grid(steps.texels),
            curved: steps.carries,
            iteration: 0,
            scans: 0,
            exchanged: steps.exchanged.unwrap_or_default(),
            batch: match steps.of {
                StepsOf::Map(_) => None,
                StepsOf::Batch(maps) => Some(maps),
            },
        }
    }

    /// Returns the record of the next step, and the condition that decides whether it visits anything. Steps of a batch
    /// have the work of one of its maps, and no condition.
    pub(super) fn next(&mut self, step: &Step) -> (PassRecord, Presence) {
        let (record, presence) = self.next_of_map(step);
        let Some(maps) = self.batch else { return (record, presence) };
        let groups = match step {
            Step::Count => Some([maps.div_ceil(WORKGROUP), 1, 1]),
            _ => record.groups.map(|[x, y, _]| [x, y, maps]),
        };
        (PassRecord { groups, ..record }, Presence::Always)
    }

    fn next_of_map(&mut self, step: &Step) -> (PassRecord, Presence) {
        let kind = PassKind::of(step);
        let iteration = Some(self.iteration);
        let record = PassRecord { dispatches: 1, iteration, ..PassRecord::new(kind) };
        let area = Some(Area::new(self.texels.inner_rows(), self.texels.inner_cols()));
        let alone = Some([1; 3]);
        match *step {
            Step::Scan(ref pass) => self.scan(pass, record),
            Step::Tiles { round } => {
                let (tiles, curved) = (self.tiles(), self.curved);
                let texels = u64::from(self.tuning.tile / 2).pow(2);
                let presence = Presence::Round { round, texels, tiles, curved };
                (PassRecord { iteration: Some(round), area, ..record }, presence)
            }
            Step::Settle { .. } => {
                let tiles = self.tiles();
                let groups = Some([tiles as u32, 1, 1]);
                (PassRecord { iteration: None, groups, ..record }, Presence::Settle { tiles })
            }
            Step::Exchange { next_round, .. } => {
                let [read, written] = self.exchanged;
                let work = Work::of_bytes(read, written);
                let iteration = next_round.map_or(iteration, |round| Some(round - 1));
                (PassRecord { iteration, groups: alone, work, ..record }, Presence::Exchange)
            }
            Step::Count => {
                self.iteration += 1;
                (PassRecord { groups: alone, work: COUNT, ..record }, Presence::Count)
            }
        }
    }

    /// Returns the number of tiles.
    fn tiles(&self) -> u64 {
        self.texels.tiles(self.tuning.tile).into_iter().map(u64::from).product()
    }

    fn scan(&mut self, pass: &ScanPass, record: PassRecord) -> (PassRecord, Presence) {
        let Self { texels, tuning, curved, .. } = *self;
        let lines = match pass.scan {
            Scan::Down | Scan::Right => pass.line..pass.line + pass.lines,
            Scan::Up | Scan::Left => pass.line + 1 - pass.lines..pass.line + 1,
        };
        let area = match ScanPair::of(pass.scan) {
            ScanPair::DownUp => Area::new(lines, pass.texels.clone()),
            ScanPair::RightLeft => Area::new(pass.texels.clone(), lines),
        };
        let length = along(texels, pass.scan).len() as u32;
        let visited = u64::from(pass.lines) * pass.texels.len() as u64;
        let skipped = u64::from(length) * u64::from(pass.lines + pass.left_out) - visited;
        // Indirect dispatches have the workgroups of a whole line. Others have those of the texels within bounds.
        let dispatched = if pass.always { pass.texels.len() as u32 } else { length };
        let record = PassRecord {
            area: Some(area),
            groups: Some([dispatched.div_ceil(tuning.scan_texels()), 1, 1]),
            work: Work::of_scan(visited, skipped, curved),
            ..record
        };
        let (first, count) = (self.scans, pass.blocks(tuning.scan_lines));
        self.scans += count;
        if pass.always {
            return (record, Presence::Always);
        }
        let (scan, pairs) = (pass.scan, pass.middle.is_some());
        let in_turn = Scan::ALL.map(|other| {
            let same = other == scan || pairs && ScanPair::of(other) == ScanPair::of(scan);
            same && pass.in_turn
        });
        let block = block_number(pass, tuning.scan_lines);
        let order = Iteration { texels, lines: tuning.scan_lines, in_turn, pairs };
        let group = tuning.scan_texels();
        let blocks = Blocks { order, group, curved, scan, block, first, count };
        (record, Presence::Scans(blocks))
    }
}

/// Returns the number of records that the steps make. Whether an iteration comes after convergence is known only later,
/// so a portion reserves a record for each of its iterations.
pub(crate) fn records(steps: &[Step], grain: Grain) -> u32 {
    let grain = if grain == Grain::Portions { Grain::Iterations } else { grain };
    // A count ends each iteration, so adjacent steps of a kind are in one iteration.
    let merged = steps.windows(2).filter(|pair| {
        let kind = |step| grain.kind(PassKind::of(step));
        let (first, next) = (kind(&pair[0]), kind(&pair[1]));
        grain.gathers(first) && first == next && pair[0] != Step::Count
    });
    (steps.len() - merged.count()) as u32
}

/// Returns the passes of a plan with their work, without times. Each pass counts as if the map had not converged before
/// it. The work of rounds of tiles is missing, since a plan does not determine which tiles they visit.
///
/// ```
/// use geosweep::Wavefront;
/// use geosweep::surface::Chart;
/// use geosweep::vulkan::{Schedule, TexelChart, Tuning, planned};
/// let texels = TexelChart::new(Chart { rows: 256, cols: 256 }).unwrap();
/// let tuning = Tuning::ON_CPU;
/// let portions = tuning.portions(Wavefront::Planar, texels);
/// let steps = Schedule::Raster.plan(texels, portions, None, 1);
/// let passes = planned(&steps, texels, tuning, Wavefront::Planar);
/// // Four scans of 32 blocks each, and the count. A texel of four points is read and written,
/// // and has 64 bytes of edge lengths.
/// assert_eq!(passes.len(), 4 * 32 + 1);
/// assert_eq!(passes[0].work.texels, Some(4 * 128));
/// assert_eq!(passes[0].work.bytes(), Some(4 * 128 * (2 * 16 + 64)));
/// ```
pub fn planned(
    steps: &[Step],
    texels: TexelChart,
    tuning: Tuning,
    wavefront: Wavefront,
) -> Vec<PassRecord> {
    let (carries, of) = (wavefront.has_two_layers(), StepsOf::Batch(1));
    let mut counter =
        StepCounter::new(&PlannedSteps { steps, texels, tuning, carries, exchanged: None, of });
    steps.iter().map(|step| counter.next(step).0).collect()
}
