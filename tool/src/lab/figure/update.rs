//! Implements `geosweep figure update`: the subject of the paper's figures 1 and 2, in a new drawing.

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
The left panel has a point of the grid with the two directions of its parameters and
one of its triangles. The middle panel has the same on a surface, where the directions
have lengths and an angle. The right panel has the planar update: the straight front
that reaches x₁ and x₂ at t₁ and t₂ reaches x₀ at t₀.

Example:
  geosweep figure update -o update.png";

pub fn run(args: &Args) -> Outcome {
    let output = png_output(&args.output)?;
    done([], &commit([stage_picture(output, update_figure)?])?);
    Ok(ExitCode::SUCCESS)
}
