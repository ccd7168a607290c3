//! Where distances start.

use std::path::PathBuf;

use geosweep::Sources;
use geosweep::io::{IoError, read_curves};

use crate::numbers::numbers;

#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("sources").required(true).multiple(true))]
pub struct SourceArgs {
    /// A point source: row and column, which may be fractional, and the distance it starts with
    /// (default 0); repeatable
    #[arg(short, long, value_name = "R,C[,T0]", group = "sources", help_heading = "Sources")]
    #[arg(value_parser = point, allow_hyphen_values = true)]
    source: Vec<[f64; 3]>,
    /// Curves, every point of which is a source: an .npy array (K, 2) of rows and columns of one
    /// curve, or (K, 5) as this tool writes curves, which rows of NaN divide; or a text file with a
    /// line `row,col` per vertex, which may have more columns if its first line names them, where
    /// `curve` divides curves and 1 in `closed` closes them; repeatable
    #[arg(long, value_name = "FILE", group = "sources", help_heading = "Sources")]
    source_curve: Vec<PathBuf>,
    /// Point sources: rows and columns in a file as for --source-curve, of which only the vertices
    /// count, as samples are written; repeatable
    #[arg(long, value_name = "FILE", group = "sources", help_heading = "Sources")]
    source_points: Vec<PathBuf>,
}

fn point(text: &str) -> Result<[f64; 3], String> {
    match numbers(text)?[..] {
        [row, col] => Ok([row, col, 0.0]),
        [row, col, start] => Ok([row, col, start]),
        _ => Err("a source is a row and a column, and perhaps a start value: R,C[,T0]".into()),
    }
}

impl SourceArgs {
    pub fn sources(&self) -> Result<Sources, IoError> {
        let points = self.source.iter().fold(Sources::default(), |sources, &[row, col, start]| {
            sources.and_point(row, col, start)
        });
        let points = self.source_points.iter().try_fold(points, |sources, path| {
            let places = read_curves(path)?.into_iter().flatten();
            Ok::<_, IoError>(places.fold(sources, |all, [row, col]| all.and_point(row, col, 0.0)))
        })?;
        self.source_curve.iter().try_fold(points, |sources, path| {
            let curves = read_curves(path)?.into_iter();
            Ok(curves.fold(sources, |sources, curve| sources.and_curve(curve, 0.0)))
        })
    }

    /// The files that sources are read from.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.source_curve.iter().chain(&self.source_points)
    }
}
