//! Implements `geosweep builtin`, which writes built-in surfaces to files.

use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::Surface;
use geosweep::io::write_npy;

use crate::output::{commit, done, output_file};
use crate::surface_arg::{SizedBuiltin, builtin_names};
use crate::terminal::{Outcome, counted};

/// The arguments of `geosweep builtin`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// The surface and its size, e.g. torus:257x513
    #[arg(value_name = "NAME:ROWSxCOLS")]
    surface: SizedBuiltin,
    /// Output file for the positions: a float64 array (ROWS, COLS, 3), with NaN at holes
    #[arg(short, long, value_name = "FILE.npy")]
    output: PathBuf,
}

fn examples() -> String {
    format!(
        "\
Surfaces: {}

Examples:
  geosweep builtin sphere:257x257 -o sphere.npy
  geosweep builtin sheared-plane@72:129x129 -o sheared.npy",
        builtin_names()
    )
}

pub fn run(args: &Args) -> Outcome {
    let output = output_file(&args.output, "positions are", "npy")?;
    let surface = args.surface.surface()?;
    let positions = positions(&surface);
    let shape = [surface.rows(), surface.cols(), 3];
    let staged = output.stage(|writer| write_npy(writer, &shape, &positions))?;
    let points = surface.points() as u64;
    done([counted(points, "point")], &commit([staged])?);
    Ok(ExitCode::SUCCESS)
}

fn positions(surface: &Surface) -> Vec<f64> {
    let chart = surface.chart();
    let position = |index| {
        let (row, col) = chart.position(index);
        surface.position(row, col).map_or([f64::NAN; 3], |position| position.to_array())
    };
    (0..chart.points()).flat_map(position).collect()
}
