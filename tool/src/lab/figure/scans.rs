//! Implements `geosweep figure scans`: the paper's figures 3 and 4.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::output::{commit, done, png_output, stage_picture};
use crate::picture::scan_figure;
use crate::terminal::Outcome;

/// The arguments of `geosweep figure scans`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Output file for the picture
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
}

const EXAMPLES: &str = "\
The upper rows show the two triangles from which a scan updates a point, and the order
of the scan: first directed raster scans, then scans turned by 45 degrees. The lower row
shows the order of updates in one scan of each kind. Updates with the same number run at
the same time.

Example:
  geosweep figure scans -o scans.png";

pub fn run(args: &Args) -> Outcome {
    let output = png_output(&args.output)?;
    done([], &commit([stage_picture(output, scan_figure)?])?);
    Ok(ExitCode::SUCCESS)
}
