//! The command-line tool `geosweep`, which computes distance maps from files to files.

mod ceilings;
mod choices;
mod columns;
mod commands;
mod lab;
mod numbers;
mod output;
mod picture;
mod pipelines;
mod precision;
mod problem;
mod surface_arg;
mod terminal;

use std::error::Error;
use std::io;
use std::process::ExitCode;

use clap::error::{ContextValue, ErrorKind};
use clap::{Parser, Subcommand};
use geosweep::shown::excerpt;

use commands::{
    builtin, canonical, compare, contours, devices, distance, notices, offset, pairwise, path,
    profile, ridges, sample, value, voronoi,
};
use lab::{accuracy, bench, figure, frames, tune};
use terminal::say;

/// Geodesic distance maps on parametric surfaces: on a GPU through Vulkan, or on the CPU.
#[derive(Parser)]
#[command(version, max_term_width = 100, after_help = EXAMPLES)]
struct Tool {
    /// Print only warnings and errors
    #[arg(short, long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Arrays are NumPy .npy files, row first. NaN in a surface marks a hole. Rows count
downwards from 0 and columns rightwards from 0, as in a picture. Output files are
written completely or not at all.

Exit status: 0 if all requested files were written; 1 if `compare` or `tune` finds
a difference; 2 on an error.

Examples:
  geosweep distance dem.tif --spacing 30 --source 120,85 -o map.npy --picture map.png
  geosweep compare map.npy reference.npy --tolerance 1e-4
  geosweep distance --help";

#[derive(Subcommand)]
enum Command {
    /// Compute the distance from sources to every point of a surface
    Distance(Box<distance::Args>),
    /// Compute the distances between all points of a surface
    Pairwise(Box<pairwise::Args>),
    /// Draw curves of equal distance
    Contours(Box<contours::Args>),
    /// Print the distance of places between grid points
    Value(Box<value::Args>),
    /// Trace shortest paths back to the sources
    Path(Box<path::Args>),
    /// Divide a surface among its sources
    Voronoi(Box<voronoi::Args>),
    /// Draw curves at given distances from curves
    Offset(Box<offset::Args>),
    /// Find the lines on which fronts meet, the cut locus of the sources
    Ridges(Box<ridges::Args>),
    /// Choose points that are far from one another
    Sample(Box<sample::Args>),
    /// Place a surface in space so that straight distances are close to those along it
    Canonical(canonical::Args),
    /// List the Vulkan devices, and why some cannot be used
    Devices(devices::Args),
    /// Compare two distance maps
    Compare(compare::Args),
    /// Write a built-in surface's positions to a file
    Builtin(builtin::Args),
    /// Measure the solvers against exact distances on the built-in surfaces
    Accuracy(accuracy::Args),
    /// Time the engines and schedules side by side, and show what bounds them
    Bench(bench::Args),
    /// Profile a map on a Vulkan device: every pass, its cost and what bounds it
    Profile(Box<profile::Args>),
    /// Find the portions of work and the schedule that suit a Vulkan device
    Tune(tune::Args),
    /// Time maps of a moving surface in frames on a Vulkan device
    Frames(frames::Args),
    /// Redraw a figure of the paper
    Figure(figure::Args),
    /// Print the notices and licences of the packages that the tool contains
    Notices,
}

/// The exit status for errors. 1 means that maps differ, in `compare` and `tune`, as in diff.
const TROUBLE: u8 = 2;

fn main() -> ExitCode {
    let tool = match Tool::try_parse() {
        Ok(tool) => tool,
        Err(usage) => return usage_exit(&usage),
    };
    if tool.quiet {
        terminal::be_quiet();
    }
    pipelines::keep();
    let outcome = match tool.command {
        Command::Distance(args) => distance::run(&args),
        Command::Pairwise(args) => pairwise::run(&args),
        Command::Contours(args) => contours::run(&args),
        Command::Value(args) => value::run(&args),
        Command::Path(args) => path::run(&args),
        Command::Voronoi(args) => voronoi::run(&args),
        Command::Offset(args) => offset::run(&args),
        Command::Ridges(args) => ridges::run(&args),
        Command::Sample(args) => sample::run(&args),
        Command::Canonical(args) => canonical::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Builtin(args) => builtin::run(&args),
        Command::Accuracy(args) => accuracy::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Profile(args) => profile::run(&args),
        Command::Tune(args) => tune::run(&args),
        Command::Frames(args) => frames::run(&args),
        Command::Figure(args) => figure::run(&args),
        Command::Notices => notices::run(),
    };
    outcome.unwrap_or_else(|error| {
        if !is_broken_pipe(error.as_ref()) {
            say("error", error);
        }
        ExitCode::from(TROUBLE)
    })
}

/// Prints the result of clap when it returns no arguments. Help and version go to standard output. Errors go
/// to standard error in the tool's own form. A command without any arguments prints its help.
fn usage_exit(usage: &clap::Error) -> ExitCode {
    if usage.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        // An error is ignored for the same reason as below.
        let _ = terminal::print(usage.render().to_string().trim_end());
        ExitCode::SUCCESS
    } else if usage.use_stderr() {
        let text = in_short(usage);
        say("error", text.strip_prefix("error: ").unwrap_or(&text).trim_end());
        ExitCode::from(TROUBLE)
    } else {
        // An error is ignored: a reader that has closed the pipe has read enough.
        let _ = usage.print();
        ExitCode::SUCCESS
    }
}

/// Returns clap's message with long quoted arguments shortened.
fn in_short(usage: &clap::Error) -> String {
    let mut text = usage.render().to_string();
    for (_, value) in usage.context() {
        if let ContextValue::String(quoted) = value {
            text = text.replace(quoted.as_str(), &excerpt(quoted));
        }
    }
    text
}

/// Returns whether the error means that the reader of standard output has closed it.
fn is_broken_pipe(error: &(dyn Error + 'static)) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
