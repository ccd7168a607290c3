//! Parses numbers in arguments.

use std::ops::RangeInclusive;

use geosweep::io::GridFrame;
use geosweep::shown::{exact, excerpt};

/// A list of numbers.
#[derive(Clone, Debug)]
pub struct Numbers(pub Vec<f64>);

impl Numbers {
    pub fn parse(text: &str) -> Result<Self, String> {
        numbers(text).map(Self)
    }
}

/// Returns a parser of a whole number in a range. `what` names the counted things, such as "points per side".
pub fn whole(
    what: &'static str,
    range: RangeInclusive<usize>,
) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync {
    move |text| match text.trim().parse() {
        Ok(number) if range.contains(&number) => Ok(number),
        _ => {
            let limits = match (range.start(), range.end()) {
                (first, &usize::MAX) => format!("; give {first} or more"),
                (first, last) => format!(" from {first} to {last}"),
            };
            Err(format!("`{}` is not a number of {what}{limits}", excerpt(text)))
        }
    }
}

/// Parses finite numbers separated by commas.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |text: &str| match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{}` is not a finite number", excerpt(text))),
    };
    text.split(',').map(number).collect()
}

/// Parses a place on the grid, which may be fractional.
pub fn place(text: &str) -> Result<[f64; 2], String> {
    let place = numbers(text)?.try_into();
    place.map_err(|_| "a place is a row and a column: R,C".into())
}

/// Parses a place in map coordinates.
pub fn coordinates(text: &str) -> Result<[f64; 2], String> {
    let place = numbers(text)?.try_into();
    place.map_err(|_| "a place is x (easting, longitude) and y (northing, latitude): X,Y".into())
}

/// Converts map coordinates from the option `option` to row and column.
pub fn place_xy(option: &str, frame: &GridFrame, [x, y]: [f64; 2]) -> Result<[f64; 2], String> {
    frame.place([x, y]).map_err(|reason| format!("{option} {},{}: {reason}", exact(x), exact(y)))
}
