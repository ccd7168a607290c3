//! What passes have to move and compute, counted from the plan, and from what the device has
//! decided where that is read back.
//!
//! Counted is what the update of a point needs by itself, once: what workgroups compute twice at
//! their borders is not added, and what caches save is not subtracted. `docs/speed.md` compares
//! the same counts with a device's ceilings.

use std::ops::Range;

use super::blocks::Blocks;
use super::pass::{Area, Grain, PassKind, PassRecord};
use crate::constants::{LAYERS, WORKGROUP};
use crate::update::Wavefront;
use crate::vulkan::plan::{Scan, ScanPass, Step};
use crate::vulkan::upload::SeedTexel;
use crate::vulkan::{TexelChart, Tuning};

/// Bytes, texels and updates of a pass; `None` for what is not known, or not counted for passes of
/// its kind.
///
/// What is moved, in numbers of 4 bytes. One counts once for the texel, place or map that needs it,
/// however many invocations look at it:
///
/// | pass | reads | writes |
/// |---|---|---|
/// | prepare, forget | | the images, their border too |
/// | points | of each point what is looked at | that and its slowness |
/// | edges | the points around the band | four lengths a point |
/// | curvature | four lengths a point; in the second pass a number more | a number a point |
/// | start | | the progress, and four numbers a tile; many maps at once: a copy of their progress |
/// | resume | a number | the progress of rounds, and a number a tile |
/// | sources | as a dispatch four numbers each | ten for each of four texels; as a copy four each |
/// | surroundings | four numbers a source, and of each of 100 texels around it its times and 16 lengths; with curved fronts their curvature and the surface's | ten for each of these texels |
/// | seed | ten numbers a texel, both layers of its fronts | its fronts; many maps at once: those of all |
/// | scans, all points, tiles | a texel's times and 16 lengths; with curved fronts their curvature and the surface's | times; with curved fronts their curvature |
/// | settle | a number a tile, and both layers of the texels that are brought back | the same |
/// | count | of a map that goes on seven numbers of its progress, of one that is done one | five, and two more if it is done now; or none |
/// | fans | the numbers of each pair's fan | the same |
/// | workgroups | the fans of all pairs in all scans, and maps that were begun before | distances, or maps to go on with |
/// | decisions, outcome | what is copied | the same |
/// | distances, unpack | each point's time | the same |
/// | lookup | of each place two numbers, and four times around it | a distance |
/// | contours: counts | each point's time | a number for each row of cells, and for each of its 64 strips |
/// | their offsets | a number for each row of cells | the same, and six of the record |
/// | their segments | times and numbers again | `None`: as many as the device finds |
/// | paths: starts | of each two numbers and four times, and four numbers of each source | 24 numbers for each that there is room for, three for each start |
/// | their steps | `None`: as many as the device takes | `None` |
/// | lift | `None`: as many vertices as the device has found | `None` |
/// | regions: as a clear | | two numbers a point |
/// | their sources, twice | four numbers each | `None`: as many points as lie around them |
/// | the beginnings of ways | of each point two numbers, its time and four lengths; with curved fronts their curvature and the surface's | three numbers |
/// | the ways, then what is left | `None`: as many points as the ways lead past | `None` |
///
/// With many maps at once, the count by which one is done reads and writes how many are pending and
/// writes that this one is not, and with the last of them two numbers more, in place of the two.
///
/// Where a place may be bad, it counts as if it were good: sources lie inside cells, the texels around one,
/// four or 100, lie on the grid and are no other source's, places looked up and starts lie on the grid where
/// the map is reached, and there is room for all contours. Not counted is what depends on where things lie,
/// and is little beside the rest: the lengths of edges around a source, the tiles that seeds and rounds put
/// on lists, the levels that a search for contours looks at, and the numbers by which rounds are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Texels visited, of 2 x 2 points each. Tiles count whole, also where they reach beyond the
    /// grid.
    pub texels: Option<u64>,
    /// Texels that a pass without bounds would have visited as well: the gain of the paper's
    /// scissor test, of lists of tiles, and of passes beyond convergence. The lines that a scan
    /// passes over before its first block count to that block.
    pub skipped: Option<u64>,
    /// Bytes read.
    pub bytes_read: Option<u64>,
    /// Bytes written.
    pub bytes_written: Option<u64>,
    /// Updates of a point from one triangle.
    pub triangles: Option<u64>,
}

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
/// Triangles of a point that a scan sees, times the points of a texel.
const SCAN_TRIANGLES: u64 = 4 * 2;
const ALL_TRIANGLES: u64 = 4 * 8;

