//! Plans and records the schedules. Each schedule has a file, which states its passes, plans its steps,
//! starts a map, records the steps and counts their work. This file contains everything that depends on the
//! choice of the schedule.

mod all_points;
pub(in crate::vulkan) mod method;
mod order;
pub mod plan;
pub(in crate::vulkan) mod progress;
pub(in crate::vulkan) mod raster;
pub(in crate::vulkan) mod schedule;
mod targets;
mod tiles;

use ash::vk;

use super::copies::Copies;
use super::device::barrier::MOST_TOGETHER;
use super::device::barrier::{CLEAR, COPY, PASS, PASS_AND_HOST, TRANSFER};
use super::device::passes::{COUNT, EXCHANGE, SEED, SETTLE, Variant};
use super::grid_images::TILE_WORDS;
use super::profile::{
    self, Grain, PassKind, PassRecord, Presence, Profile, Scope, StepCounter, Work,
};
use super::record::{Groups, Recorder};
use super::{MapLimit, Schedule, TexelChart, Tuning};
use crate::Stop;
use crate::constants::{FRONTS_ARE_ADDED, FRONTS_MEET, WORKGROUP};
use crate::update::Wavefront;
use plan::{Portions, Reached, Step};
use progress::{Changed, VISITS, offset};

use order::{Order, Steps};
use raster::halves_of;
pub(super) use raster::{Iteration, block_of};

impl Schedule {
    fn order(self) -> &'static dyn Order {
        match self {
            Self::Raster => &raster::Raster,
            Self::AllPoints => &all_points::AllPoints,
            Self::Tiles => &tiles::Tiles,
        }
    }

    /// Returns the steps of a recording: as many iterations (or rounds of tiles) as are worth submitting
    /// together, and at most `most`. Before and after these steps all fronts are in image 0.
    ///
    /// If the map has just been started, `reached` is the box around its sources. `portions` are
    /// [`Tuning::portions`].
    ///
    /// ```
    /// use geosweep::surface::Chart;
    /// use geosweep::vulkan::{Schedule, TexelChart, plan};
    /// let texels = TexelChart::new(Chart { rows: 64, cols: 64 }).unwrap();
    /// let source = plan::Reached { rows: 1..2, cols: 1..2 };
    /// let (lines, across, pairs, iterations) = (1, 0, false, 4);
    /// let (tile, rounds, visits) = (16, None, 1 << 22);
    /// let portions = plan::Portions { lines, across, pairs, iterations, tile, rounds, visits };
    /// let steps = Schedule::Raster.plan(texels, portions, Some(source), 100);
    /// // From a corner, the first scan visits about half of the texels.
    /// assert!(plan::texels_scanned(&steps[..32]) < 32 * 32 * 6 / 10);
    /// ```
    pub fn plan(
        self,
        texels: TexelChart,
        portions: Portions,
        reached: Option<Reached>,
        most: u32,
    ) -> Vec<Step> {
        self.order().plan(texels, portions, reached, most)
    }

    /// Returns the numbers of the schedule's passes in the table.
    pub(crate) fn passes(self) -> &'static [usize] {
        self.order().passes()
    }

    /// Returns [`Order::follows`].
    pub(crate) fn follows(self) -> u32 {
        self.order().follows()
    }

    /// Returns whether the schedule runs rounds over lists of tiles that the device makes. Otherwise it runs
    /// iterations over the whole grid.
    pub fn has_rounds(self) -> bool {
        self.order().has_rounds()
    }

    /// Returns [`Order::together`].
    pub(crate) fn together(self, texels: TexelChart, portions: Portions) -> u32 {
        self.order().together(texels, portions)
    }

    /// Returns [`Order::gains_by_surroundings`].
    pub(crate) fn gains_by_surroundings(self) -> bool {
        self.order().gains_by_surroundings()
    }
}

/// Returns the schedule to which a step belongs; `None` for those that several schedules use.
fn order_of(step: &Step) -> Option<&'static dyn Order> {
    match step {
        Step::Scan(_) => Some(&raster::Raster),
        Step::AllPoints { .. } => Some(&all_points::AllPoints),
        Step::Tiles { .. } | Step::Settle { .. } => Some(&tiles::Tiles),
        Step::Exchange { .. } | Step::Count => None,
    }
}

impl Steps<'_, '_> {
    fn run(&mut self, step: &Step) {
        match order_of(step) {
            Some(order) => order.record(self, step),
            None => self.run_shared(step),
        }
    }

    /// Records a step that several schedules use.
    fn run_shared(&mut self, step: &Step) {
        match *step {
            Step::Exchange { image, next_round } => {
                self.recorder.exchange(self.variant, image, next_round);
                self.bound = None;
            }
            _ => {
                let halves = halves_of(self.recorder.grid.texels, self.recorder.pipelines.tuning);
                self.dispatch(COUNT.pass(), 0, &halves, Groups::line(1));
            }
        }
    }
}

/// The part of one map in a recording of several: its recorder, the variant of its passes, its steps, and whether the
/// map has targets.
type Planned<'a, R> = (R, Variant, &'a [Step], bool);

