//! Performs the measurements of frames.

use geosweep_cli::note;
use std::error::Error;
use std::time::{Duration, Instant};

use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Frame, FrameSurface, PointSource, Points, Reader, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{self, Method, Schedule};
use geosweep::{DeviceChoice, Stop, Wavefront};

use super::host::{Buffer, Host, Times};
use geosweep_cli::terminal::progress;

/// The measurements to perform.
pub struct Plan {
    /// The sizes in ascending order.
    pub sizes: Vec<usize>,
    pub schedules: Vec<Schedule>,
    pub wavefront: Wavefront,
    pub device: DeviceChoice,
    pub frames: u32,
    /// The largest number of iterations of scans.
    pub iterations: u32,
    /// The time after which no further frames of a size and schedule are started.
    pub limit: Duration,
}

/// The timing of the frames of a size and schedule.
pub struct Timing {
    pub chart: Chart,
    pub schedule: Schedule,
    pub wavefront: Wavefront,
    pub frames: usize,
    pub converged: usize,
    /// The median number of iterations. The following times are medians too.
    pub iterations: u32,
    pub device: Option<Duration>,
    pub host: Duration,
    pub record: Duration,
    /// The longest time on the host's clock.
    pub worst: Duration,
    /// The number of bytes of the surface.
    pub bytes: u64,
}

/// The results of all measurements.
pub struct Measured {
    pub device: String,
    pub timings: Vec<Timing>,
}

/// The number of phases of the motion. There is one buffer of vertices per phase.
const PHASES: usize = 8;
const WARM_UP: usize = 3;
/// The number of bytes of a vertex: three floats.
const STRIDE: usize = 12;

/// Performs the planned measurements.
pub fn measure(plan: &Plan) -> Result<Measured, Box<dyn Error>> {
    // The library chooses the device and checks that it is suitable.
    let name = vulkan::HeadlessSolver::new(&plan.device)?.device_name().to_owned();
    let index = match plan.device {
        DeviceChoice::Index(index) => index,
        _ => {
            let found = vulkan::devices()?.into_iter().find(|info| info.name == name);
            found.ok_or("the device is gone")?.index
        }
    };
    let mut host = Host::new(index)?;
    let passes: Vec<_> = plan.schedules.iter().map(|&s| (s, plan.wavefront)).collect();
    let mut solver =
        embed::Solver::new(&host.instance, host.physical_device, &host.device, &passes)?;
    let bar = progress(plan.sizes.len() * plan.schedules.len());
    let mut timings = Vec::new();
    for &side in &plan.sizes {
        bar.set_message(format!("{side} x {side}"));
        let chart = Chart { rows: side, cols: side };
        timings.extend(of_size(plan, &mut host, &solver, chart)?);
        bar.inc(plan.schedules.len() as u64);
    }
    bar.finish_and_clear();
    let device = host.device.clone();
    solver.destroy(&device);
    Ok(Measured { device: name, timings })
}

fn of_size(
    plan: &Plan,
    host: &mut Host,
    solver: &embed::Solver,
    chart: Chart,
) -> Result<Vec<Timing>, Box<dyn Error>> {
    let device = host.device.clone();
    let mut buffers: Vec<Buffer> = Vec::new();
    for phase in 0..PHASES {
        buffers.push(host.buffer_of(&sheet(chart, phase))?);
    }
    let points: Vec<_> =
        buffers.iter().map(|buffer| Points::positions(buffer.handle, STRIDE as u64)).collect();
    let info = SurfaceInfo::new(chart).with_points(&points);
    let mut surface = solver.surface(&device, host.allocator(), &info)?;
    host.run(|commands| {
        solver.record(&device, commands, &surface).prepare();
        Ok(())
    })?;
    let mut timings = Vec::new();
    for &schedule in &plan.schedules {
        timings.extend(of_schedule(plan, host, solver, &mut surface, schedule)?);
    }
    surface.destroy(&device, host.allocator());
    for buffer in buffers {
        host.free(buffer)?;
    }
    Ok(timings)
}

