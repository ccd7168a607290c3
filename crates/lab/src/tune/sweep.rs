//! Performs the measurements of tuning.

use geosweep_cli::note;
use std::error::Error;
use std::time::{Duration, Instant};

use geosweep::surface::Seed;
use geosweep::vulkan::{
    HeadlessSolution, HeadlessSolver, Method, Schedule, SurfaceOnDevice, Tuning, VulkanError,
};
use geosweep::{DEFAULT_TOLERANCE, DeviceChoice, Sources, Stop, Wavefront};
use indicatif::ProgressBar;

use super::results::{Knob, Map, Row, Swept, Task};
use super::suggest::suggested;
use crate::bench::BenchSurface;
use geosweep_cli::terminal::progress;

/// The measurements to perform.
pub struct Plan {
    pub surfaces: Vec<BenchSurface>,
    /// The sizes in ascending order.
    pub sizes: Vec<usize>,
    pub wavefront: Wavefront,
    pub device: DeviceChoice,
    /// The longest untuned time of a map. Maps that take longer are left out.
    pub limit: Duration,
    /// The total time after which no further measurement is started.
    pub budget: Duration,
    /// The number of timed runs of a map.
    pub runs: usize,
    /// Whether to try fewer values.
    pub quick: bool,
}

/// The schedules that have portions.
pub const SCHEDULES: [Schedule; 2] = [Schedule::Raster, Schedule::Tiles];

/// Returns the numbers that are varied for a schedule, and the values that are tried.
fn knobs(schedule: Schedule, quick: bool) -> Vec<(Knob, &'static [u32])> {
    match (schedule, quick) {
        (Schedule::Tiles, false) => vec![
            (Knob::Tile, &[8, 16, 24, 32]),
            (Knob::Inner, &[1, 2, 4, 8]),
            (Knob::Together, &[8, 16, 32, 64, 128]),
        ],
        (Schedule::Tiles, true) => {
            vec![(Knob::Tile, &[8, 16]), (Knob::Inner, &[2, 4]), (Knob::Together, &[8, 64])]
        }
        (_, false) => vec![
            (Knob::Lines, &[1, 2, 4, 8, 16, 32]),
            (Knob::Width, &[32, 64, 128, 256, 512]),
            (Knob::Together, &[1, 2, 4, 8, 16]),
        ],
        (_, true) => {
            vec![(Knob::Lines, &[4, 8, 16]), (Knob::Width, &[64, 128]), (Knob::Together, &[2, 8])]
        }
    }
}

/// Performs the planned measurements.
pub fn sweep(plan: &Plan) -> Result<Swept, Box<dyn Error>> {
    let values: usize = SCHEDULES
        .iter()
        .flat_map(|&schedule| knobs(schedule, plan.quick))
        .map(|(_, values)| values.len())
        .sum();
    let mut tuner = Tuner {
        plan,
        end: Instant::now() + plan.budget,
        bar: progress(values + 2 * SCHEDULES.len()),
        tasks: tasks(plan)?,
        left_out: Vec::new(),
        references: SCHEDULES.map(|_| Vec::new()),
    };
    let mut plain = HeadlessSolver::new(&plan.device)?;
    let (device, untuned) = (plain.device_name().to_owned(), plain.tuning());
    let mut rows = Vec::new();
    for schedule in SCHEDULES {
        let first = rows.len();
        rows.push(tuner.untuned(&mut plain, schedule)?);
        for (knob, values) in knobs(schedule, plan.quick) {
            for &value in values {
                // For each size of tiles, edges are placed as the device would place them. Otherwise the
                // comparison would favour the untuned size.
                let tuning = plain.with_edges_placed(knob.set(untuned, value));
                if tuning == untuned {
                    tuner.bar.inc(1);
                    continue;
                }
                let row = tuner.row(&mut plain, (schedule, knob, value), tuning, &rows[first])?;
                rows.extend(row);
            }
        }
    }
    let suggested = plain.with_edges_placed(suggested(untuned, &rows));
    for schedule in SCHEDULES {
        let is_of = |row: &&Row| row.schedule == schedule && row.knob == Knob::Untuned;
        let before = rows.iter().find(is_of).expect("each schedule has its untuned row");
        if suggested != untuned {
            let row = tuner.row(&mut plain, (schedule, Knob::Suggested, 0), suggested, before)?;
            rows.extend(row);
        }
    }
    tuner.bar.finish_and_clear();
    let Tuner { tasks, left_out, .. } = tuner;
    Ok(Swept { device, wavefront: plan.wavefront, tasks, untuned, suggested, rows, left_out })
}

