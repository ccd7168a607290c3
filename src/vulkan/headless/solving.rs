//! Computes maps on a device without a renderer: starts them, iterates, and reads the distances back.

use std::time::{Duration, Instant};

use super::context::{CommandBuffer, Flight, Submitter, Unwatched};
use super::surface_on_device::{Start, SurfaceOnDevice};
use crate::Targets;
use crate::surface::{Chart, Seed};
use crate::update::Wavefront;
use crate::vulkan::device::passes::{EXCHANGE, Variant};
use crate::vulkan::device::staging::copy_in_parallel;
use crate::vulkan::grid_images::GridImages;
use crate::vulkan::profile::steps::records;
use crate::vulkan::profile::{Detail, Session, SolveProfile};
use crate::vulkan::record::{Commands, Recorder};
use crate::vulkan::schedules::method::Method;
use crate::vulkan::schedules::plan;
use crate::vulkan::schedules::plan::{Portions, Reached, Step};
use crate::vulkan::upload::{SeedTexel, seed_texels};
use crate::vulkan::{
    HeadlessSolver, MOST_TARGETS, MapLimit, Schedule, TargetPoint, TexelChart, VulkanError,
};

/// Margin by which fronts may go beyond the radius, as a fraction of the radius, so that rounding leaves out no
/// point within the radius.
const ROUNDING: f64 = 1e-6;

/// Factors of an estimated time. A map is solved up to each of these times in turn, until the targets are
/// reached.
const MARGINS: [f64; 2] = [1.05, 1.3];

/// Distance map computed by the Vulkan engine.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct HeadlessSolution {
    /// Distances in row-major order; +infinity where no source reaches, and beyond [`Method::radius`].
    pub distances: Vec<f32>,
    /// Front assumed. It is [`Wavefront::Anchored`] only where anchored fronts were possible, see
    /// [`Method::wavefront`].
    pub wavefront: Wavefront,
    /// Order of updates that was used.
    pub schedule: Schedule,
    /// Number of iterations of four scans, or of rounds of tiles.
    pub iterations: u32,
    /// Largest relative change of a front in the last iteration.
    pub residual: f64,
    /// Number of visits, each by one workgroup: to a tile, or to the part of a block of lines that a workgroup
    /// updates.
    pub visits: u64,
    /// Time from the first submission, which forgets the previous map, to the end of the last submission.
    pub time: Duration,
}

impl HeadlessSolution {
    /// Returns this solution with the work of an earlier one, on which it is based or which it replaces.
    fn after(self, earlier: &Self) -> Self {
        Self {
            iterations: earlier.iterations + self.iterations,
            visits: earlier.visits + self.visits,
            time: earlier.time + self.time,
            ..self
        }
    }
}

impl HeadlessSolver {
    /// Computes a map from `seeds`, which must lie on the surface.
    pub fn solve(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
    ) -> Result<HeadlessSolution, VulkanError> {
        self.solve_within(surface, seeds, method, None)
    }

    /// Computes a map from `seeds`, which must lie on the surface, for `targets`. The map ends when no front can
    /// reach the needed targets any earlier. Points that are farther than the last needed target have +infinity.
    ///
    /// With more than [`MOST_TARGETS`] targets, the map is solved up to the radius, and cut at the end. Raster scans
    /// also solve the map up to the radius, unless they have an estimate ([`HeadlessSolver::solve_to_about`]).
    pub fn solve_to(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        targets: &Targets,
        method: Method,
    ) -> Result<HeadlessSolution, VulkanError> {
        self.solve_within(surface, seeds, method, Some(targets))
    }

    /// Computes a map for `targets` as [`HeadlessSolver::solve_to`] does, given an estimate of the time at which
    /// fronts reach the needed targets.
    ///
    /// Iterations of raster scans bring early and late fronts in any order, and would go far beyond the targets. So
    /// they are limited to 1.05 times the estimate. If the targets need more time, the map is solved again up to
    /// 1.3 times the estimate, and at last without the estimate. Other schedules ignore the estimate.
    pub fn solve_to_about(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        targets: &Targets,
        estimate: f64,
        method: Method,
    ) -> Result<HeadlessSolution, VulkanError> {
        let is_used = self.schedule(surface, method) == Schedule::Raster;
        let margins = if is_used { &MARGINS[..] } else { &[] };
        let mut before: Option<HeadlessSolution> = None;
        let times = margins.iter().map(|margin| estimate * margin);
        let tried = times.filter(|&time| time > 0.0 && time < method.radius);
        for radius in tried.map(Some).chain([None]) {
            let limited = method.with_radius(radius.unwrap_or(method.radius));
            let solution = self.solve_within(surface, seeds, limited, Some(targets))?;
            let solution = before.iter().fold(solution, HeadlessSolution::after);
            let end = end_of(Some(targets), &solution.distances, surface.images.chart);
            if radius.is_none_or(|radius| end <= radius) || self.monitor.is_cancelled() {
                return Ok(solution);
            }
            before = Some(solution);
        }
        unreachable!("the last attempt has no estimate")
    }

