//! Performs the measurements of a profile.

use std::error::Error;
use std::time::Duration;

use geosweep::surface::Chart;
use geosweep::vulkan::profile::{
    Capabilities, Capability, Detail, Executable, Grain, SolveProfile,
};
use geosweep::vulkan::{self, HeadlessSolver, Tuning};
use geosweep::{DeviceChoice, Engine, Options, Surface, Wavefront};

use super::renderdoc::Capture;
use super::subject::{Of, Solved, Subject};
use crate::terminal::progress;

/// The measurements to perform, and their number.
pub struct Wanted<'a> {
    pub surface: &'a Surface,
    pub of: Of<'a>,
    pub options: &'a Options,
    pub repeat: u32,
    pub without: &'a [Capability],
    /// The grain of the timestamps; `None` for the finest grain that slows the map down only a little.
    pub grain: Option<Grain>,
    /// Whether to record what each block of lines or each round of tiles visits.
    pub visits: bool,
}

/// The results of all measurements.
pub struct Measured {
    pub device: String,
    pub driver: String,
    pub capabilities: Capabilities,
    pub ceilings: vulkan::DeviceCeilings,
    pub chart: Chart,
    pub tuning: Tuning,
    pub solved: Solved,
    pub wavefront: Wavefront,
    pub grain: Grain,
    /// The relative time that timestamps of each scan would have added to a map. It is set only if this was too much
    /// and a coarser grain was chosen.
    pub by_scans: Option<f64>,
    pub iterations: u32,
    pub residual: f64,
    pub converged: bool,
    /// The timed runs, in order.
    pub runs: Vec<SolveProfile>,
    /// The times of maps without profiling, on the host's clock. One is measured before each timed run.
    pub plain: Vec<Duration>,
    /// A run with invocation counts and the time of whole command buffers. Its times serve only for the
    /// passes' share of the command buffers' time.
    pub counted: SolveProfile,
    /// A run with visits block by block and lists of tiles, if requested. Its times are not used.
    pub visits: Option<SolveProfile>,
    pub executables: Vec<Executable>,
}

impl Measured {
    /// Returns the run with the median time.
    pub fn median_run(&self) -> &SolveProfile {
        let mut runs: Vec<_> = self.runs.iter().collect();
        runs.sort_by_key(|run| (run.pass_nanoseconds(), run.time));
        runs[(runs.len() - 1) / 2]
    }
}

/// Performs the requested measurements.
pub fn measure(wanted: &Wanted, capture: Option<Capture>) -> Result<Measured, Box<dyn Error>> {
    let Wanted { surface, options, .. } = *wanted;
    let choice = device(&options.engine)?;
    let bar = progress(wanted.repeat as usize + 3);
    bar.set_message("ceilings");
    // RenderDoc would capture the device of the peak-rate measurement instead of the solver's.
    let captured = capture.is_some();
    let ceilings = |choice: &DeviceChoice| vulkan::DeviceCeilings::measure(choice);
    let before = if captured { None } else { Some(ceilings(choice)?) };
    bar.inc(1);
    bar.set_message("warming up");
    let mut solver = HeadlessSolver::for_profiling(choice, wanted.without)?;
    let mut subject = Subject::new(&solver, surface, &wanted.of, options)?;
    let method = subject.method();
    subject.solve(&mut solver)?;
    if let Some(capture) = capture {
        let (solved, file) = capture.around(|| subject.solve(&mut solver));
        solved?;
        note!("RenderDoc has captured a map: {}", file?);
    }
    bar.inc(1);
    let timestamp = before.and_then(|ceilings| ceilings.timestamp);
    let (grain, by_scans) = match wanted.grain {
        Some(grain) => (grain, None),
        None => grain_for(&mut subject, &mut solver, timestamp)?,
    };
    let timed = Detail { grain, ..Detail::default() };
    let counted = Detail { invocations: true, whole: true, ..timed };
    let (ended, counted) = subject.profile(&mut solver, counted)?;
    let visits = Detail { grain: Grain::Blocks, tiles: true, ..Detail::default() };
    let visits = wanted.visits.then(|| subject.profile(&mut solver, visits));
    let visits = visits.transpose()?.map(|(_, visits)| visits);
    bar.inc(1);
    bar.set_message("timing");
    let (mut runs, mut plain) = (Vec::new(), Vec::new());
    for _ in 0..wanted.repeat {
        plain.push(subject.solve(&mut solver)?);
        runs.push(subject.profile(&mut solver, timed)?.1);
        bar.inc(1);
    }
    let executables = solver.executables()?;
    let (device, tuning) = (solver.device_name().to_owned(), solver.tuning());
    let capabilities = solver.capabilities().expect("it was made for profiling").clone();
    drop((subject, solver));
    let ceilings = before.map_or_else(|| ceilings(choice), Ok)?;
    bar.finish_and_clear();
    let driver = vulkan::devices()?.into_iter().find(|found| found.name == device);
    Ok(Measured {
        device,
        driver: driver.map_or(String::new(), |found| found.driver),
        capabilities,
        ceilings,
        chart: surface.chart(),
        tuning,
        solved: ended.solved,
        wavefront: method.wavefront,
        grain,
        by_scans,
        iterations: ended.iterations,
        residual: ended.residual,
        converged: ended.residual <= method.stop.tolerance,
        runs,
        plain,
        counted,
        visits,
        executables,
    })
}