fn tasks(plan: &Plan) -> Result<Vec<Task>, Box<dyn Error>> {
    let mut tasks = Vec::new();
    for name in &plan.surfaces {
        for size in name.sizes(&plan.sizes) {
            let surface = name.surface(size)?;
            let (row, col) = name.source(&surface);
            let seeds = Sources::point(row as f64, col as f64).seeds(&surface)?;
            tasks.push(Task { name: name.to_string(), surface, seeds });
        }
    }
    Ok(tasks)
}

struct Tuner<'a> {
    plan: &'a Plan,
    end: Instant,
    bar: ProgressBar,
    tasks: Vec<Task>,
    left_out: Vec<String>,
    /// The untuned maps of each task, by schedule.
    references: [Vec<Option<Vec<f32>>>; SCHEDULES.len()],
}

/// Returns the index of a schedule in [`SCHEDULES`].
fn place(schedule: Schedule) -> usize {
    SCHEDULES.iter().position(|&other| other == schedule).expect("only these are tuned")
}

impl Tuner<'_> {
    fn leave_out(&mut self, what: String) {
        note!("left out: {what}");
        self.left_out.push(what);
    }

    /// Measures the untuned maps, with which the others are compared.
    fn untuned(
        &mut self,
        plain: &mut HeadlessSolver,
        schedule: Schedule,
    ) -> Result<Row, Box<dyn Error>> {
        self.bar.set_message(format!("{schedule}, untuned"));
        self.references[place(schedule)] = vec![None; self.tasks.len()];
        let mut maps = Vec::new();
        for task in 0..self.tasks.len() {
            let Task { name, surface, .. } = &self.tasks[task];
            let what = format!("{schedule}, {name} {} x {}", surface.rows(), surface.cols());
            if Instant::now() > self.end {
                self.leave_out(format!("{what}: the time is used up, see --budget"));
                continue;
            }
            match self.untuned_map(plain, schedule, task)? {
                Some((map, distances)) => {
                    self.references[place(schedule)][task] = Some(distances);
                    maps.push(map);
                }
                None => {
                    let limit = self.plan.limit.as_secs_f64();
                    self.leave_out(format!("{what}: more than {limit} s, see --limit"));
                }
            }
        }
        self.bar.inc(1);
        let ratio = (!maps.is_empty()).then_some(1.0);
        Ok(Row { schedule, knob: Knob::Untuned, value: 0, maps, refused: None, ratio })
    }

    /// Measures maps with other portions. Returns `None` if there is no time left.
    fn row(
        &mut self,
        plain: &mut HeadlessSolver,
        (schedule, knob, value): (Schedule, Knob, u32),
        tuning: Tuning,
        untuned: &Row,
    ) -> Result<Option<Row>, Box<dyn Error>> {
        let what = format!("{schedule}, {} {value}", knob.name());
        self.bar.set_message(what.clone());
        self.bar.inc(1);
        if Instant::now() > self.end {
            self.leave_out(format!("{what}: the time is used up, see --budget"));
            return Ok(None);
        }
        let mut row = Row { schedule, knob, value, maps: Vec::new(), refused: None, ratio: None };
        let mut solver = match HeadlessSolver::new(&self.plan.device)?.with_tuning(tuning) {
            Err(VulkanError::Tuning(reason)) => {
                row.refused = Some(reason);
                return Ok(Some(row));
            }
            other => other?,
        };
        for before in &untuned.maps {
            if Instant::now() > self.end {
                break;
            }
            row.maps.push(self.map(&mut solver, plain, schedule, before.task)?);
        }
        row.ratio = ratio(&row.maps);
        if row.maps.len() < untuned.maps.len() {
            self.leave_out(format!("{what}: some maps, the time is used up, see --budget"));
        }
        Ok(Some(row))
    }

    /// Measures the untuned map of a task. Returns `None` if it takes longer than the limit.
    fn untuned_map(
        &self,
        solver: &mut HeadlessSolver,
        schedule: Schedule,
        task: usize,
    ) -> Result<Option<(Map, Vec<f32>)>, VulkanError> {
        let mut run = Run::new(self, solver, schedule, task)?;
        // The first iterations compile the shaders. A few more show whether the whole map would exceed the
        // limit.
        run.solve(1)?;
        if run.solve(4)?.time > self.plan.limit {
            return Ok(None);
        }
        let found = run.solve(run.most)?;
        if found.time > self.plan.limit {
            return Ok(None);
        }
        let mut best = found.time;
        for _ in 0..self.plan.runs {
            best = best.min(run.solve(run.most)?.time);
        }
        let iterations = found.iterations;
        let map = Map { task, best, untuned: best, iterations, difference: 0.0 };
        Ok(Some((map, found.distances)))
    }

    /// Measures a map with two solvers in turn.
    fn map(
        &self,
        solver: &mut HeadlessSolver,
        plain: &mut HeadlessSolver,
        schedule: Schedule,
        task: usize,
    ) -> Result<Map, VulkanError> {
        let mut tuned = Run::new(self, solver, schedule, task)?;
        let mut untuned = Run::new(self, plain, schedule, task)?;
        let found = tuned.solve(tuned.most)?;
        untuned.solve(untuned.most)?;
        let [mut best, mut best_untuned] = [Duration::MAX; 2];
        for _ in 0..self.plan.runs {
            best = best.min(tuned.solve(tuned.most)?.time);
            best_untuned = best_untuned.min(untuned.solve(untuned.most)?.time);
        }
        let reference = self.references[place(schedule)][task].as_deref();
        let difference =
            difference(&found.distances, reference.expect("its untuned map was timed"));
        Ok(Map { task, best, untuned: best_untuned, iterations: found.iterations, difference })
    }
}

