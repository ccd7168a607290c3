//! Counts the work of a plan's steps, and the records that a profile keeps of them.

use super::order_of;
use super::plan::Step;
use crate::update::Wavefront;
use crate::vulkan::profile::{Grain, PassRecord, Presence, StepCounter};
use crate::vulkan::{TexelChart, Tuning};

/// Returns the record of the next step of a recording.
pub(in crate::vulkan) fn account(counter: &mut StepCounter, step: &Step) -> (PassRecord, Presence) {
    match order_of(step) {
        Some(order) => order.account(counter, step),
        None => match *step {
            Step::Exchange { next_round, .. } => counter.exchange(next_round),
            _ => counter.count(),
        },
    }
}

/// Returns the number of records that the steps make.
pub(crate) fn records(steps: &[Step], grain: Grain) -> u32 {
    // A count ends each iteration, so adjacent steps with the same scan are always blocks of one scan.
    let merged = steps.windows(2).filter(|pair| match &pair[0] {
        Step::Scan(before) => match grain {
            // Whether an iteration comes after convergence is known only later. So a portion reserves a record for
            // each of its iterations.
            Grain::Iterations | Grain::Portions => true,
            Grain::Scans => matches!(&pair[1], Step::Scan(after) if before.goes_with(after)),
            Grain::Blocks => false,
        },
        Step::Exchange { next_round: None, .. } => {
            matches!(grain, Grain::Iterations | Grain::Portions)
        }
        Step::Tiles { .. } | Step::Settle { .. } | Step::Exchange { .. } | Step::Count => false,
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
    let mut counter = StepCounter::new(texels, tuning, wavefront.has_two_layers());
    steps.iter().map(|step| account(&mut counter, step).0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::VISIT_WORDS;
    use crate::surface::Chart;
    use crate::vulkan::Schedule;
    use crate::vulkan::profile::{Decisions, PassKind, Work, decided};
    use crate::vulkan::schedules::plan::Portions;

    const TUNING: Tuning = Tuning::ON_CPU;

    /// Returns portions with one dispatch for each block of lines, as on grids of any size.
    fn portions(wavefront: Wavefront, texels: TexelChart) -> Portions {
        Portions { across: 0, ..TUNING.portions(wavefront, texels) }
    }

    fn passes(schedule: Schedule, wavefront: Wavefront) -> Vec<(PassRecord, Presence)> {
        let texels = TexelChart::new(Chart { rows: 20, cols: 33 }).unwrap();
        let portions = portions(wavefront, texels);
        let steps = schedule.plan(texels, portions, None, 2);
        let mut counter = StepCounter::new(texels, TUNING, wavefront.is_curved());
        steps.iter().map(|step| account(&mut counter, step)).collect()
    }

    #[test]
    fn passes_beyond_convergence_skip_what_they_were_recorded_for() {
        let visits = [u32::MAX; VISIT_WORDS as usize];
        let before = Decisions { before: 7, after: 8, ..Decisions::default() };
        let decisions = Decisions { is_done: true, visits: &visits, ..before };
        for (record, presence) in passes(Schedule::Raster, Wavefront::Planar) {
            let after = decided(record, presence, Some(decisions));
            assert_eq!(after.iteration, record.iteration.map(|iteration| 7 + iteration));
            if presence == Presence::Count {
                // A count reads seven numbers and writes five, and one more at the end. Beyond
                // convergence it reads one.
                let found = after.work.bytes_read.zip(after.work.bytes_written);
                let last = record.iteration == Some(0);
                assert_eq!(found, Some(if last { (4 * 7, 4 * (5 + 1)) } else { (4, 0) }));
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

    /// The grid has ten rows of texels and seventeen columns, in blocks of four. The device has visited the last two
    /// rows in the scans down and up, and the last column in the scan left.
    #[test]
    fn blocks_that_were_not_due_are_skipped() {
        let mut visits = [0; VISIT_WORDS as usize];
        // There are three blocks down, three up, five right and five left.
        for number in [2, 3, 11] {
            visits[0] |= 1 << number;
        }
        let decisions = Decisions { after: 2, visits: &visits, ..Decisions::default() };
        for wavefront in Wavefront::FOR_ANY_SURFACE {
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

    /// Repeats the previous check on the same grid with scans in pairs. The device has visited the last block of rows
    /// in the scans down and up, and the last column in the scan left.
    #[test]
    fn blocks_of_pairs_that_were_not_due_are_skipped() {
        let texels = TexelChart::new(Chart { rows: 20, cols: 33 }).unwrap();
        let tuning = Tuning { scan_pairs: true, ..TUNING };
        let portions = Portions { across: 0, ..tuning.portions(Wavefront::Planar, texels) };
        let steps = Schedule::Raster.plan(texels, portions, None, 2);
        assert_eq!(records(&steps, Grain::Blocks), 2 * (2 * 3 + 2 * 5 + 1));
        assert_eq!(records(&steps, Grain::Scans), 2 * (2 + 1));
        let mut counter = StepCounter::new(texels, tuning, false);
        let found: Vec<_> = steps.iter().map(|step| account(&mut counter, step)).collect();
        let mut visits = [0; VISIT_WORDS as usize];
        // The steps are down 0 and up 2, down 1, down 2 and up 1, up 0, then right 0 and left 4.
        for number in [1, 3, 7] {
            visits[0] |= 1 << number;
        }
        let decisions = Decisions { after: 2, visits: &visits, ..Decisions::default() };
        let (mut visited, mut skipped) = ([0; 2], [0; 2]);
        for (number, &(record, presence)) in found.iter().enumerate().take(16) {
            let found = decided(record, presence, Some(decisions));
            assert_eq!(found.is_idle(), ![1, 3, 7].contains(&number), "{number}");
            let PassKind::Pair(pair) = found.kind else { panic!("{found:?}") };
            visited[pair as usize] += found.work.texels.unwrap();
            skipped[pair as usize] += found.work.skipped.unwrap();
        }
        assert_eq!(visited, [2 * 2 * 17, 10]);
        assert_eq!(skipped, visited.map(|texels| 2 * 10 * 17 - texels));
        let merged = found[..6].iter().copied().reduce(|(mut record, mut presence), next| {
            record.absorb(&next.0);
            presence.absorb(next.1);
            (record, presence)
        });
        let (record, presence) = merged.unwrap();
        let found = decided(record, presence, Some(decisions));
        assert_eq!((found.work.texels, found.dispatches), (Some(2 * 2 * 17), 6));
        assert_eq!(found.groups, Some([2, 1, 1]));
    }

    /// Repeats the first of these checks on the same grid with one dispatch for each scan.
    #[test]
    fn blocks_in_turn_are_skipped_one_by_one() {
        let texels = TexelChart::new(Chart { rows: 20, cols: 33 }).unwrap();
        let steps =
            Schedule::Raster.plan(texels, TUNING.portions(Wavefront::Planar, texels), None, 2);
        assert_eq!(records(&steps, Grain::Blocks), 2 * (4 + 1));
        let mut counter = StepCounter::new(texels, TUNING, false);
        let found: Vec<_> = steps.iter().map(|step| account(&mut counter, step)).collect();
        let mut visits = [0; VISIT_WORDS as usize];
        for number in [2, 3, 11, 16 + 15] {
            visits[0] |= 1 << number;
        }
        let decisions = Decisions { after: 2, visits: &visits, ..Decisions::default() };
        // The passes are down, up, right, left, and the count.
        let visited = [34, 34, 0, 10, 0, 0, 0, 0, 40, 0];
        let all = [170, 170, 170, 170, 0, 170, 170, 170, 170, 0];
        for (number, &(record, presence)) in found.iter().enumerate() {
            let after = decided(record, presence, Some(decisions));
            if presence == Presence::Count {
                continue;
            }
            assert_eq!(after.work.texels, Some(visited[number]), "{number}");
            assert_eq!(after.work.skipped, Some(all[number] - visited[number]), "{number}");
            assert_eq!((after.groups, after.dispatches), (Some([1, 1, 1]), 1));
            assert_eq!(after.is_idle(), visited[number] == 0, "{number}");
            // Once the map has converged, a workgroup finds that no block is due.
            let beyond = Decisions { is_done: true, after: 0, ..decisions };
            let after = decided(record, presence, Some(beyond));
            assert_eq!((after.groups, after.work.texels), (Some([1, 1, 1]), Some(0)));
            assert!(after.is_idle());
        }
    }

    #[test]
    fn records_of_scans_hold_all_their_blocks() {
        let texels = TexelChart::new(Chart { rows: 20, cols: 33 }).unwrap();
        let portions = portions(Wavefront::Planar, texels);
        let steps = |schedule: Schedule| schedule.plan(texels, portions, None, 2);
        // The grid has ten rows of texels and seventeen columns, in blocks of four.
        let raster = steps(Schedule::Raster);
        assert_eq!(records(&raster, Grain::Blocks), 2 * (2 * 3 + 2 * 5 + 1));
        assert_eq!(records(&raster, Grain::Scans), 2 * (4 + 1));
        let tiles = steps(Schedule::Tiles);
        assert_eq!(records(&tiles, Grain::Scans), records(&tiles, Grain::Blocks));
        let of_iterations = |schedule| records(&steps(schedule), Grain::Iterations);
        assert_eq!(Schedule::ALL.map(of_iterations), [2, 2 + 1], "two rounds and their end");
    }

    #[test]
    fn tiles_are_as_many_as_the_device_has_listed() {
        // Of three tiles on the list one has waited.
        let rounds = [[3, 1], [0, 0]];
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
        // There are two rounds of 2 x 3 tiles of 8 x 8 texels, then the pass that settles them.
        assert_eq!(found.len(), 3);
        let bytes = Some(2 * 64 * (2 * 16 + 16 + 64 + 2 * 16));
        assert_eq!((found[0].work.texels, found[0].work.skipped), (Some(2 * 64), Some(4 * 64)));
        assert_eq!((found[0].work.bytes(), found[0].work.triangles), (bytes, None));
        assert_eq!((found[0].groups, found[0].iteration), (Some([3, 1, 1]), Some(3)));
        assert!(found[1].is_idle() && found[1].iteration == Some(4));
        assert_eq!((found[2].kind, found[2].groups), (PassKind::Settle, Some([6, 1, 1])));
        // The last pass reads and writes a state of each tile, and eight numbers of each texel that it copies.
        assert_eq!(found[2].work.bytes(), Some(2 * (6 * 4 + 37 * 2 * 16)));
    }

    #[test]
    fn no_more_is_recorded_than_asked_for() {
        let texels = TexelChart::new(Chart { rows: 500, cols: 600 }).unwrap();
        let portions = portions(Wavefront::Curved, texels);
        let count = |schedule: Schedule, wanted: fn(&Step) -> bool| {
            let steps = schedule.plan(texels, portions, None, 3);
            steps.iter().filter(|step| wanted(step)).count()
        };
        assert_eq!(count(Schedule::Raster, |step| *step == Step::Count), 3);
        assert_eq!(count(Schedule::Tiles, |step| matches!(step, Step::Tiles { .. })), 3);
    }
}