/// Returns the finest grain whose timestamps add little to a map's time, but none finer than scans. If
/// the grain is coarser than scans, also returns the relative time that timestamps of scans would add.
fn grain_for(
    subject: &mut Subject,
    solver: &mut HeadlessSolver,
    timestamp: Option<Duration>,
) -> Result<(Grain, Option<f64>), Box<dyn Error>> {
    let Some(timestamp) = timestamp else { return Ok((Grain::default(), None)) };
    let mut shortest = Duration::MAX;
    for _ in 0..UNDISTURBED {
        shortest = shortest.min(subject.solve(solver)?);
    }
    let mut added = |grain| -> Result<f64, Box<dyn Error>> {
        let (_, profile) = subject.profile(solver, Detail { grain, ..Detail::default() })?;
        let timestamps = profile.passes().count() + profile.submissions.len();
        Ok(timestamps as f64 * timestamp.as_secs_f64() / shortest.as_secs_f64())
    };
    Ok(finest(added(Grain::Scans)?, added(Grain::Iterations)?))
}

/// Chooses the grain from the relative time that timestamps of scans and of iterations add.
fn finest(by_scans: f64, by_iterations: f64) -> (Grain, Option<f64>) {
    if by_scans <= ADDED {
        (Grain::Scans, None)
    } else if by_iterations <= ADDED {
        (Grain::Iterations, Some(by_scans))
    } else {
        (Grain::Portions, Some(by_scans))
    }
}

/// The largest relative time that timestamps may add to a map.
const ADDED: f64 = 0.025;
/// The number of timed maps, of which the shortest time counts as undisturbed.
const UNDISTURBED: u32 = 3;

fn device(engine: &Engine) -> Result<&DeviceChoice, String> {
    match engine {
        Engine::Auto => Ok(&DeviceChoice::Any),
        Engine::Vulkan(choice) => Ok(choice),
        Engine::Cpu | Engine::FastMarching => {
            Err("only Vulkan devices can be profiled; leave --engine \
                                                   out (`geosweep-lab bench` times the CPU engine)"
                .into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grains_are_as_fine_as_the_map_bears() {
        assert_eq!(finest(0.02, 0.01), (Grain::Scans, None));
        assert_eq!(finest(0.07, 0.02), (Grain::Iterations, Some(0.07)));
        assert_eq!(finest(0.3, 0.1), (Grain::Portions, Some(0.3)));
    }
}
