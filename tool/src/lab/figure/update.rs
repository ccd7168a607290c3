//! Implements `geosweep figure update`: a new drawing of what the paper's figures 1 and 2 show.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::output::{commit, done, png_output, stage_picture};
use crate::picture::update_figure;
use crate::terminal::Outcome;

/// The arguments of `geosweep figure update`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Output file for the picture
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
}

const EXAMPLES: &str = "\
The left panel shows a point of the grid, the directions of rows and columns, and one of
the point's triangles. The middle panel shows them on a surface, where the directions
have lengths and an angle. The right panel shows the planar update: a straight front
reaches x₁ at t₁, x₂ at t₂ and x₀ at t₀.

Example:
  geosweep figure update -o update.png";

pub fn run(args: &Args) -> Outcome {
    let output = png_output(&args.output)?;
    done([], &commit([stage_picture(output, update_figure)?])?);
    Ok(ExitCode::SUCCESS)
}