impl Work {
    /// Bytes read and written.
    pub fn bytes(&self) -> Option<u64> {
        Some(self.bytes_read? + self.bytes_written?)
    }

    /// Of both, the other of the same kind or a count of an iteration, which visits no texels.
    pub(crate) fn and(self, other: Self) -> Self {
        let sum = |a: Option<u64>, b: Option<u64>| Some(a? + b?);
        let visits = |a: Option<u64>, b: Option<u64>| Some(a? + b.unwrap_or(0));
        Self {
            texels: visits(self.texels, other.texels),
            skipped: visits(self.skipped, other.skipped),
            bytes_read: sum(self.bytes_read, other.bytes_read),
            bytes_written: sum(self.bytes_written, other.bytes_written),
            triangles: visits(self.triangles, other.triangles),
        }
    }

    /// Nothing but bytes.
    pub(crate) const fn of_bytes(read: u64, written: u64) -> Self {
        Self {
            texels: None,
            skipped: None,
            bytes_read: Some(read),
            bytes_written: Some(written),
            triangles: None,
        }
    }

    /// Of texels that are updated: arrival times of the texel's points read and written and the
    /// lengths of their edges read; with curved fronts their curvature and the surface's as well.
    fn of_updates(texels: u64, skipped: u64, curved: bool, triangles: Option<u64>) -> Self {
        let layers = if curved { 2 } else { 1 };
        let read = TEXEL * (layers + 4 + u64::from(curved));
        Self {
            texels: Some(texels),
            skipped: Some(skipped),
            bytes_read: Some(texels * read),
            bytes_written: Some(texels * layers * TEXEL),
            triangles: triangles.map(|each| texels * each),
        }
    }

    /// Of texels that a scan updates.
    pub(super) fn of_scan(texels: u64, skipped: u64, curved: bool) -> Self {
        Self::of_updates(texels, skipped, curved, Some(SCAN_TRIANGLES))
    }

    /// Of the texels around so many sources, so many around each, which are read once, updated as often as it
    /// takes, and written as seeds.
    pub(crate) fn of_surroundings(sources: u64, each: u64, curved: bool) -> Self {
        let Self { bytes_read, .. } = Self::of_updates(sources * each, 0, curved, None);
        let places = sources * size_of::<[f32; 4]>() as u64;
        let seeds = sources * each * SeedTexel::BYTES;
        Self { bytes_read: bytes_read.map(|read| read + places), ..Self::of_bytes(0, seeds) }
    }

    /// The same, but for texels that have not been visited.
    pub(super) fn without(self, unvisited: Self) -> Self {
        let less = |a: Option<u64>, b: Option<u64>| Some(a? - b?);
        Self {
            texels: less(self.texels, unvisited.texels),
            skipped: self.skipped.zip(unvisited.texels).map(|(a, b)| a + b),
            bytes_read: less(self.bytes_read, unvisited.bytes_read),
            bytes_written: less(self.bytes_written, unvisited.bytes_written),
            triangles: less(self.triangles, unvisited.triangles),
        }
    }

