//! Parses which rows of the matrix to compute.

use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

use geosweep::io::{GridFrame, PlaceFile};
use geosweep::shown::excerpt;

use crate::problem::remark;

/// The rows of the matrix, as given on the command line.
#[derive(Clone, Debug)]
pub enum RowsOf {
    Range(Range<usize>),
    File(PathBuf),
}

impl FromStr for RowsOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // A path such as `../file` contains two dots as well, but also a slash next to them.
        let file = || Ok(Self::File(text.into()));
        let Some((first, end)) = text.split_once("..") else { return file() };
        if [first, end].iter().any(|end| end.contains(['/', '\\', '.'])) {
            return file();
        }
        match (first.parse(), end.parse()) {
            (Ok(first), Ok(end)) if first < end => Ok(Self::Range(first..end)),
            (Ok(first), Ok(end)) => {
                Err(format!("{first}..{end} is an empty range; it goes from A to before B"))
            }
            _ => {
                let text = excerpt(text);
                Err(format!(
                    "`{text}` is not a range of rows; it goes from A to before B, as in 0..100, both \
                     whole numbers (./{text} is a file)"
                ))
            }
        }
    }
}

impl RowsOf {
    pub fn file(&self) -> Option<&PathBuf> {
        match self {
            Self::Range(_) => None,
            Self::File(path) => Some(path),
        }
    }

    /// Returns the places of the rows' points on the given grid, and the start values of the rows' distances.
    pub fn places(&self, frame: &GridFrame) -> Result<Vec<([f64; 2], f64)>, String> {
        let points = frame.chart.points();
        match self {
            Self::Range(range) if range.end <= points => {
                let place = |point| {
                    let (row, col) = frame.chart.position(point);
                    ([row as f64, col as f64], 0.0)
                };
                Ok(range.clone().map(place).collect())
            }
            Self::Range(Range { start, end }) => Err(format!(
                "--sources {start}..{end} goes beyond the grid, which has {points} points"
            )),
            Self::File(path) => {
                let file = PlaceFile::read(path).map_err(|error| error.to_string())?;
                let found = file.grid_points(frame).map_err(|error| error.to_string())?;
                remark(path, &file, frame);
                Ok(found.iter().map(|point| (point.at, point.start)).collect())
            }
        }
    }
}
