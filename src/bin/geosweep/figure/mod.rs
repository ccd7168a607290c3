//! `geosweep figure`: figures of the paper, redrawn with this crate.

mod canonical;
mod convergence;
mod maze;

use clap::Subcommand;

use crate::Outcome;

/// The arguments of `geosweep figure`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    #[command(subcommand)]
    figure: Figure,
}

const EXAMPLES: &str = "\
Examples:
  geosweep figure canonical -o canonical.png
  geosweep figure convergence -o convergence.png --csv convergence.csv
  geosweep figure maze -o maze.png";

#[derive(Subcommand)]
enum Figure {
    /// Figure 8: surfaces, bendings of one, and their canonical forms
    Canonical(canonical::Args),
    /// Figure 5: how the error falls as the grid gets finer
    Convergence(convergence::Args),
    /// Figure 6: the distance map on a maze, iteration by iteration
    Maze(maze::Args),
}

pub fn run(args: &Args) -> Outcome {
    match &args.figure {
        Figure::Canonical(args) => canonical::run(args),
        Figure::Convergence(args) => convergence::run(args),
        Figure::Maze(args) => maze::run(args),
    }
}
