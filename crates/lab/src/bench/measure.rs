//! Performs the measurements of a benchmark.

use geosweep_cli::note;
use std::error::Error;
use std::time::{Duration, Instant};

use geosweep::Stop;
use geosweep::cpu::{self, Order, RotatedScan};
use geosweep::surface::{Chart, EdgeLengths, Seed};
use geosweep::vulkan::profile::{Capability, Detail, Grain};
use geosweep::vulkan::{
    self, HeadlessSolution, HeadlessSolver, Schedule, SurfaceOnDevice, Tuning, VulkanError,
};
use geosweep::{DEFAULT_TOLERANCE, DeviceChoice, Sources, Surface, Wavefront};
use indicatif::ProgressBar;

use super::memory::fits;
use super::surface::BenchSurface;
use geosweep_cli::ceilings::{Shares, Work};
use geosweep_cli::terminal::progress;

/// An engine, with one of its schedules if it has several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    Cpu,
    FastMarching,
    Vulkan(Schedule),
}

impl Method {
    pub fn engine(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::FastMarching => "fast-marching",
            Self::Vulkan(_) => "vulkan",
        }
    }

    pub fn schedule(self) -> &'static str {
        match self {
            Self::Cpu => "rotated-scan",
            Self::FastMarching => "order-of-time",
            Self::Vulkan(schedule) => schedule.name(),
        }
    }
}

/// The measurements to perform.
pub struct Plan {
    pub surfaces: Vec<BenchSurface>,
    /// The sizes in ascending order.
    pub sizes: Vec<usize>,
    pub wavefronts: Vec<Wavefront>,
    pub methods: Vec<Method>,
    pub device: DeviceChoice,
    /// The tuning; `None` for the device's own.
    pub tuning: Option<Tuning>,
    /// The number of iterations after which maps stop, converged or not.
    pub iterations: Option<u32>,
    /// The longest time of a map. A method that takes longer is stopped, and left out at this size and larger
    /// ones.
    pub limit: Duration,
    /// The total time after which no further map is started. Smaller sizes come first.
    pub budget: Option<Duration>,
    /// The time for which runs of a map are repeated.
    pub long_enough: Duration,
}

/// The timing of a map.
pub struct Timing {
    pub surface: BenchSurface,
    pub rows: usize,
    pub cols: usize,
    /// The number of points, without holes.
    pub points: usize,
    pub wavefront: Wavefront,
    pub method: Method,
    /// The time to compute edge lengths and allocate the solver's memory, or to upload the surface.
    pub set_up: Duration,
    /// The times of all runs, ascending.
    pub times: Vec<Duration>,
    pub iterations: u32,
    pub converged: bool,
    /// The bytes of memory that the solver uses, edge lengths included.
    pub bytes: Option<u64>,
    pub work: Option<Work>,
    pub shares: Shares,
}

impl Timing {
    /// Returns half the interquartile range, in seconds.
    pub fn spread(&self) -> f64 {
        let at = |fraction: f64| {
            let index = ((self.times.len() - 1) as f64 * fraction).round() as usize;
            self.times[index].as_secs_f64()
        };
        0.5 * (at(0.75) - at(0.25))
    }

    pub fn best(&self) -> f64 {
        self.times[0].as_secs_f64()
    }

    pub fn median(&self) -> f64 {
        let (low, high) =
            (self.times[(self.times.len() - 1) / 2], self.times[self.times.len() / 2]);
        0.5 * (low + high).as_secs_f64()
    }
}

/// The results of all measurements.
pub struct Measurements {
    /// The timings, sorted by surface, wavefront, size and method.
    pub timings: Vec<Timing>,
    /// The ceilings of the threads that scan whole grids.
    pub cpu: Option<cpu::CpuCeilings>,
    /// The ceilings of all threads, if a grid was solved by patches.
    pub patches: Option<cpu::CpuCeilings>,
    pub device: Option<(String, vulkan::DeviceCeilings)>,
}

/// The largest number of threads that scan a whole grid: the CPU engine runs two scans at a time.
const MOST_THREADS: usize = 2;
const FEWEST_RUNS: usize = 3;
const MOST_RUNS: usize = 20;