impl Recorder<'_> {
    /// Records the start of a map before its seeds, or before what is added to a map: no iteration is done.
    /// The map ends at `limit`. `causal` says whether the map's fronts are causal
    /// ([`crate::surface::Origins`]).
    pub(crate) fn start(
        &self,
        (stop, limit): (Stop, MapLimit),
        schedule: Schedule,
        causal: bool,
        is_added: bool,
    ) {
        let order = schedule.order();
        // The start writes the progress, the numbers kept for each tile, and what else the schedule keeps.
        let written =
            offset::VISITS + TILE_WORDS as u64 * self.tile_bytes() + 4 * order.start_words(self);
        let work = Work::of_bytes(0, written);
        let _pass = self.pass_with(PassRecord { work, ..PassRecord::new(PassKind::Start) });
        let texels = self.grid.texels.inner();
        let grid = [texels[0].div_ceil(WORKGROUP), texels[1]];
        self.barrier(COPY, CLEAR);
        self.barrier(PASS, CLEAR);
        let fronts_meet = match (causal, is_added) {
            (false, _) => 0,
            (true, false) => FRONTS_MEET,
            (true, true) => FRONTS_ARE_ADDED,
        };
        // Without a radius, changes are noted only once targets are reached.
        let is_noted = !is_added && limit.radius < f32::INFINITY;
        let changed = if is_noted { Changed::NOWHERE } else { Changed::ANYWHERE };
        let start = progress::start(stop, limit.radius, (fronts_meet, changed), grid, self.tiles());
        self.write_progress(&start, 0);
        self.write_targets(limit);
        if !is_added {
            let size = size_of::<u32>() as u64;
            self.fill(self.grid.progress.buffer, offset::PASSED_OVER.start, size);
        }
        self.fill(self.grid.tiles.buffer, 0, vk::WHOLE_SIZE);
        order.start(self, is_added);
        self.barrier(CLEAR, PASS);
    }

    /// Dispatches no workgroup of any pass of a map, since drivers may compile a pipeline at its first
    /// dispatch.
    pub(crate) fn warm_up_map(&self, schedule: Schedule, variant: Variant) {
        let of_schedule = schedule.passes().iter().copied();
        let shared = [SEED.number(), COUNT.number(), SETTLE.number()];
        let exchange = self.grid.copies.as_ref().map(|copies| (EXCHANGE.number(), copies.sets(0)));
        let of_grid = of_schedule.chain(shared).map(|number| (number, self.grid.sets.writing[0]));
        for (number, sets) in of_grid.chain(exchange) {
            if let Some((pipeline, layout)) = self.pipelines.numbered(number, variant) {
                self.warm_up(pipeline, layout, sets);
            }
            self.barrier(PASS, PASS);
        }
    }

    /// Records what must precede further iterations of a map.
    pub(crate) fn go_on(&self, schedule: Schedule) {
        schedule.order().go_on(self);
    }

    /// Records the steps of a plan, whose pipelines were made for `variant`, on a map that `has_targets` or has
    /// none.
    pub(crate) fn steps(&self, variant: impl Into<Variant>, steps: &[Step], has_targets: bool) {
        let variant = variant.into();
        let mut open: Option<Scope> = None;
        let (texels, tuning) = (self.grid.texels, self.pipelines.tuning);
        let carries = variant.wavefront.has_two_layers();
        let exchanged = self.grid.copies.as_ref().map(Copies::bytes_moved);
        let mut counter = StepCounter::new(texels, tuning, carries).exchanging(exchanged);
        let notes = self.visits_noted(steps);
        let visits = u64::from(notes.div_ceil(32)) * size_of::<u32>() as u64;
        self.decided_before(visits);
        let mut recording = Steps { recorder: self, variant, bound: None, notes, scans: 0 };
        for together in plan::at_once(steps) {
            for (number, step) in raster::in_order(together).enumerate() {
                if number > 0 {
                    self.between_scans();
                }
                Scope::go_on(&mut open, self.watch(), || account(&mut counter, step));
                recording.run(step);
            }
            self.barrier(PASS, PASS);
            if has_targets {
                drop(open.take());
                if self.lower_limit(together.last()) {
                    recording.bound = None;
                    self.barrier(PASS, PASS);
                }
            }
        }
        drop(open);
        self.decided_after(visits);
    }

    /// Records the steps of plans on several surfaces: the next of each that run at the same time, then one
    /// barrier for all. A map that has targets is marked.
    pub(crate) fn steps_together(all: &[Option<Planned<'_, Self>>]) {
        let mut recordings: [_; MOST_TOGETHER] = std::array::from_fn(|number| {
            let (recorder, variant, steps, has_targets) = all.get(number)?.as_ref()?;
            let variant = *variant;
            let recording = Steps { recorder, variant, bound: None, notes: 0, scans: 0 };
            Some((recording, plan::at_once(steps), *has_targets))
        });
        loop {
            let mut last = None;
            // The step of each surface after which its targets are looked at.
            let mut ended = [None; MOST_TOGETHER];
            for (number, of) in recordings.iter_mut().enumerate() {
                let Some((recording, groups, has_targets)) = of else { continue };
                let Some(together) = groups.next() else { continue };
                // Passes of other surfaces have been bound meanwhile.
                recording.bound = None;
                for (number, step) in together.iter().enumerate() {
                    if number > 0 {
                        recording.recorder.between_scans();
                    }
                    recording.run(step);
                }
                last = Some(recording.recorder);
                ended[number] = together.last().filter(|_| *has_targets);
            }
            let Some(recorder) = last else { break };
            recorder.barrier(PASS, PASS);
            let ends = recordings.iter().zip(ended);
            let lower =
                ends.filter_map(|(of, step)| Some(of.as_ref()?.0.recorder.lower_limit(step)));
            if lower.fold(false, |any, lowered| any | lowered) {
                recorder.barrier(PASS, PASS);
            }
        }
    }

    /// Separates two scans of a pair for the validation layers.
    fn between_scans(&self) {
        if self.pipelines.separates_pairs {
            self.barrier(PASS, PASS);
        }
    }

    /// Ends a portion after the steps of a plan and what belongs to them.
    pub(crate) fn end_portion(&self) {
        if let Some(profile) = self.profile {
            profile.end_portion(self.device, self.buffer);
        }
    }

    /// Returns how many dispatches of scans note their visits: as many as there is room for, if a profile
    /// requests it.
    fn visits_noted(&self, steps: &[Step]) -> u32 {
        if self.profile.and_then(Profile::decisions).is_none() {
            return 0;
        }
        let lines = self.pipelines.tuning.scan_lines;
        let blocks = steps.iter().map(|step| match step {
            Step::Scan(pass) => pass.blocks(lines),
            _ => 0,
        });
        blocks.sum::<u32>().min(VISITS)
    }

    /// Copies the outcome of the iterations so far to where a profile finds it, and clears `visits` bytes of
    /// visits.
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

    /// Copies the device's decisions to where a profile finds them, with `visits` bytes of visits.
    fn decided_after(&self, visits: u64) {
        let Some((buffer, offset)) = self.profile.and_then(Profile::decisions) else { return };
        let bytes = offset::VISITS + visits;
        let _pass = self.pass_of_copy(PassKind::Decisions, bytes);
        let to = (buffer, offset + profile::BEFORE_BYTES);
        self.copy_for_host(self.grid.progress.buffer, 0, to, bytes);
    }
}