/// A surface on the device of a solver.
struct Run<'a> {
    solver: &'a mut HeadlessSolver,
    on_device: SurfaceOnDevice,
    seeds: &'a [Seed],
    wavefront: Wavefront,
    schedule: Schedule,
    /// A number of iterations in which any map converges.
    most: u32,
}

impl<'a> Run<'a> {
    fn new(
        tuner: &'a Tuner,
        solver: &'a mut HeadlessSolver,
        schedule: Schedule,
        task: usize,
    ) -> Result<Self, VulkanError> {
        let Task { surface, seeds, .. } = &tuner.tasks[task];
        let on_device = solver.upload(surface)?;
        let most = u32::try_from(10 * (surface.rows() + surface.cols())).unwrap_or(u32::MAX);
        let wavefront = tuner.plan.wavefront;
        Ok(Self { solver, on_device, seeds, wavefront, schedule, most })
    }

    fn solve(&mut self, iterations: u32) -> Result<HeadlessSolution, VulkanError> {
        let stop = Stop::within(DEFAULT_TOLERANCE).or_after(iterations);
        let method = Method::new(self.wavefront, stop).with_schedule(self.schedule);
        self.solver.solve(&mut self.on_device, self.seeds, method)
    }
}

/// Returns the geometric mean of the ratios to the untuned times.
fn ratio(maps: &[Map]) -> Option<f64> {
    let of = |map: &Map| (map.best.as_secs_f64() / map.untuned.as_secs_f64()).ln();
    let mean = maps.iter().map(of).sum::<f64>() / maps.len() as f64;
    (!maps.is_empty()).then(|| mean.exp())
}

/// Returns the largest difference, relative to the largest distance of the reference.
fn difference(found: &[f32], reference: &[f32]) -> f64 {
    let finite = |&distance: &f32| distance.is_finite();
    let largest = reference.iter().copied().filter(finite).fold(f32::MIN_POSITIVE, f32::max);
    let apart = |(&a, &b): (&f32, &f32)| match (a.is_finite(), b.is_finite()) {
        (true, true) => f64::from((a - b).abs()) / f64::from(largest),
        (false, false) if a == b => 0.0,
        _ => f64::INFINITY,
    };
    found.iter().zip(reference).map(apart).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_means_of_those_of_maps() {
        let map = |best, untuned| {
            let [best, untuned] = [best, untuned].map(Duration::from_millis);
            Map { task: 0, best, untuned, iterations: 1, difference: 0.0 }
        };
        // Twice and half the time.
        let found = ratio(&[map(200, 100), map(5, 10)]).unwrap();
        approx::assert_relative_eq!(found, 1.0, max_relative = 1e-12);
        approx::assert_relative_eq!(ratio(&[map(14, 7)]).unwrap(), 2.0);
        assert_eq!(ratio(&[]), None);
    }

    #[test]
    fn maps_differ_where_one_reaches_and_the_other_does_not() {
        let far = f32::INFINITY;
        assert_eq!(difference(&[0.0, 4.0, far], &[0.0, 4.0, far]), 0.0);
        assert_eq!(difference(&[0.0, 3.0, far], &[0.0, 4.0, far]), 0.25);
        assert_eq!(difference(&[0.0, 4.0, 5.0], &[0.0, 4.0, far]), f64::INFINITY);
        assert_eq!(difference(&[0.0, f32::NAN], &[0.0, 4.0]), f64::INFINITY);
        assert_eq!(difference(&[0.0, f32::NAN], &[0.0, far]), f64::INFINITY);
    }
}