/// Performs the planned measurements.
pub fn all(plan: &Plan) -> Result<Measurements, Box<dyn Error>> {
    let sizes = |surface: &BenchSurface| surface.sizes(&plan.sizes);
    let maps: usize = plan.surfaces.iter().map(|surface| sizes(surface).len()).sum();
    let bar = progress(maps * plan.wavefronts.len() * plan.methods.len());
    bar.set_message("ceilings");
    let on_device = plan.methods.iter().any(|method| matches!(method, Method::Vulkan(_)));
    let mut bench = Bench {
        plan,
        bar,
        // Profiles are used only for the work of a map, so no optional capability is requested from the
        // device.
        solver: on_device
            .then(|| {
                let solver = HeadlessSolver::for_profiling(&plan.device, &Capability::ALL)?;
                match plan.tuning {
                    Some(tuning) => {
                        let Tuning { scan_pairs, tile_lanes, staged, .. } = solver.tuning();
                        let tuning = Tuning { scan_pairs, tile_lanes, staged, ..tuning };
                        let tuning = solver.with_edges_placed(tuning);
                        solver.with_tuning(tuning)
                    }
                    None => Ok(solver),
                }
            })
            .transpose()?,
        cpu: cpu::CpuCeilings::measure(rayon::current_num_threads().min(MOST_THREADS)),
        patches: None,
        device: if on_device { Some(vulkan::DeviceCeilings::measure(&plan.device)?) } else { None },
        too_slow: Vec::new(),
        begin: Instant::now(),
        timings: Vec::new(),
    };
    // Small sizes of all surfaces come first, so that a budget cuts off the large ones.
    let mut too_slow = vec![Vec::new(); plan.surfaces.len()];
    for place in 0..plan.surfaces.iter().map(|surface| sizes(surface).len()).max().unwrap_or(0) {
        for (surface, too_slow) in plan.surfaces.iter().zip(&mut too_slow) {
            if let Some(&size) = sizes(surface).get(place) {
                std::mem::swap(&mut bench.too_slow, too_slow);
                bench.measure(surface, size)?;
                std::mem::swap(&mut bench.too_slow, too_slow);
            }
        }
    }
    let Bench { bar, mut timings, solver, cpu, patches, device, .. } = bench;
    bar.finish_and_clear();
    let place = |timing: &Timing| {
        let surface = plan.surfaces.iter().position(|surface| *surface == timing.surface);
        (surface, timing.wavefront as usize)
    };
    timings.sort_by_key(place);
    Ok(Measurements {
        timings,
        cpu: plan.methods.contains(&Method::Cpu).then_some(cpu),
        patches,
        device: solver.map(|solver| solver.device_name().to_owned()).zip(device),
    })
}

struct Bench<'a> {
    plan: &'a Plan,
    bar: ProgressBar,
    solver: Option<HeadlessSolver>,
    cpu: cpu::CpuCeilings,
    /// The ceilings of all threads; `None` until a grid needs them.
    patches: Option<cpu::CpuCeilings>,
    device: Option<vulkan::DeviceCeilings>,
    /// The combinations that were too slow on the current surface.
    too_slow: Vec<(Wavefront, Method)>,
    begin: Instant,
    timings: Vec<Timing>,
}

/// A surface at one size, with the inputs of a solver.
#[derive(Clone, Copy)]
struct Task<'a> {
    name: &'a BenchSurface,
    surface: &'a Surface,
    seeds: &'a [Seed],
    stop: Stop,
}

/// The result of one run.
struct Run {
    time: Duration,
    iterations: u32,
    residual: f64,
    visits_and_updates: Option<(u64, u64)>,
}