    fn solve_within(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
        targets: Option<&Targets>,
    ) -> Result<HeadlessSolution, VulkanError> {
        let points = targets.map_or(Vec::new(), target_points);
        let needed = targets.map_or(u32::MAX, |targets| targets.needed() as u32);
        let from = (Start::Fresh, MapLimit::to(&points).with_needed(needed));
        let mut solution = self.solve_watched(surface, seeds, method, from, &mut Unwatched)?;
        solution = self.restore(surface, seeds, method, targets, solution)?;
        let end = end_of(targets, &solution.distances, surface.images.chart);
        cut(&mut solution.distances, end);
        Ok(solution)
    }

    /// Adds seeds to the last map of the surface, which must have converged with the same wavefront.
    ///
    /// # Errors
    /// As [`HeadlessSolver::solve`], and [`VulkanError::TooManyAnchors`] if a map of anchored fronts has no
    /// room for more sources inside cells.
    pub fn add(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
    ) -> Result<HeadlessSolution, VulkanError> {
        let from = (Start::FromLast, MapLimit::NONE);
        let solution = self.solve_watched(surface, seeds, method, from, &mut Unwatched)?;
        self.restore(surface, seeds, method, None, solution)
    }

    /// Solves again from the seeds and the last map, until no seed is lost ([`Seed::is_lost`]) or no
    /// iterations are left.
    fn restore(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
        targets: Option<&Targets>,
        mut solution: HeadlessSolution,
    ) -> Result<HeadlessSolution, VulkanError> {
        let chart = surface.images.chart;
        // Seeds that start after the end of the map are not set.
        let any_is_lost = |distances: &[f32]| {
            let end = method.radius.min(end_of(targets, distances, chart));
            let is_lost = |seed: &Seed| seed.is_lost(distances[chart.index(seed.row, seed.col)]);
            seeds.iter().any(|seed| seed.time <= end && is_lost(seed))
        };
        // Only curved fronts are ever withdrawn.
        while solution.wavefront.is_curved()
            && solution.iterations < method.stop.iterations
            && !self.monitor.is_cancelled()
            && any_is_lost(&solution.distances)
        {
            let left = method.stop.iterations - solution.iterations;
            let method = method.with_stop(method.stop.or_after(left));
            let from = (Start::FromLast, MapLimit::NONE);
            let further = self.solve_watched(surface, seeds, method, from, &mut Unwatched)?;
            solution = further.after(&solution);
        }
        Ok(solution)
    }

    /// Computes a map as [`HeadlessSolver::solve`] does and returns a record of every pass.
    ///
    /// # Errors
    /// As [`HeadlessSolver::solve`], and [`VulkanError::NotForProfiling`] unless the solver was made by
    /// [`HeadlessSolver::for_profiling`].
    pub fn profile(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
        detail: Detail,
    ) -> Result<(HeadlessSolution, SolveProfile), VulkanError> {
        let capabilities = self.capabilities().ok_or(VulkanError::NotForProfiling)?;
        let schedule = self.schedule(surface, method);
        let (texels, tuning) = (surface.images.texels, self.tuning());
        let portions = tuning.portions(method.wavefront, texels);
        let is_glued = surface.images.copies.is_some();
        let steps = plan_of(schedule, (texels, portions), None, method.stop.iterations, is_glued);
        // On a glued surface, seeds are exchanged too.
        let passes = records(&steps, detail.grain) + u32::from(is_glued);
        let [cols, rows] = texels.tiles(portions.tile);
        let tiles = cols as usize * rows as usize;
        let detail = Detail { tiles: detail.tiles && schedule.has_rounds(), ..detail };
        let room = passes + PASSES_AROUND;
        let mut session = Session::new(&self.context, capabilities, room, tiles, detail)?;
        // Command buffers that were recorded before contain no queries.
        surface.goes_on = None;
        let from = (Start::Fresh, MapLimit::NONE);
        let solved = self.solve_watched(surface, seeds, method, from, &mut session);
        surface.goes_on = None;
        let solution = solved?;
        let profile = session.finish(solution.time);
        Ok((solution, profile))
    }