/// Returns the record of the next step of a recording.
pub(super) fn account(counter: &mut StepCounter, step: &Step) -> (PassRecord, Presence) {
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
    // Iterations end with a count, so that no scan follows one of the same direction.
    let merged = steps.windows(2).filter(|pair| match &pair[0] {
        Step::Scan(before) => match grain {
            // The work of an iteration beyond convergence is known only later, so that a portion takes room
            // for all of its iterations.
            Grain::Iterations | Grain::Portions => true,
            Grain::Scans => matches!(&pair[1], Step::Scan(after) if before.goes_with(after)),
            Grain::Blocks => false,
        },
        Step::AllPoints { .. } | Step::Exchange { next_round: None, .. } => {
            matches!(grain, Grain::Iterations | Grain::Portions)
        }
        Step::Tiles { .. } | Step::Settle { .. } | Step::Exchange { .. } | Step::Count => false,
    });
    (steps.len() - merged.count()) as u32
}

/// Returns the passes of a plan, each as if the map had not converged before it, without times. A plan does
/// not determine what rounds of tiles visit.
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
    use crate::vulkan::profile::{Decisions, decided};

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
        for schedule in [Schedule::Raster, Schedule::AllPoints] {
            for (record, presence) in passes(schedule, Wavefront::Planar) {
                let after = decided(record, presence, Some(decisions));
                assert_eq!(after.iteration, record.iteration.map(|iteration| 7 + iteration));
                if presence == Presence::Count {
                    // A count reads seven numbers and writes five, and two more at the end. Beyond
                    // convergence it reads one.
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

    /// The grid has ten rows of texels and seventeen columns, in blocks of four. The device has visited the
    /// last two rows in both scans, and the last column in the scan left.
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

    /// Repeats the previous check on the same grid with scans in pairs. The device has visited the last block
    /// of rows in both scans, and the last column in the scan left.
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
        for schedule in [Schedule::AllPoints, Schedule::Tiles] {
            let steps = steps(schedule);
            assert_eq!(records(&steps, Grain::Scans), records(&steps, Grain::Blocks));
        }
        let of_iterations = |schedule| records(&steps(schedule), Grain::Iterations);
        assert_eq!(Schedule::ALL.map(of_iterations), [2, 2, 2 + 1], "two rounds and their end");
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
        // It reads and writes a state of each tile, and eight numbers of each texel that is brought back.
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
        assert_eq!(count(Schedule::AllPoints, |step| *step == Step::Count), 3);
        assert_eq!(count(Schedule::Tiles, |step| matches!(step, Step::Tiles { .. })), 3);
    }
}