impl Bench<'_> {
    fn measure(&mut self, name: &BenchSurface, size: Option<usize>) -> Result<(), Box<dyn Error>> {
        let plan = self.plan;
        let rounds = plan.wavefronts.len() * plan.methods.len();
        if plan.budget.is_some_and(|budget| self.begin.elapsed() > budget) {
            let size = size.map_or(String::new(), |side| format!(" of {side} x {side} points"));
            note!("{name}{size} is left out: there is no time left, see --budget");
            self.bar.inc(rounds as u64);
            return Ok(());
        }
        if let Some(side) = size.filter(|&side| !fits(side * side)) {
            note!("{name}: {side} x {side} points do not fit the memory left");
            self.bar.inc(rounds as u64);
            return Ok(());
        }
        self.bar.set_message(match size {
            Some(side) => format!("{name} {side} x {side}"),
            None => name.to_string(),
        });
        let surface = name.surface(size)?;
        let (row, col) = name.source(&surface);
        let most = u32::try_from(10 * (surface.rows() + surface.cols())).unwrap_or(u32::MAX);
        let iterations = plan.iterations.unwrap_or(most);
        let seeds = Sources::point(row as f64, col as f64).seeds(&surface)?;
        let task = Task {
            name,
            surface: &surface,
            seeds: &seeds,
            stop: Stop::within(DEFAULT_TOLERANCE).or_after(iterations),
        };
        self.on_cpu(&task)?;
        self.on_device(&task)
    }

    /// Returns the ceilings of the threads that solve a grid on the CPU.
    fn cpu_ceilings(&mut self, chart: Chart) -> cpu::CpuCeilings {
        let threads = rayon::current_num_threads();
        match Order::best_for(chart, threads) {
            Order::Lines | Order::Times => self.cpu,
            Order::Patches { .. } | Order::TimesInPatches { .. } => {
                *self.patches.get_or_insert_with(|| cpu::CpuCeilings::measure(threads))
            }
        }
    }

    /// Returns whether to time a method. A method that has been too slow before is not timed.
    fn is_wanted(&self, wavefront: Wavefront, method: Method) -> bool {
        let is_planned = self.plan.methods.contains(&method);
        let too_slow = self.too_slow.contains(&(wavefront, method));
        if is_planned && too_slow {
            self.bar.inc(1);
        }
        is_planned && !too_slow
    }

    fn on_cpu(&mut self, task: &Task) -> Result<(), Box<dyn Error>> {
        let methods = [Method::Cpu, Method::FastMarching];
        if !methods.iter().any(|method| self.plan.methods.contains(method)) {
            return Ok(());
        }
        let start = Instant::now();
        let edges = EdgeLengths::<f32>::new(task.surface)?;
        let edges_time = start.elapsed();
        for &wavefront in &self.plan.wavefronts {
            for method in methods {
                if !self.is_wanted(wavefront, method) {
                    continue;
                }
                let start = Instant::now();
                let mut solver = match method {
                    Method::FastMarching => RotatedScan::in_order(&edges, wavefront, Order::Times),
                    _ => RotatedScan::new(&edges, wavefront),
                };
                let set_up = edges_time + start.elapsed();
                let bytes = (edges.bytes() + solver.bytes()) as u64;
                self.time(task, wavefront, method, set_up, Some(bytes), |task| {
                    let start = Instant::now();
                    let found = solver.solve(task.seeds, task.stop);
                    Ok(Run {
                        time: start.elapsed(),
                        iterations: found.iterations,
                        residual: found.residual,
                        visits_and_updates: Some((solver.visits(), solver.updates())),
                    })
                })?;
            }
        }
        Ok(())
    }

    fn on_device(&mut self, task: &Task) -> Result<(), Box<dyn Error>> {
        let Some(mut solver) = self.solver.take() else { return Ok(()) };
        let start = Instant::now();
        let uploaded = solver.upload(task.surface);
        let set_up = start.elapsed();
        match uploaded {
            Ok(mut surface) => self.schedules(task, &mut solver, &mut surface, set_up)?,
            Err(error @ (VulkanError::TooLarge { .. } | VulkanError::TooMuchMemory { .. })) => {
                note!("{}: left out on the device: {error}", task.name);
            }
            Err(error) => return Err(error.into()),
        }
        self.solver = Some(solver);
        Ok(())
    }

    fn schedules(
        &mut self,
        task: &Task,
        solver: &mut HeadlessSolver,
        surface: &mut SurfaceOnDevice,
        set_up: Duration,
    ) -> Result<(), Box<dyn Error>> {
        let bytes = Some(surface.bytes());
        for &wavefront in &self.plan.wavefronts {
            for schedule in Schedule::ALL {
                let method = Method::Vulkan(schedule);
                if !self.is_wanted(wavefront, method) {
                    continue;
                }
                let how = |stop| vulkan::Method::new(wavefront, stop).with_schedule(schedule);
                let is_timed = self.time(task, wavefront, method, set_up, bytes, |task| {
                    let HeadlessSolution { iterations, residual, time, .. } =
                        solver.solve(surface, task.seeds, how(task.stop))?;
                    Ok(Run { time, iterations, residual, visits_and_updates: None })
                })?;
                if !is_timed {
                    continue;
                }
                // The work is determined in a separate run that is not timed.
                let detail = Detail { grain: Grain::Blocks, ..Detail::default() };
                let (_, profile) = solver.profile(surface, task.seeds, how(task.stop), detail)?;
                let work = Work::on_device(&profile);
                let (timing, ceilings) = (self.timings.last_mut(), self.device.as_ref());
                let (timing, ceilings) = timing.zip(ceilings).expect("it has just been timed");
                timing.shares = Shares::on_device(work, timing.median(), wavefront, ceilings);
                timing.work = Some(work);
            }
        }
        Ok(())
    }

    /// Times a method: a warm-up run, then several timed runs. Returns whether the method stayed within the limit.
    fn time(
        &mut self,
        task: &Task,
        wavefront: Wavefront,
        method: Method,
        set_up: Duration,
        bytes: Option<u64>,
        mut run: impl FnMut(&Task) -> Result<Run, Box<dyn Error>>,
    ) -> Result<bool, Box<dyn Error>> {
        let Warmed { mut last, is_whole } = warm_up(task, self.plan.limit, &mut run)?;
        if !is_whole || last.time > self.plan.limit {
            self.too_slow.push((wavefront, method));
            self.bar.inc(1);
            note!(
                "{}, {wavefront} fronts: {} {} takes more than {} s at {} x {} points, and is left \
                     out from there on; see --limit",
                task.name,
                method.engine(),
                method.schedule(),
                self.plan.limit.as_secs_f64(),
                task.surface.rows(),
                task.surface.cols()
            );
            return Ok(false);
        }
        let mut times = Vec::new();
        while times.len() < FEWEST_RUNS
            || (times.len() < MOST_RUNS && times.iter().sum::<Duration>() < self.plan.long_enough)
        {
            last = run(task)?;
            times.push(last.time);
        }
        times.sort();
        let work = last.visits_and_updates.map(|counts| Work::on_cpu(counts, wavefront));
        let mut timing = Timing {
            surface: task.name.clone(),
            rows: task.surface.rows(),
            cols: task.surface.cols(),
            points: task.surface.points(),
            wavefront,
            method,
            set_up,
            times,
            iterations: last.iterations,
            converged: last.residual <= task.stop.tolerance,
            bytes,
            work,
            shares: Shares::default(),
        };
        if let Some(work) = work {
            let ceilings = self.cpu_ceilings(Chart { rows: timing.rows, cols: timing.cols });
            timing.shares = Shares::on_cpu(work, timing.median(), wavefront, &ceilings);
        }
        self.timings.push(timing);
        self.bar.inc(1);
        Ok(true)
    }
}

/// The result of the warm-up run.
struct Warmed {
    last: Run,
    /// Whether the map was completed.
    is_whole: bool,
}

/// Computes a map in portions. Each portion starts anew, with up to twice the iterations of the previous one.
/// So a map that would take longer than the limit is given up soon after the limit.
fn warm_up(
    task: &Task,
    limit: Duration,
    mut run: impl FnMut(&Task) -> Result<Run, Box<dyn Error>>,
) -> Result<Warmed, Box<dyn Error>> {
    let mut iterations = 1;
    loop {
        let stop = task.stop.or_after(iterations.min(task.stop.iterations));
        let last = run(&Task { stop, ..*task })?;
        if last.residual <= stop.tolerance || stop.iterations == task.stop.iterations {
            return Ok(Warmed { last, is_whole: true });
        }
        // The number of iterations that are expected to fit the limit.
        let pace = limit.as_secs_f64() / last.time.as_secs_f64().max(f64::MIN_POSITIVE);
        let most = (f64::from(stop.iterations) * pace) as u32;
        iterations = most.min(2 * stop.iterations);
        if iterations <= stop.iterations {
            return Ok(Warmed { last, is_whole: false });
        }
    }
}