    /// Returns the schedule by which a map is solved.
    pub(crate) fn schedule(&self, surface: &SurfaceOnDevice, method: Method) -> Schedule {
        let chart = surface.images.chart;
        let best = || Schedule::best_on(self.for_device.limits.kind, chart);
        method.schedule.unwrap_or_else(best)
    }

    fn solve_watched(
        &mut self,
        surface: &mut SurfaceOnDevice,
        seeds: &[Seed],
        method: Method,
        (start, limit): (Start, MapLimit),
        submitter: &mut impl Submitter,
    ) -> Result<HeadlessSolution, VulkanError> {
        let Method { stop, radius, .. } = method;
        let limit = limit.with_radius((radius * (1.0 + ROUNDING)) as f32);
        let has_targets = !limit.targets.is_empty();
        let (wavefront, carried) = surface.begin(method.wavefront, seeds, start)?;
        let schedule = self.schedule(surface, method);
        let variant = Variant {
            wavefront,
            splits: surface.splits,
            slowed: surface.slowed,
            small_tiles: self.tuning().has_small_tiles(surface.images.texels),
            glued: false,
        };
        self.make_passes(&surface.images, schedule, variant)?;
        let variant = (variant, has_targets);
        let causal = surface.origins.are_causal() || surface.splits.any();
        let SurfaceOnDevice { images, first, further, goes_on, .. } = surface;
        let (texels, portions) = (images.texels, self.tuning().portions(wavefront, images.texels));

        let begin = Instant::now();
        submitter.restart();
        let seeds = seed_texels(seeds, &carried, wavefront);
        let begin_map = |recorder: &Recorder| {
            if start == Start::Fresh {
                recorder.forget();
            }
            recorder.start((stop, limit), schedule, causal, start == Start::FromLast);
        };
        // The upload buffer holds `most` seeds. Submissions of their own set the seeds of all parts but the
        // last.
        let most = images.source_room() / size_of::<SeedTexel>();
        let (ahead, last) = seeds.split_at(seeds.len().saturating_sub(1) / most * most);
        if !ahead.is_empty() {
            self.run(submitter, images, |recorder| begin_map(&recorder))?;
        }
        for part in ahead.chunks(most) {
            let count = write_seeds(part, images);
            self.run(submitter, images, |recorder| recorder.seed(count, schedule.follows()))?;
        }
        let count = write_seeds(last, images);
        let places = seeds.iter().map(|seed| (seed.texel[1] as u32, seed.texel[0] as u32));
        // With bounds on the reached points, the first iteration would visit everything within the bounds,
        // even beyond the radius. Fronts that pass a seam leave the box around their sources.
        let is_glued = images.copies.is_some();
        let has_bounds = start == Start::Fresh && !limit.is_there() && !is_glued;
        let reached = Reached::around(places).filter(|_| has_bounds);
        let plan = |reached: Option<Reached>, left: u32| {
            let most = left.min(schedule.together(texels, portions));
            plan_of(schedule, (texels, portions), reached, most, is_glued)
        };
        let steps = plan(reached, stop.iterations);
        let parts = plan::parts(&steps, portions.visits);
        for number in 0..parts.len() {
            self.record(submitter, first, images, |recorder| {
                if number == 0 {
                    if ahead.is_empty() {
                        begin_map(&recorder);
                    }
                    recorder.seed(count, schedule.follows());
                    recorder.exchange_seeds(variant.0, schedule);
                }
                record_part(&recorder, variant, &parts, number);
            })?;
            submitter.submit(first)?;
            if self.monitor.is_cancelled() {
                break;
            }
        }
        let mut outcome = images.record(0).outcome;
        while !outcome.is_done() && !self.monitor.is_cancelled() {
            // One recording serves all iterations but the last ones, of which fewer may be left.
            let left = stop.iterations - outcome.iterations;
            let wanted = (variant, plan(None, left));
            let parts = plan::parts(&wanted.1, portions.visits);
            // A submitter that watches passes knows only the passes of the last recording.
            let is_kept = parts.len() == 1 || !submitter.is_watching();
            let is_recorded = is_kept && goes_on.as_ref() == Some(&wanted);
            while further.len() < parts.len() {
                further.push(CommandBuffer::kept(&self.context)?);
            }
            for (number, commands) in further.iter().enumerate().take(parts.len()) {
                if !is_recorded {
                    *goes_on = None;
                    self.record(submitter, commands, images, |recorder| {
                        if number == 0 {
                            recorder.go_on(schedule);
                        }
                        record_part(&recorder, variant, &parts, number);
                    })?;
                }
                submitter.submit(commands)?;
                if self.monitor.is_cancelled() {
                    break;
                }
            }
            // A map that was cancelled may have ended before all parts were recorded.
            *goes_on = Some(wanted).filter(|_| is_recorded || !self.monitor.is_cancelled());
            outcome = images.record(0).outcome;
        }
        let time = begin.elapsed();

        let mut distances = self.read_back(submitter, images)?;
        // Renewed fronts may have become later than the radius.
        cut(&mut distances, radius);
        self.context.check_validation()?;
        Ok(HeadlessSolution {
            distances,
            wavefront,
            schedule,
            iterations: outcome.iterations,
            residual: outcome.residual(),
            visits: outcome.visited.into(),
            time,
        })
    }

