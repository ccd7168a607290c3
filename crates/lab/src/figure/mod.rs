//! Implements `geosweep-lab figure`, which redraws figures of the paper with this crate.

mod canonical;
mod convergence;
mod face;
mod maze;
mod table;
mod table_1;
mod table_2;

use clap::Subcommand;

use geosweep_cli::terminal::Outcome;

/// The arguments of `geosweep-lab figure`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    #[command(subcommand)]
    figure: Figure,
}

const EXAMPLES: &str = "\
Examples:
  geosweep-lab figure canonical -o canonical.png
  geosweep-lab figure convergence -o convergence.png --csv convergence.csv
  geosweep-lab figure face -o face.png
  geosweep-lab figure maze -o maze.png
  geosweep-lab figure table-1 -o table-1.md
  geosweep-lab figure table-2 -o table-2.md";

#[derive(Subcommand)]
enum Figure {
    /// Figure 8: a face, three bendings of one surface, and their canonical forms
    Canonical(canonical::Args),
    /// Figure 5: how the error falls as the grid gets finer
    Convergence(convergence::Args),
    /// Figure 7: contours, shortest paths, a Voronoi diagram and offset curves on a face
    Face(face::Args),
    /// Figure 6: the distance map on a maze, iteration by iteration
    Maze(maze::Args),
    /// Table 1: times of all pairs, by raster scans in lanes and by fast marching
    #[command(name = "table-1")]
    Table1(table_1::Args),
    /// Table 2: times and memory of single maps, on the CPU and on a Vulkan device
    #[command(name = "table-2")]
    Table2(table_2::Args),
}

pub fn run(args: &Args) -> Outcome {
    match &args.figure {
        Figure::Canonical(args) => canonical::run(args),
        Figure::Convergence(args) => convergence::run(args),
        Figure::Face(args) => face::run(args),
        Figure::Maze(args) => maze::run(args),
        Figure::Table1(args) => table_1::run(args),
        Figure::Table2(args) => table_2::run(args),
    }
}
