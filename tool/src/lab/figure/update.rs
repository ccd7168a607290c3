//! Implements `geosweep figure update`: the subject of the paper's figures 1 and 2, in a drawing of our own.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::output::{commit, done, png_output, stage_picture};
use crate::picture::update_figure;
use crate::terminal::Outcome;

/// The arguments of `geosweep figure update`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Where to write the picture
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
}

const EXAMPLES: &str = "\
On the left a point of the grid with the two directions of its parameters and one of
its triangles; in the middle the same on a surface, where directions have lengths
and an angle. On the right the planar update: the straight front that reaches x₁
and x₂ at t₁ and t₂ reaches x₀ at t₀.

Example:
  geosweep figure update -o update.png";

pub fn run(args: &Args) -> Outcome {
    let output = png_output(&args.output)?;
    done([], &commit([stage_picture(output, update_figure)?])?);
    Ok(ExitCode::SUCCESS)
}
