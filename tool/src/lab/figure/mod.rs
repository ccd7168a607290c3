//! Implements `geosweep figure`, which redraws figures of the paper with this crate.

mod canonical;
mod convergence;
mod face;
mod maze;
mod scans;
mod table;
mod table_1;
mod table_2;
mod update;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::terminal::Outcome;

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
  geosweep figure face -o face.png
  geosweep figure maze -o maze.png
  geosweep figure table-1 -o table-1.md
  geosweep figure table-2 -o table-2.md
  geosweep figure update -o update.png
  geosweep figure all -o figures";

#[derive(Subcommand)]
enum Figure {
    /// All figures and both tables, each with its default options
    All(AllArgs),
    /// Figures 1 and 2: a grid on a surface, and the update of a point from a triangle
    Update(update::Args),
    /// Figures 3 and 4: the triangles from which each scan updates a point, and the order of updates
    Scans(scans::Args),
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

/// The arguments of `geosweep figure all`.
#[derive(clap::Args)]
struct AllArgs {
    /// Folder for update.png, scans.png, convergence.png, maze.png, face.png, canonical.png, table-1.md and
    /// table-2.md
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Machine on which the times were measured, for the tables
    #[arg(long, value_name = "TEXT")]
    machine: Option<String>,
}

/// All figures in the paper's order, with the extensions of their files.
const ALL: [(&str, &str); 8] = [
    ("update", "png"),
    ("scans", "png"),
    ("convergence", "png"),
    ("maze", "png"),
    ("face", "png"),
    ("canonical", "png"),
    ("table-1", "md"),
    ("table-2", "md"),
];

/// The command line of one figure. Parsing it supplies the default options.
#[derive(Parser)]
struct Line {
    #[command(subcommand)]
    figure: Figure,
}

pub fn run(args: &Args) -> Outcome {
    args.figure.run()
}

impl Figure {
    fn run(&self) -> Outcome {
        match self {
            Self::All(args) => args.run(),
            Self::Update(args) => update::run(args),
            Self::Scans(args) => scans::run(args),
            Self::Canonical(args) => canonical::run(args),
            Self::Convergence(args) => convergence::run(args),
            Self::Face(args) => face::run(args),
            Self::Maze(args) => maze::run(args),
            Self::Table1(args) => table_1::run(args),
            Self::Table2(args) => table_2::run(args),
        }
    }
}

impl AllArgs {
    fn run(&self) -> Outcome {
        if !self.output.is_dir() {
            let folder = self.output.display();
            return Err(format!("{folder}: there is no such folder; create it first").into());
        }
        for (name, extension) in ALL {
            let path = self.output.join(name).with_extension(extension);
            let words = ["figure".into(), name.into(), "-o".into(), path.into_os_string()];
            let machine = self.machine.iter().filter(|_| extension == "md");
            let machine = machine.flat_map(|machine| ["--machine".into(), machine.into()]);
            Line::try_parse_from(words.into_iter().chain(machine))?.figure.run()?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
