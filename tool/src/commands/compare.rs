//! Implements `geosweep compare`, which measures the difference of two maps.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use geosweep::io::{Grid, read_map};
use serde::Serialize;

use crate::terminal::{Outcome, print, print_json};

/// The arguments of `geosweep compare`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// A distance map: .npy (M, N), .npz, .tif, .asc or .exr
    a: PathBuf,
    /// The map to compare it with, of the same size
    b: PathBuf,
    /// Largest difference that passes, as a fraction of B's largest finite value, or absolute if that value
    /// is 0
    #[arg(short, long, value_name = "T", default_value_t = 1e-5, value_parser = tolerance)]
    tolerance: f64,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Prints the largest and the mean |A - B| over the points that are finite in both
maps, as fractions of B's largest finite value, and the number of points that are
finite in one map only. +infinity marks points that no source reaches; NaN and
-infinity are errors.

Exit status: 0 if the largest difference is within the tolerance and both maps are
finite at the same points (which may be none), 1 if not, 2 if the maps cannot be
compared.

Examples:
  geosweep compare vulkan.npy cpu.npy
  geosweep compare map.npy exact.npy --tolerance 1e-3 --json";

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(tolerance) if tolerance >= 0.0 => Ok(tolerance),
        _ => Err("a tolerance is a number of at least 0".into()),
    }
}

#[derive(Serialize)]
struct Comparison {
    /// The largest difference, relative to `scale`.
    max_difference: f64,
    /// The mean difference, relative to `scale`.
    mean_difference: f64,
    /// The row and column of the largest difference.
    at: Option<(usize, usize)>,
    /// The largest finite magnitude of B, or `None` if it is 0. Differences are then absolute.
    scale: Option<f64>,
    /// The number of points that are finite in both maps.
    compared: usize,
    only_in_a: usize,
    only_in_b: usize,
    equal: bool,
}

pub fn run(args: &Args) -> Outcome {
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let (rows, cols) = (b.rows, b.cols);
    if (a.rows, a.cols) != (rows, cols) {
        return Err(format!(
            "{} has {} x {} points and {} has {rows} x {cols}; only maps of one size can be compared",
            args.a.display(),
            a.rows,
            a.cols,
            args.b.display()
        )
        .into());
    }
    let comparison = compare(&a, &b, args.tolerance);
    if args.json {
        print_json("compare", &comparison)?;
    } else {
        print(&comparison)?;
    }
    Ok(if comparison.equal { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Reads a map and checks that its values are distances or +infinity.
fn read(path: &Path) -> Result<Grid<f64>, Box<dyn Error>> {
    let map = read_map(path)?;
    let wrong = |value: &f64| value.is_nan() || *value == f64::NEG_INFINITY;
    if let Some(index) = map.values.iter().position(wrong) {
        let (name, row, col) = (path.display(), index / map.cols, index % map.cols);
        let value = map.values[index];
        return Err(format!(
            "{name}: the value at row {row}, column {col} is {value}; a map has finite numbers, and \
             +infinity where no source reaches"
        )
        .into());
    }
    Ok(map)
}

fn compare(a: &Grid<f64>, b: &Grid<f64>, tolerance: f64) -> Comparison {
    let largest = b.values.iter().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
    let scale = (largest > 0.0).then_some(largest);
    let (mut max, mut sum, mut at) = (0.0, 0.0, 0);
    let (mut compared, mut only_in_a, mut only_in_b) = (0, 0, 0);
    for (index, (a, b)) in a.values.iter().zip(&b.values).enumerate() {
        match (a.is_finite(), b.is_finite()) {
            (true, true) => {
                let difference = (a - b).abs() / scale.unwrap_or(1.0);
                compared += 1;
                sum += difference;
                if difference > max {
                    (max, at) = (difference, index);
                }
            }
            (true, false) => only_in_a += 1,
            (false, true) => only_in_b += 1,
            (false, false) => {}
        }
    }
    let mean = sum / compared.max(1) as f64;
    let equal = max <= tolerance && only_in_a + only_in_b == 0;
    let at = (compared > 0).then_some((at / b.cols, at % b.cols));
    Comparison {
        max_difference: max,
        mean_difference: mean,
        at,
        scale,
        compared,
        only_in_a,
        only_in_b,
        equal,
    }
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { max_difference, mean_difference, at, scale, compared, .. } = self;
        let Self { only_in_a, only_in_b, equal, .. } = self;
        if let Some((row, col)) = at {
            if let Some(scale) = scale {
                writeln!(f, "differences as fractions of {scale}, B's largest value:")?;
            }
            writeln!(f, "max |A - B|   {max_difference:.3e} (at row {row}, column {col})")?;
            writeln!(f, "mean |A - B|  {mean_difference:.3e} over {compared} points")?;
        } else {
            writeln!(f, "max |A - B|   none: no point is finite in both")?;
        }
        writeln!(f, "finite only   in A: {only_in_a}, in B: {only_in_b}")?;
        f.write_str(match (equal, compared) {
            (true, 0) => "equal: neither map reaches any point",
            (true, _) => "equal within the tolerance",
            (false, _) => "different",
        })
    }
}
