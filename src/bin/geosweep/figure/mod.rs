//! `geosweep figure`: figures of the paper, redrawn with this crate.

mod canonical;
mod convergence;
mod maze;
mod table_1;

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
  geosweep figure maze -o maze.png
  geosweep figure table-1 -o table-1.md";

#[derive(Subcommand)]
enum Figure {
    /// Figure 8: surfaces, bendings of one, and their canonical forms
    Canonical(canonical::Args),
    /// Figure 5: how the error falls as the grid gets finer
    Convergence(convergence::Args),
    /// Figure 6: the distance map on a maze, iteration by iteration
    Maze(maze::Args),
    /// Table 1: times of all pairs, by raster scans in lanes and by fast marching
    #[command(name = "table-1")]
    Table1(table_1::Args),
}

pub fn run(args: &Args) -> Outcome {
    match &args.figure {
        Figure::Canonical(args) => canonical::run(args),
        Figure::Convergence(args) => convergence::run(args),
        Figure::Maze(args) => maze::run(args),
        Figure::Table1(args) => table_1::run(args),
    }
}
