//! Provides the common parts of commands on a distance map: the arguments for the surface, the sources and the solver,
//! and the computation of the map.

mod args;
mod curve_files;
mod earth;
mod geodetic;
mod given;
mod gluing;
mod limits;
mod picture;
mod placing;
mod scene;
mod solver;
mod sources;
mod summary;
mod surface;

use std::path::Path;
use std::time::Duration;

use geosweep::shown::{exact, seven_digits};
use geosweep::surface::{Direction, EdgeLengths, Real};
use geosweep::{DistanceMap, Options, Report, Sources, Surface, UsedEngine, Wavefront};

pub use args::{Problem, ProblemArgs};
pub use curve_files::CurveFiles;
pub use limits::{LimitArgs, comment_on_targets};
pub use picture::PictureArgs;
pub use scene::Scene;
pub use solver::SolverArgs;
pub use sources::{GivenSources, SourceArgs, remark};
pub use summary::{MapReport, MapSummary};
pub use surface::SurfaceArgs;

use crate::output::{Written, done};
use crate::precision::{Number, Precision};
use crate::surface_arg;
use crate::terminal::{Spinner, counted};

/// Returns a sentence on the built-in surfaces for the end of a command's help.
pub fn builtin_names() -> String {
    format!("Built-in surfaces:\n  {}", surface_arg::builtin_names())
}

/// Computes the map from some sources, and prints notes that the user should know.
pub fn solve<R: Number>(
    scene: &Scene,
    sources: &Sources,
    options: &Options,
) -> Result<DistanceMap<R>, geosweep::Error> {
    let _spinner = Spinner::new("computing distances");
    let mut map = R::MAP(&scene.surface, sources, options).map_err(|error| scene.explain(error))?;
    scene.count(&mut map);
    comment(&map.report, options);
    comment_on_starts::<R>(&scene.surface, sources);
    comment_on_size::<R>(&scene.surface);
    comment_on_corners(&scene.surface, &map);
    Ok(map)
}

/// Computes the map. Returns it in single precision, and also in double precision if it was computed so.
pub fn solve_in(
    precision: Precision,
    scene: &Scene,
    sources: &Sources,
    options: &Options,
) -> Result<(DistanceMap, Option<DistanceMap<f64>>), geosweep::Error> {
    match precision {
        Precision::Single => Ok((solve::<f32>(scene, sources, options)?, None)),
        Precision::Double => {
            let map = solve::<f64>(scene, sources, options)?;
            Ok((map.to_single(), Some(map)))
        }
    }
}

/// Returns the value of a map in double precision at a place of the grid. Returns `None` without such a map, and
/// between grid points.
pub fn double_at(map: Option<&DistanceMap<f64>>, [row, col]: [f64; 2]) -> Option<f64> {
    let is_point = row.fract() == 0.0 && col.fract() == 0.0;
    map.filter(|_| is_point).map(|map| map.distance(row as usize, col as usize))
}

/// Returns the precision of maps if none is given. Thin cells near the poles of the Earth cost digits.
pub fn default_precision(surface: &SurfaceArgs, solver: &SolverArgs) -> Precision {
    match surface.geodetic.is_wanted() && !solver.wants_device() {
        true => Precision::Double,
        false => Precision::Single,
    }
}

/// Returns all files that are read.
pub fn inputs<'a>(
    surface: &'a SurfaceArgs,
    sources: &'a SourceArgs,
) -> impl Iterator<Item = &'a Path> {
    surface.inputs().chain(sources.files()).map(AsRef::as_ref)
}

/// Prints notes on how the map was computed that the user should know.
pub fn comment(report: &Report, options: &Options) {
    if let Some(reason) = &report.fallback {
        warning!("computed on the CPU, since the GPU failed: {reason}");
    }
    if let Some(asked) = options.wavefront.filter(|&asked| asked != report.wavefront) {
        let solved = report.wavefront;
        let reason = match solved {
            Wavefront::Rays => "are early where fronts meet",
            _ if asked == Wavefront::Rays => "are not for an uneven slowness",
            _ => "are for a single source",
        };
        note!("solved with {solved} fronts, since {asked} ones {reason}");
    }
    if !report.converged {
        warn_of_no_convergence(options, report.iterations, report.residual, report.tolerance);
    }
}

/// Prints what was computed, how, and what was written.
pub fn done_with_map(scene: &Scene, report: &Report, written: &Written) {
    done_with(scene, report, [], written);
}

/// Prints what was computed and how, then `made`, the results that follow from the map, then the files written.
pub fn done_with(
    scene: &Scene,
    report: &Report,
    made: impl IntoIterator<Item = String>,
    written: &Written,
) {
    let Report { points, reached, max_distance, .. } = report;
    let engine = engine_name(report.engine, report.device.as_deref());
    let engine = match report.fallback {
        Some(_) => format!("{engine}, since the GPU failed"),
        None => engine,
    };
    let points = match points - reached {
        0 => format!("{}, all reached", counted(*points as u64, "point")),
        unreached if report.ends_at.is_some() => {
            format!("{points} points, {unreached} of them beyond the part that was asked for")
        }
        unreached if report.converged => {
            format!("{points} points, {unreached} of them cannot be reached")
        }
        unreached => format!("{points} points, {unreached} of them not reached yet"),
    };
    let iterations = match report.engine {
        UsedEngine::FastMarching if report.iterations == 1 => "one pass".into(),
        _ => convergence(report.iterations, report.converged),
    };
    let time = seconds(report.solve_time);
    let largest = match max_distance.is_finite() {
        true => format!("largest {} {}", scene.quantity(scene.unit), seven_digits(*max_distance)),
        false => "no distance".into(),
    };
    let parts = [engine, points, format!("{iterations} in {time}"), largest];
    done(parts.into_iter().chain(made), written);
}