    /// Makes the passes of a schedule and a variant, unless they exist.
    fn make_passes(
        &mut self,
        images: &GridImages,
        schedule: Schedule,
        variant: Variant,
    ) -> Result<(), VulkanError> {
        let exchange = images.copies.is_some().then_some(EXCHANGE.number());
        let passes: Vec<_> = schedule.passes().iter().copied().chain(exchange).collect();
        let pipelines = &self.for_device.pipelines;
        if pipelines.have(&passes, variant) {
            return Ok(());
        }
        let wanted: Vec<_> = passes.iter().map(|&number| (number, variant)).collect();
        pipelines.make_each(&self.context.device, &wanted)?;
        self.run(&mut Unwatched, images, |recorder| recorder.warm_up_map(schedule, variant))
    }

    /// Records a command buffer.
    fn record(
        &self,
        submitter: &impl Submitter,
        commands: &CommandBuffer,
        grid: &GridImages,
        append: impl FnOnce(Recorder),
    ) -> Result<(), VulkanError> {
        submitter.record(commands, |device, buffer, observer| {
            let pipelines = &self.for_device.pipelines;
            let commands = Commands { device, buffer, pipelines, observer, turn: None };
            append(Recorder { commands, grid });
        })
    }

    /// Records commands, submits them and waits for their end.
    pub(in crate::vulkan) fn run(
        &self,
        submitter: &mut impl Submitter,
        grid: &GridImages,
        append: impl FnOnce(Recorder),
    ) -> Result<(), VulkanError> {
        let commands = CommandBuffer::new(&self.context)?;
        self.record(submitter, &commands, grid, append)?;
        submitter.submit(&commands)
    }

    /// Returns a command buffer for each band that may be transferred at the same time.
    pub(super) fn flights(&self, grid: &GridImages) -> Result<Vec<Flight>, VulkanError> {
        (0..grid.halves()).map(|_| Flight::new(&self.context)).collect()
    }

    /// Records commands and submits them. The last submission of the flight has been waited for.
    pub(super) fn start(
        &self,
        submitter: &mut impl Submitter,
        flight: &mut Flight,
        grid: &GridImages,
        append: impl FnOnce(Recorder),
    ) -> Result<(), VulkanError> {
        self.record(submitter, &flight.commands, grid, append)?;
        submitter.start(flight)
    }

    fn read_back(
        &self,
        submitter: &mut impl Submitter,
        images: &GridImages,
    ) -> Result<Vec<f32>, VulkanError> {
        let chart = images.chart;
        let mut distances = vec![0.0f32; chart.points()];
        let mut flights = self.flights(images)?;
        let bands = images.read_back_bands();
        // With two halves, the device copies a band while the host reads the previous band.
        let before = flights.len() - 1;
        for next in 0..bands.len() + before {
            if let Some(rows) = bands.get(next) {
                let half = next % flights.len();
                let flight = &mut flights[half];
                self.start(submitter, flight, images, |r| r.unpack(rows.clone(), half))?;
            }
            let Some(last) = next.checked_sub(before) else { continue };
            let (rows, half) = (&bands[last], last % flights.len());
            flights[half].wait()?;
            let part = &mut distances[chart.index(rows.start, 0)..chart.index(rows.end, 0)];
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(part);
            copy_in_parallel(&images.read_back(half)[..bytes.len()], bytes);
        }
        Ok(distances)
    }
}

/// Returns the targets for a device, or an empty list if there are more than it takes.
fn target_points(targets: &Targets) -> Vec<TargetPoint> {
    let points = targets.points();
    let point = |&[row, col]: &[usize; 2]| TargetPoint::at(row as u32, col as u32);
    let taken = if points.len() <= MOST_TARGETS as usize { points } else { &[] };
    taken.iter().map(point).collect()
}

