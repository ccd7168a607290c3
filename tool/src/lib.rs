//! The command-line tool `geosweep`, which computes distance maps from files to files.
//!
//! This library is the tool itself and the parts that the laboratory (`crates/lab`) shares with it. It makes no
//! promise of stability: programs use the package `geosweep`.

#![doc(hidden)]

#[macro_use]
pub mod terminal;

pub mod ceilings;
pub mod choices;
pub mod columns;
pub mod command_line;
mod commands;
pub mod numbers;
pub mod output;
pub mod picture;
mod pipelines;
pub mod precision;
mod problem;
mod surface_arg;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use command_line::CommandLine;
use commands::{
    builtin, canonical, compare, contours, devices, distance, notices, offset, pairwise, path,
    profile, ridges, sample, value, voronoi,
};
use terminal::Outcome;

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

Exit status: 0 if all requested files were written; 1 if `compare` finds a difference;
2 on an error.

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
    Canonical(Box<canonical::Args>),
    /// List the Vulkan devices, and why some cannot be used
    Devices(devices::Args),
    /// Compare two distance maps
    Compare(compare::Args),
    /// Write a built-in surface's positions to a file
    Builtin(builtin::Args),
    /// Profile a map on a Vulkan device: every pass, its cost and what bounds it
    Profile(Box<profile::Args>),
    /// Print the notices and licences of the packages that the tool contains
    Notices,
}

impl CommandLine for Tool {
    fn is_quiet(&self) -> bool {
        self.quiet
    }

    fn run(&self) -> Outcome {
        match &self.command {
            Command::Distance(args) => distance::run(args),
            Command::Pairwise(args) => pairwise::run(args),
            Command::Contours(args) => contours::run(args),
            Command::Value(args) => value::run(args),
            Command::Path(args) => path::run(args),
            Command::Voronoi(args) => voronoi::run(args),
            Command::Offset(args) => offset::run(args),
            Command::Ridges(args) => ridges::run(args),
            Command::Sample(args) => sample::run(args),
            Command::Canonical(args) => canonical::run(args),
            Command::Devices(args) => devices::run(args),
            Command::Compare(args) => compare::run(args),
            Command::Builtin(args) => builtin::run(args),
            Command::Profile(args) => profile::run(args),
            Command::Notices => notices::run(),
        }
    }
}

/// Runs the tool with the arguments of the process.
pub fn main() -> ExitCode {
    command_line::main::<Tool>()
}
