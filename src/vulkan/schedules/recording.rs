//! Records the steps of plans, for one map or for several maps together, and the commands before and after them.

use ash::vk;

use super::order::Steps;
use super::order_of;
use super::plan::{self, Step};
use super::progress::{self, Changed, offset};
use super::raster::{self, halves_of};
use crate::Stop;
use crate::constants::{FRONTS_ARE_ADDED, FRONTS_MEET};
use crate::vulkan::copies::Copies;
use crate::vulkan::device::barrier::{MOST_TOGETHER, PASS, TRANSFER_READ, TRANSFER_WRITE};
use crate::vulkan::device::passes::{COUNT, EXCHANGE, SEED, SETTLE, Variant};
use crate::vulkan::grid_images::TILE_WORDS;
use crate::vulkan::record::{Groups, PassKind, PlannedSteps, Recorder, StepsOf};
use crate::vulkan::{MapLimit, Schedule};

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

/// Part of one map in a recording of several: its recorder, the variant of its passes, its steps, and whether the map
/// has targets.
type Planned<'a, R> = (R, Variant, &'a [Step], bool);

impl Recorder<'_> {
    /// Records the start of a map, or, if `is_added`, the addition of sources to a map. The seeds must be recorded
    /// after it. The number of iterations is set to 0. The map ends at `limit`. `causal` says whether the map's fronts
    /// are causal ([`crate::surface::Origins`]).
    pub(crate) fn start(
        &self,
        (stop, limit): (Stop, MapLimit),
        schedule: Schedule,
        causal: bool,
        is_added: bool,
    ) {
        let order = schedule.order();
        // The start writes the progress, the state of each tile, and the schedule's own state.
        let written =
            offset::VISITS + TILE_WORDS as u64 * self.tile_bytes() + 4 * order.start_words(self);
        let _pass = self.pass_moving(PassKind::Start, [Some(0), Some(written)]);
        self.barrier(TRANSFER_READ, TRANSFER_WRITE);
        self.barrier(PASS, TRANSFER_WRITE);
        let fronts_meet = match (causal, is_added) {
            (false, _) => 0,
            (true, false) => FRONTS_MEET,
            (true, true) => FRONTS_ARE_ADDED,
        };
        // Without a radius, the device notes changes only once targets have set a limit. All texels count as changed
        // then.
        let is_noted = !is_added && limit.radius < f32::INFINITY;
        let changed = if is_noted { Changed::NOWHERE } else { Changed::ANYWHERE };
        let start = progress::start(stop, limit.radius, (fronts_meet, changed), self.tiles());
        self.write_progress(&start, 0);
        self.write_targets(limit);
        if !is_added {
            let size = size_of::<u32>() as u64;
            self.fill(self.grid.progress.buffer, offset::PASSED_OVER.start, size);
        }
        self.fill(self.grid.tiles.buffer, 0, vk::WHOLE_SIZE);
        order.start(self, is_added);
        self.barrier(TRANSFER_WRITE, PASS);
    }

    /// Records a dispatch of zero workgroups for each pass of a map, since drivers may compile a pipeline at its first
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

    /// Records the commands that must precede further iterations of a map.
    pub(crate) fn go_on(&self, schedule: Schedule) {
        schedule.order().go_on(self);
    }

    /// Records the steps of a plan, whose pipelines were made for `variant`, on a map that `has_targets` or has
    /// none.
    pub(crate) fn steps(&self, variant: impl Into<Variant>, steps: &[Step], has_targets: bool) {
        let variant = variant.into();
        let planned = PlannedSteps {
            steps,
            texels: self.grid.texels,
            tuning: self.pipelines.tuning,
            carries: variant.wavefront.has_two_layers(),
            exchanged: self.grid.copies.as_ref().map(Copies::bytes_moved),
            of: StepsOf::Map(self.grid),
        };
        let notes = self.observer.map_or(0, |observer| observer.begin_steps(self, planned));
        let mut recording = Steps { recorder: self, variant, bound: None, notes, scans: 0 };
        for together in plan::at_once(steps) {
            for (number, step) in raster::in_order(together).enumerate() {
                if number > 0 {
                    self.between_scans();
                }
                let _step = self.step(step);
                recording.run(step);
            }
            self.barrier(PASS, PASS);
            if has_targets && self.lower_limit(together.last()) {
                recording.bound = None;
                self.barrier(PASS, PASS);
            }
        }
        if let Some(observer) = self.observer {
            observer.end_steps(self);
        }
    }

    /// Records the steps of plans on several surfaces together. In turn it records the next group of simultaneous steps
    /// of each plan, and then one barrier for all of them.
    pub(crate) fn steps_together(all: &[Option<Planned<'_, Self>>]) {
        let mut recordings: [_; MOST_TOGETHER] = std::array::from_fn(|number| {
            let (recorder, variant, steps, has_targets) = all.get(number)?.as_ref()?;
            let variant = *variant;
            let recording = Steps { recorder, variant, bound: None, notes: 0, scans: 0 };
            Some((recording, plan::at_once(steps), *has_targets))
        });
        loop {
            let mut last = None;
            // For each surface, the last step of this group. The limit is lowered after it, if the map has targets.
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

    /// Tells the observer that the steps of a plan and the commands around them have been recorded.
    pub(crate) fn end_portion(&self) {
        if let Some(observer) = self.observer {
            observer.end_portion(self);
        }
    }
}