/// Returns the distance at which a map for targets ends, or +infinity without targets.
fn end_of(targets: Option<&Targets>, distances: &[f32], chart: Chart) -> f64 {
    targets.map_or(f64::INFINITY, |targets| {
        targets.last(|[row, col]| f64::from(distances[chart.index(row, col)]))
    })
}

/// Resets all points farther than `end` to unreached.
fn cut(distances: &mut [f32], end: f64) {
    if end < f64::INFINITY {
        let farther = |distance: &&mut f32| f64::from(**distance) > end;
        distances.iter_mut().filter(farther).for_each(|distance| *distance = f32::INFINITY);
    }
}

/// Returns the steps of at most `most` iterations of a map, in which fronts pass the seams of a glued surface.
fn plan_of(
    schedule: Schedule,
    (texels, portions): (TexelChart, Portions),
    reached: Option<Reached>,
    most: u32,
    is_glued: bool,
) -> Vec<Step> {
    let steps = schedule.plan(texels, portions, reached, most);
    if is_glued { plan::with_exchanges(steps) } else { steps }
}

/// Records part `number` of a plan's steps. After the last part it records the copy of the outcome.
fn record_part(
    recorder: &Recorder,
    (variant, has_targets): (Variant, bool),
    parts: &[&[Step]],
    number: usize,
) {
    recorder.steps(variant, parts[number], has_targets);
    if number + 1 == parts.len() {
        recorder.outcome(0);
    }
    recorder.end_portion();
}

/// Writes seeds to the buffer that `seed.comp` reads, and returns their number.
fn write_seeds(seeds: &[SeedTexel], images: &mut GridImages) -> u32 {
    let bytes = bytemuck::cast_slice(seeds);
    images.upload_half(0)[..bytes.len()].copy_from_slice(bytes);
    seeds.len() as u32
}

/// Largest number of passes in a submission in addition to the steps of a plan: copies of the device's decisions, and
/// of the outcome of the iterations.
const PASSES_AROUND: u32 = 8;

#[cfg(test)]
mod tests {
    use ash::vk;

    use super::super::testing;
    use super::*;
    use crate::surface::Sources;
    use crate::vulkan::Tuning;
    use crate::vulkan::record::Observer;
    use crate::{Monitor, Stop};

    /// Submitter that cancels the map with one of its submissions.
    struct Cancelling {
        monitor: Monitor,
        /// Number of the submission that cancels the map, counted from 1.
        at: u32,
        submissions: u32,
    }

    impl Submitter for Cancelling {
        fn record(
            &self,
            commands: &CommandBuffer,
            append: impl FnOnce(&ash::Device, vk::CommandBuffer, Option<&dyn Observer>),
        ) -> Result<(), VulkanError> {
            Unwatched.record(commands, append)
        }

        fn submit(&mut self, commands: &CommandBuffer) -> Result<(), VulkanError> {
            self.submissions += 1;
            if self.submissions == self.at {
                self.monitor.cancel();
            }
            Unwatched.submit(commands)
        }

        fn start(&mut self, flight: &mut Flight) -> Result<(), VulkanError> {
            Unwatched.start(flight)
        }
    }

    /// Each iteration has four parts. The recording of the further iterations is whole after the eighth submission.
    #[test]
    fn a_cancelled_map_ends_after_each_part() {
        let solver = testing::validated();
        let tuning = Tuning { visits: Some(1), ..solver.tuning() };
        let mut solver = solver.with_tuning(tuning).unwrap();
        let surface = testing::hill(40, 30, |i| i);
        let seeds = Sources::point(3.0, 20.0).seeds(&surface).unwrap();
        let stop = Stop::within(1e-6).or_after(200);
        let method = Method::new(Wavefront::Planar, stop).with_schedule(Schedule::Raster);
        let mut on_device = solver.upload(&surface).unwrap();
        let whole = solver.solve(&mut on_device, &seeds, method).unwrap();
        for at in 1..=10 {
            let monitor = Monitor::default();
            solver.monitor = monitor.clone();
            on_device.goes_on = None;
            let mut submitter = Cancelling { monitor, at, submissions: 0 };
            let from = (Start::Fresh, MapLimit::NONE);
            solver.solve_watched(&mut on_device, &seeds, method, from, &mut submitter).unwrap();
            assert_eq!(submitter.submissions, at);
            assert_eq!(on_device.goes_on.is_some(), at > 8, "submission {at}");
            solver.monitor = Monitor::default();
            let again = solver.solve(&mut on_device, &seeds, method).unwrap();
            assert!(again.distances == whole.distances, "submission {at}");
        }
    }
}