fn of_schedule(
    plan: &Plan,
    host: &Host,
    solver: &embed::Solver,
    surface: &mut FrameSurface,
    schedule: Schedule,
) -> Result<Option<Timing>, Box<dyn Error>> {
    let chart = surface.chart();
    let stop = Stop::within(1e-4).or_after(10_000);
    let method = Method::new(plan.wavefront, stop).with_schedule(schedule);
    let iterations = match schedule {
        // In a round, a wavefront crosses only one tile, so more iterations are planned.
        Schedule::Tiles => u32::MAX,
        Schedule::Raster => plan.iterations,
    };
    let of_frame = solver.plan(chart, method, iterations)?;
    let (mut times, mut rounds, mut converged): (Vec<Times>, Vec<u32>, usize) = Default::default();
    let begin = Instant::now();
    let mut number = 0;
    while times.len() < plan.frames as usize {
        // At least one frame is counted, even if a warm-up frame before it takes longer than the limit.
        let is_late = begin.elapsed() > plan.limit;
        if is_late && !times.is_empty() {
            note!(
                "{schedule}, {} x {}: {} of {} frames, see --limit",
                chart.rows,
                chart.cols,
                times.len(),
                plan.frames
            );
            break;
        }
        let source = PointSource::at(source(number, chart.rows), source(number / 2, chart.cols));
        let took = host.run(|commands| {
            solver.record(&host.device, commands, surface).frame(
                &Frame::new(&of_frame, SourceInput::Inline(&[source]), Reader::FRAGMENT)
                    .with_points(number % PHASES)
                    .with_unreached(-1.0),
            )?;
            Ok(())
        })?;
        number += 1;
        if number <= WARM_UP && !is_late {
            continue;
        }
        let outcome = surface.outcome(0)?;
        converged += usize::from(outcome.converged);
        rounds.push(outcome.iterations);
        times.push(took);
    }
    let duration = |get: fn(&Times) -> Duration| median(times.iter().map(get).collect());
    let on_device: Option<Vec<_>> = times.iter().map(|times| times.device).collect();
    Ok(Some(Timing {
        chart,
        schedule,
        wavefront: plan.wavefront,
        frames: times.len(),
        converged,
        iterations: median(rounds),
        device: on_device.map(median),
        host: duration(|times| times.host),
        record: duration(|times| times.record),
        worst: times.iter().map(|times| times.host).max().unwrap_or_default(),
        bytes: surface.bytes(),
    }))
}

/// Returns the median of at least one value. For an even count it is the lower of the middle two.
fn median<T: Ord + Copy>(mut values: Vec<T>) -> T {
    values.sort_unstable();
    values[(values.len() - 1) / 2]
}

/// Returns the position of a source in a frame, along a side. It moves by half a cell per frame and stays on
/// the grid.
fn source(number: usize, side: usize) -> f32 {
    let last = (side - 1) as f32;
    (0.3 * last + 0.5 * number as f32) % last
}

/// Returns the vertices of a sheet with a wave that travels across it.
fn sheet(chart: Chart, phase: usize) -> Vec<u8> {
    let turn = std::f32::consts::TAU;
    let step = turn / chart.rows.max(chart.cols) as f32;
    let vertex = |index: usize| {
        let (row, col) = chart.position(index);
        let (x, y) = (step * col as f32, step * row as f32);
        let z = 0.4 * (2.0 * x + turn * phase as f32 / PHASES as f32).sin() * y.cos();
        [x, y, z].map(f32::to_ne_bytes).concat()
    };
    (0..chart.points()).flat_map(vertex).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_move_and_sources_stay_on_the_grid() {
        let chart = Chart { rows: 5, cols: 7 };
        let (one, other) = (sheet(chart, 0), sheet(chart, 3));
        assert_eq!(one.len(), chart.points() * STRIDE);
        assert_ne!(one, other);
        for number in 0..100 {
            assert!((0.0..=4.0).contains(&source(number, 5)));
        }
        assert_ne!(source(0, 5), source(1, 5));
    }

    #[test]
    fn medians_are_in_the_middle() {
        assert_eq!(median(vec![3, 1, 2]), 2);
        assert_eq!(median(vec![4, 1, 3, 2]), 2);
        assert_eq!(median(vec![7]), 7);
    }
}
