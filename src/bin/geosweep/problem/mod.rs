//! The arguments that all commands on a distance map share: the surface, the sources and the
//! solver; and the map they give.

mod args;
mod curve_files;
mod outputs;
mod picture;
mod solver;
mod sources;
mod summary;
mod surface;

use std::path::Path;

use geosweep::surface::builtin::Builtin;
use geosweep::{DistanceMap, Options, Report, Sources, distance_map};

pub use args::{Problem, ProblemArgs};
pub use curve_files::CurveFiles;
pub use outputs::check_outputs;
pub use picture::PictureArgs;
pub use solver::{SolverArgs, device_choice};
pub use sources::{SourceArgs, place};
pub use summary::MapSummary;
pub use surface::{Scene, SurfaceArgs};

use crate::say;
use crate::spinner::Spinner;

/// Finite numbers with commas between them.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |text: &str| match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{text}` is not a finite number")),
    };
    text.split(',').map(number).collect()
}

/// A sentence on the built-in surfaces for the end of a command's help.
pub fn builtin_names() -> String {
    format!("Built-in surfaces:\n  {}; sheared-plane@DEGREES says by what angle.", Builtin::names())
}

/// The map from some sources, with what the user should know of it.
pub fn solve(
    scene: &Scene,
    sources: &Sources,
    solver: &SolverArgs,
    options: &Options,
) -> Result<DistanceMap, geosweep::Error> {
    let _spinner = Spinner::new("computing distances");
    let map = distance_map(&scene.surface, sources, options)?;
    comment(&map.report, solver);
    Ok(map)
}

/// All files that are read.
pub fn inputs<'a>(
    surface: &'a SurfaceArgs,
    sources: &'a SourceArgs,
) -> impl Iterator<Item = &'a Path> {
    surface.inputs().chain(&sources.source_curve).map(AsRef::as_ref)
}

/// What the user should know though the map is there.
pub fn comment(report: &Report, solver: &SolverArgs) {
    if let Some(reason) = &report.fallback {
        say("note", format_args!("computed on the CPU, since Vulkan cannot be used: {reason}"));
    }
    if !report.converged {
        warn_of_no_convergence(report.iterations, report.residual, solver.tolerance);
    }
    let unreached = report.points - report.reached;
    if unreached > 0 {
        let points = report.points;
        say("note", format_args!("{unreached} of {points} points cannot be reached"));
    }
}

pub fn warn_of_no_convergence(iterations: u32, residual: f64, tolerance: f64) {
    say(
        "warning",
        format_args!(
            "not converged after {iterations} iterations: the last changed a distance by a \
             fraction of {residual:.1e}, the tolerance is {tolerance:.1e}; give more --iterations"
        ),
    );
}