    /// What one map takes, of so many of `all` maps of a batch that visit the same texels.
    pub(crate) fn of_maps(self, maps: u64, all: u64) -> Self {
        let each = |count: Option<u64>| Some(count? * maps);
        let texels = each(self.texels);
        let everywhere = self.texels.zip(self.skipped).map(|(texels, skipped)| texels + skipped);
        Self {
            texels,
            skipped: everywhere.zip(texels).map(|(each, visited)| each * all - visited),
            bytes_read: each(self.bytes_read),
            bytes_written: each(self.bytes_written),
            triangles: each(self.triangles),
        }
    }

    /// Of the same texels, none visited.
    fn none(self) -> Self {
        let skipped = self.texels.zip(self.skipped).map(|(texels, skipped)| texels + skipped);
        let zero = |count: Option<u64>| count.map(|_| 0);
        Self {
            texels: zero(self.texels),
            skipped,
            bytes_read: zero(self.bytes_read),
            bytes_written: zero(self.bytes_written),
            triangles: zero(self.triangles),
        }
    }
}

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
    pub(super) fn absorb(&mut self, next: Self) {
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
    /// Tiles visited in each round of the portion.
    pub rounds: &'a [u32],
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
    let is_beyond = number >= after - before;
    let record = PassRecord { iteration: record.iteration.map(|_| before + number), ..record };
    let record = match presence {
        Presence::Iteration | Presence::Scans(_) if is_beyond => {
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
            let visited = rounds.get(round as usize).copied().unwrap_or(0);
            let skipped = texels * (tiles - u64::from(visited));
            // How many iterations a tile has taken inside, only its workgroup knows.
            let work = Work::of_updates(texels * u64::from(visited), skipped, curved, None);
            PassRecord { groups: Some([visited, 1, 1]), work, ..record }
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
    texels: TexelChart,
    tuning: Tuning,
    curved: bool,
    iteration: u32,
    /// Dispatches of scans so far, and before this iteration.
    scans: u32,
    first_scan: u32,
    last: Option<(u32, Scan)>,
}

impl StepCounter {
    pub(crate) fn new(texels: TexelChart, tuning: Tuning, curved: bool) -> Self {
        Self { texels, tuning, curved, iteration: 0, scans: 0, first_scan: 0, last: None }
    }

    /// The next step; barriers are none.
    pub(crate) fn next(&mut self, step: &Step) -> (PassRecord, Presence) {
        let [cols, rows] = self.texels.inner();
        let all = u64::from(cols) * u64::from(rows);
        let everywhere = Area::new(self.texels.inner_rows(), self.texels.inner_cols());
        let inside =
            PassRecord { iteration: Some(self.iteration), ..PassRecord::new(PassKind::Count) };
        match step {
            Step::Scan(pass) => self.scan(pass),
            Step::AllPoints { .. } => {
                let record = PassRecord {
                    kind: PassKind::AllPoints,
                    area: Some(everywhere),
                    groups: Some([cols.div_ceil(WORKGROUP), rows, 1]),
                    work: Work::of_updates(all, 0, self.curved, Some(ALL_TRIANGLES)),
                    ..inside
                };
                (record, Presence::Iteration)
            }
            &Step::Tiles { round } => {
                self.iteration += 1;
                let record = PassRecord {
                    kind: PassKind::Tiles,
                    iteration: Some(round),
                    area: Some(everywhere),
                    ..inside
                };
                let texels = u64::from(self.tuning.tile / 2).pow(2);
                let (tiles, curved) = (self.tiles(), self.curved);
                (record, Presence::Round { round, texels, tiles, curved })
            }
            Step::Settle { .. } => {
                let tiles = self.tiles();
                let groups = Some([tiles as u32, 1, 1]);
                let record =
                    PassRecord { kind: PassKind::Settle, iteration: None, groups, ..inside };
                (record, Presence::Settle { tiles })
            }
            Step::Count => {
                self.iteration += 1;
                self.first_scan = self.scans;
                (PassRecord { groups: Some([1; 3]), work: COUNT, ..inside }, Presence::Count)
            }
            Step::Barrier => (PassRecord { iteration: None, ..inside }, Presence::Always),
        }
    }

    fn tiles(&self) -> u64 {
        let [cols, rows] = self.texels.tiles(self.tuning.tile);
        u64::from(cols) * u64::from(rows)
    }

    fn scan(&mut self, pass: &ScanPass) -> (PassRecord, Presence) {
        let (inner_rows, inner_cols) = (self.texels.inner_rows(), self.texels.inner_cols());
        let forward = matches!(pass.scan, Scan::Down | Scan::Right);
        let block = if forward {
            pass.line..pass.line + pass.lines
        } else {
            pass.line + 1 - pass.lines..pass.line + 1
        };
        let by_rows = matches!(pass.scan, Scan::Down | Scan::Up);
        let (inner_lines, length) = if by_rows {
            (inner_rows, inner_cols.len() as u64)
        } else {
            (inner_cols, inner_rows.len() as u64)
        };
        let is_first = self.last != Some((self.iteration, pass.scan));
        self.last = Some((self.iteration, pass.scan));
        let passed_over = match is_first {
            false => 0,
            true if forward => block.start - inner_lines.start,
            true => inner_lines.end - block.end,
        };
        let visited = u64::from(pass.lines) * pass.texels.len() as u64;
        let skipped = length * u64::from(pass.lines + passed_over) - visited;
        let area = if by_rows {
            Area::new(block, pass.texels.clone())
        } else {
            Area::new(pass.texels.clone(), block)
        };
        let width = |range: &Range<u32>| range.len() as u32;
        // Passes that are dispatched indirectly have the groups of a whole line.
        let along = if pass.always { width(&pass.texels) } else { length as u32 };
        let record = PassRecord {
            iteration: Some(self.iteration),
            area: Some(area),
            groups: Some([along.div_ceil(self.tuning.scan_texels()), 1, 1]),
            work: Work::of_scan(visited, skipped, self.curved),
            ..PassRecord::new(PassKind::Scan(pass.scan))
        };
        let (texels, tuning, curved) = (self.texels, self.tuning, self.curved);
        let (iteration, first) = (self.first_scan, self.scans);
        self.scans += 1;
        let presence = match pass.always {
            true => Presence::Always,
            false => Presence::Scans(Blocks { texels, tuning, curved, iteration, first, count: 1 }),
        };
        (record, presence)
    }
}

/// How many records the steps make.
pub(crate) fn records(steps: &[Step], grain: Grain) -> u32 {
    let steps: Vec<_> = steps.iter().filter(|step| **step != Step::Barrier).collect();
    // Iterations end with a count, so that no scan follows one of the same direction.
    let merged = steps.windows(2).filter(|pair| match (grain, pair[0], pair[1]) {
        // What happens in an iteration beyond convergence is only known later, so that a portion
        // takes room for all of its iterations.
        (Grain::Iterations | Grain::Portions, Step::Scan(_) | Step::AllPoints { .. }, _) => true,
        (Grain::Scans, Step::Scan(before), Step::Scan(after)) => before.scan == after.scan,
        _ => false,
    });
    (steps.len() - merged.count()) as u32
}

/// The passes of a plan, each as if the map had not converged before it, without times. What rounds
/// of tiles visit is not known from the plan.
///
/// ```
/// use geosweep::Wavefront;
/// use geosweep::surface::Chart;
/// use geosweep::vulkan::{Schedule, TexelChart, Tuning, plan, profile};
/// let texels = TexelChart::new(Chart { rows: 64, cols: 64 }).unwrap();
/// let tuning = Tuning { scan_width: 64, scan_lines: 4, tile: 16, inner: 4 };
/// let portions = tuning.portions(Wavefront::Planar, texels);
/// let steps = plan::recording(Schedule::Raster, texels, portions, None, 1);
/// let passes = profile::planned(&steps, texels, tuning, Wavefront::Planar);
/// // Four scans of eight blocks each, and the count. A texel of four points is read and written,
/// // and has 64 bytes of edge lengths.
/// assert_eq!(passes.len(), 4 * 8 + 1);
/// assert_eq!(passes[0].work.texels, Some(4 * 32));
/// assert_eq!(passes[0].work.bytes(), Some(4 * 32 * (2 * 16 + 64)));
/// ```
pub fn planned(
    steps: &[Step],
    texels: TexelChart,
    tuning: Tuning,
    wavefront: Wavefront,
) -> Vec<PassRecord> {
    let mut counter = StepCounter::new(texels, tuning, wavefront.has_two_layers());
    let passes = steps.iter().filter(|step| **step != Step::Barrier);
    passes.map(|step| counter.next(step).0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::VISIT_WORDS;
    use crate::surface::Chart;
    use crate::vulkan::{Schedule, plan};

    const TUNING: Tuning = Tuning { scan_width: 64, scan_lines: 4, tile: 16, inner: 4 };

    fn passes(schedule: Schedule, wavefront: Wavefront) -> Vec<(PassRecord, Presence)> {
        let texels = TexelChart::new(Chart { rows: 20, cols: 33 }).unwrap();
        let portions = TUNING.portions(wavefront, texels);
        let steps = plan::recording(schedule, texels, portions, None, 2);
        let mut counter = StepCounter::new(texels, TUNING, wavefront.is_curved());
        let passes = steps.iter().filter(|step| **step != Step::Barrier);
        passes.map(|step| counter.next(step)).collect()
    }

    #[test]
    fn passes_beyond_convergence_skip_what_they_were_recorded_for() {
        let visits = [u32::MAX; VISIT_WORDS as usize];
        let before = Decisions { before: 7, after: 8, ..Decisions::default() };
        let decisions = Decisions { is_done: true, visits: &visits, ..before };
        for schedule in [Schedule::Raster, Schedule::AllPoints] {
            for (record, presence) in passes(schedule, Wavefront::Planar) {
                let after = decided(record, presence, Some(decisions));
                assert_eq!(after.iteration, record.iteration.map(|iteration| 7 + iteration));
                if presence == Presence::Count {
                    // Seven numbers are looked at and five written, two more at the end; or one is.
                    let found = after.work.bytes_read.zip(after.work.bytes_written);
                    let last = record.iteration == Some(0);
                    assert_eq!(found, Some(if last { (4 * 7, 4 * (5 + 2)) } else { (4, 0) }));
                    assert!(!after.is_idle());
                } else if record.iteration == Some(0) {
                    assert_eq!((after.work, after.is_idle()), (record.work, false));
                } else {
                    assert_eq!((after.work.texels, after.is_idle()), (Some(0), true));
                    assert_eq!(after.work.bytes(), Some(0));
                    let all = record.work.texels.zip(record.work.skipped).map(|(a, b)| a + b);
                    assert_eq!(after.work.skipped, all);
                }
                let unknown = decided(record, presence, None);
                assert_eq!(unknown.work, Work::default());
                assert_eq!(unknown.groups.is_some(), presence == Presence::Count);
            }
        }
    }

    /// Ten rows of texels and seventeen columns in blocks of four; the device has visited the last two
    /// rows in both scans, and in the scan left the last column.
    #[test]
    fn blocks_that_were_not_due_are_skipped() {
        let mut visits = [0; VISIT_WORDS as usize];
        // Three blocks down, three up, five right and five left.
        for number in [2, 3, 11] {
            visits[0] |= 1 << number;
        }
        let decisions = Decisions { after: 2, visits: &visits, ..Decisions::default() };
        for wavefront in Wavefront::ALL {
            let (mut visited, mut skipped) = ([0; 4], [0; 4]);
            for (number, (record, presence)) in
                passes(Schedule::Raster, wavefront).into_iter().enumerate().take(16)
            {
                let found = decided(record, presence, Some(decisions));
                assert_eq!(found.is_idle(), ![2, 3, 11].contains(&number), "{number}");
                let PassKind::Scan(scan) = found.kind else { panic!("{found:?}") };
                visited[scan as usize] += found.work.texels.unwrap();
                skipped[scan as usize] += found.work.skipped.unwrap();
                let each = if wavefront.is_curved() { 144 } else { 96 };
                assert_eq!(found.work.bytes(), found.work.texels.map(|texels| texels * each));
                assert_eq!(found.work.triangles, found.work.texels.map(|texels| texels * 8));
            }
            assert_eq!(visited, [2 * 17, 2 * 17, 0, 10]);
            assert_eq!(skipped, visited.map(|texels| 10 * 17 - texels));
            let merged = passes(Schedule::Raster, wavefront).into_iter().take(16);
            let (record, presence) = merged
                .reduce(|(mut record, mut presence), (next, following)| {
                    record.absorb(&next);
                    presence.absorb(following);
                    (record, presence)
                })
                .unwrap();
            let found = decided(record, presence, Some(decisions));
            assert_eq!(found.work.texels, Some(4 * 17 + 10));
            assert_eq!(found.work.skipped, Some(4 * 10 * 17 - (4 * 17 + 10)));
            assert_eq!((found.groups, found.dispatches), (Some([3, 1, 1]), 16));
        }
    }

    #[test]
    fn records_of_scans_hold_all_their_blocks() {
        let texels = TexelChart::new(Chart { rows: 20, cols: 33 }).unwrap();
        let portions = TUNING.portions(Wavefront::Planar, texels);
        let steps = |schedule| plan::recording(schedule, texels, portions, None, 2);
        // Ten rows of texels and seventeen columns in blocks of four.
        let raster = steps(Schedule::Raster);
        assert_eq!(records(&raster, Grain::Blocks), 2 * (2 * 3 + 2 * 5 + 1));
        assert_eq!(records(&raster, Grain::Scans), 2 * (4 + 1));
        for schedule in [Schedule::AllPoints, Schedule::Tiles] {
            let steps = steps(schedule);
            assert_eq!(records(&steps, Grain::Scans), records(&steps, Grain::Blocks));
        }
        let of_iterations = |schedule| records(&steps(schedule), Grain::Iterations);
        assert_eq!(Schedule::ALL.map(of_iterations), [2, 2, 2 + 1], "two rounds and their end");
    }

    #[test]
    fn tiles_are_as_many_as_the_device_has_listed() {
        let rounds = [2, 0];
        let decisions = Decisions {
            before: 3,
            after: 4,
            is_done: true,
            rounds: &rounds,
            settled: 37,
            visits: &[],
        };
        let found: Vec<_> = passes(Schedule::Tiles, Wavefront::Curved)
            .into_iter()
            .map(|(record, presence)| decided(record, presence, Some(decisions)))
            .collect();
        // Two rounds of 2 x 3 tiles of 8 x 8 texels, then what settles them.
        assert_eq!(found.len(), 3);
        let bytes = Some(2 * 64 * (2 * 16 + 16 + 64 + 2 * 16));
        assert_eq!((found[0].work.texels, found[0].work.skipped), (Some(2 * 64), Some(4 * 64)));
        assert_eq!((found[0].work.bytes(), found[0].work.triangles), (bytes, None));
        assert_eq!((found[0].groups, found[0].iteration), (Some([2, 1, 1]), Some(3)));
        assert!(found[1].is_idle() && found[1].iteration == Some(4));
        assert_eq!((found[2].kind, found[2].groups), (PassKind::Settle, Some([6, 1, 1])));
        // A state of each tile, and eight numbers of each texel that is brought back, both ways.
        assert_eq!(found[2].work.bytes(), Some(2 * (6 * 4 + 37 * 2 * 16)));
    }
}
