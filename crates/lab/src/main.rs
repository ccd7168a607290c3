//! The laboratory: measures the accuracy and speed of the engines, tunes devices, and draws the paper's figures and
//! tables.

mod accuracy;
mod bench;
mod figure;
mod frames;
mod lists;
mod panels;
mod plot;
mod publication;
mod reference;
mod tune;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use geosweep_cli::command_line::{self, CommandLine};
use geosweep_cli::terminal::Outcome;

/// Measures geosweep's engines and draws the figures of the paper
#[derive(Parser)]
#[command(version, max_term_width = 100, after_help = STATUS)]
struct Laboratory {
    /// Print only warnings and errors
    #[arg(short, long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

const STATUS: &str = "\
Exit status: 0 if all requested files were written; 1 if `tune` finds a difference; 2 on
an error.";

#[derive(Subcommand)]
enum Command {
    /// Measure the solvers against exact distances on the built-in surfaces
    Accuracy(accuracy::Args),
    /// Time the engines and schedules side by side, and show what bounds them
    Bench(bench::Args),
    /// Find the portions of work and the schedule that suit a Vulkan device
    Tune(tune::Args),
    /// Time maps of a moving surface in frames on a Vulkan device
    Frames(frames::Args),
    /// Redraw a figure of the paper
    Figure(figure::Args),
}

impl CommandLine for Laboratory {
    fn is_quiet(&self) -> bool {
        self.quiet
    }

    fn run(&self) -> Outcome {
        match &self.command {
            Command::Accuracy(args) => accuracy::run(args),
            Command::Bench(args) => bench::run(args),
            Command::Tune(args) => tune::run(args),
            Command::Frames(args) => frames::run(args),
            Command::Figure(args) => figure::run(args),
        }
    }
}

fn main() -> ExitCode {
    command_line::main::<Laboratory>()
}