/// Names the engine that was used, with its device.
pub fn engine_name(engine: UsedEngine, device: Option<&str>) -> String {
    match (engine, device) {
        (_, Some(device)) => format!("Vulkan on {device}"),
        (UsedEngine::Cpu, None) => "CPU".into(),
        (other, None) => other.name().replace('-', " "),
    }
}

/// Describes how the computation of a map ended.
pub fn convergence(iterations: u32, converged: bool) -> String {
    let state = if converged { "converged" } else { "not converged" };
    format!("{state} after {}", counted(iterations, "iteration"))
}

/// Formats a time in seconds, or in milliseconds below 0.1 s.
pub fn seconds(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    match seconds {
        0.1.. => format!("{seconds:.2} s"),
        0.001.. => format!("{:.1} ms", 1e3 * seconds),
        _ => format!("{:.2} ms", 1e3 * seconds),
    }
}

/// Prints a note if start values leave too few digits of a precision for the distances.
pub fn comment_on_starts<R: Real>(surface: &Surface, sources: &Sources) {
    let rounded = |start: f64| start.abs() * 0.5 * R::epsilon().wide();
    let largest = sources.iter().map(|source| source.initial().abs()).fold(0.0, f64::max);
    // Edge lengths are computed only if start values may matter.
    if largest == 0.0 {
        return;
    }
    let Some(edge) = EdgeLengths::new(surface).ok().as_ref().and_then(mean_edge) else { return };
    if rounded(largest) > ROUNDING * edge {
        let smallest = sources.start();
        let advice = match rounded(smallest) > ROUNDING * edge {
            true => format!("; subtract the smallest, {}, from all", exact(smallest)),
            false => String::new(),
        };
        note!(
            "distances beyond a start value of {} are rounded by up to {:.1e}, where neighbouring \
                 points are {edge:.1e} apart{advice}",
            exact(largest),
            rounded(largest)
        );
    }
}

/// Prints a note if a path may have enough edges for the rounding errors of their lengths to matter.
pub fn comment_on_size<R: Real>(surface: &Surface) {
    let most = surface.rows().max(surface.cols());
    if most as f64 * R::epsilon().wide() > ROUNDING {
        note!(
            "distances over {most} edges in a row can err by thousandths, since rounding adds up \
                 in single precision; `geosweep distance --precision double` avoids this"
        );
    }
}

const DIAGONALS: [Direction; 4] =
    [Direction::NorthEast, Direction::NorthWest, Direction::SouthEast, Direction::SouthWest];

/// Prints a note on unreached points that touch reached points only at a corner, as on a line of a mask that
/// looks connected.
pub fn comment_on_corners<R: Real>(surface: &Surface, map: &DistanceMap<R>) {
    // If only a part of the map is computed, points beyond its edge are unreached for that reason.
    if map.report.ends_at.is_some() {
        return;
    }
    let Report { points, reached, converged, .. } = map.report;
    // If the iterations ended early, wavefronts may still be on their way.
    if reached == points || !converged {
        return;
    }
    let is_reached = |row, col| map.distance(row, col) < R::FAR;
    let is_cut = |(row, col): (usize, usize)| {
        surface.has(row, col)
            && !is_reached(row, col)
            && DIAGONALS.into_iter().any(|to| {
                let other = map.chart.neighbour(row, col, to);
                other.is_some_and(|(row, col)| surface.has(row, col) && is_reached(row, col))
            })
    };
    let places = (0..map.chart.points()).map(|point| map.chart.position(point));
    let cut = places.filter(|&place| is_cut(place)).count();
    if cut > 0 {
        note!(
            "{} not reached though next to a reached one: the two touch only at a corner, between \
                 holes, where no path passes; widen such lines of the mask to points side by side",
            match cut {
                1 => "1 point is".into(),
                cut => format!("{cut} points are"),
            }
        );
    }
}

/// The rounding error of distances at which a note is printed, as a fraction of a typical edge.
const ROUNDING: f64 = 1e-3;

/// Returns the mean length of the edges along rows and columns.
fn mean_edge(edges: &EdgeLengths<f32>) -> Option<f64> {
    let chart = edges.chart();
    let (mut sum, mut count) = (0.0, 0u32);
    for (row, col) in (0..chart.points()).map(|point| chart.position(point)) {
        for to in [Direction::East, Direction::North] {
            let length = edges.length(row, col, to);
            if length < f32::FAR {
                sum += f64::from(length);
                count += 1;
            }
        }
    }
    (count > 0).then(|| sum / f64::from(count))
}

/// Prints a warning that the map has not converged, unless the user has limited the iterations.
pub fn warn_of_no_convergence(options: &Options, iterations: u32, residual: f64, tolerance: f64) {
    if options.iterations.is_some() {
        return;
    }
    let iterations = counted(iterations, "iteration");
    warning!(
        "not converged after {iterations}: the last changed a distance by a \
             fraction of {residual:.1e}, the tolerance is {tolerance:.1e}; give more --iterations"
    );
}
