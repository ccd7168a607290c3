//! Determines the meaning of a table's columns, and of the properties of GeoJSON features, from their names.

use std::fmt;

use super::content::Coordinates;
use super::frame::MapCoordinates;
use geosweep_surface::shown::excerpt;

/// Names of start values.
const STARTS: [&str; 8] = [
    "t0",
    "start",
    "start_value",
    "start_time",
    "initial",
    "initial_value",
    "initial_time",
    "time",
];

/// Words by which a column's name suggests that it changes distances. A column with such a word that is not a start
/// value is an error: if it were ignored, the map could be wrong.
const WEIGHTY: [&str; 19] = [
    "t0", "t", "start", "starts", "initial", "init", "time", "times", "delay", "delays", "offset",
    "arrival", "value", "weight", "speed", "velocity", "slowness", "cost", "head",
];

/// Pairs of names for places, with the coordinates that they stand for.
const PLACES: [(&[&str], &[&str], Coordinates); 4] = [
    (&["row"], &["col", "column"], Coordinates::Grid),
    (&["x"], &["y"], Coordinates::Map(MapCoordinates::Surface)),
    (&["easting", "east"], &["northing", "north"], Coordinates::Map(MapCoordinates::Projected)),
    (
        &["lon", "lng", "long", "longitude"],
        &["lat", "latitude"],
        Coordinates::Map(MapCoordinates::Geographic),
    ),
];

/// A column or property with its name, for messages.
pub(super) struct Named<'a>(pub &'static str, pub &'a str);

impl fmt::Display for Named<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "in {} {}", self.0, excerpt(self.1))
    }
}

/// Normalizes a name: in lower case, words joined by `_`, without a unit in brackets at the end.
fn plain(name: &str) -> String {
    let name = name.trim().trim_matches(['"', '\'']);
    let unit = name.find(['(', '[']).filter(|&at| at > 0 && name.ends_with([')', ']']));
    let name = name[..unit.unwrap_or(name.len())].trim();
    name.to_lowercase().replace([' ', '-', '.'], "_")
}

/// Returns whether a name is that of a start value.
pub(super) fn is_start(name: &str) -> bool {
    STARTS.contains(&plain(name).as_str())
}

/// Returns an error for a name that may be meant to change distances and is not that of a start value.
pub(super) fn check_unused(name: &str, what: &str) -> Result<(), String> {
    let name_plain = plain(name);
    match name_plain.split('_').any(|word| WEIGHTY.contains(&word)) {
        false => Ok(()),
        true => Err(format!(
            "the {what} `{}` may be meant to change distances, which only start values do; name it \
             t0 if it is one, else rename it or leave it out",
            excerpt(name)
        )),
    }
}

/// The columns that are used, by their positions in a record.
#[derive(Debug)]
pub(super) struct Columns {
    pub names: Vec<String>,
    pub place: [usize; 2],
    pub coordinates: Coordinates,
    pub start: Option<usize>,
    pub curve: Option<usize>,
    pub closed: Option<usize>,
}

impl Columns {
    /// Returns the columns that a table's first line names, or `None` if it does not name a place.
    pub fn new(names: Vec<String>) -> Result<Option<Self>, String> {
        let plains: Vec<_> = names.iter().map(|name| plain(name)).collect();
        let one_of = |wanted: &[&str]| {
            let mut found =
                (0..plains.len()).filter(|&index| wanted.contains(&plains[index].as_str()));
            match (found.next(), found.next()) {
                (Some(first), Some(second)) => Err(format!(
                    "the columns {} and {} mean the same; leave one of them out",
                    excerpt(&names[first]),
                    excerpt(&names[second])
                )),
                (found, _) => Ok(found),
            }
        };
        let mut pairs = Vec::new();
        for (first, second, coordinates) in PLACES {
            match (one_of(first)?, one_of(second)?) {
                (Some(first), Some(second)) => pairs.push(([first, second], coordinates)),
                // Rows and columns take precedence over other coordinates. So a table that names only one of them is an
                // error.
                (Some(_), None) | (None, Some(_)) if coordinates == Coordinates::Grid => {
                    return Ok(None);
                }
                _ => {}
            }
            if pairs.len() == 1 && pairs[0].1 == Coordinates::Grid {
                break;
            }
        }
        if let [(a, _), (b, _), ..] = pairs[..] {
            let name = |index: usize| excerpt(&names[index]);
            return Err(format!(
                "the columns {}, {} and {}, {} both say where places are; leave one pair out",
                name(a[0]),
                name(a[1]),
                name(b[0]),
                name(b[1])
            ));
        }
        let Some((place, coordinates)) = pairs.pop() else { return Ok(None) };
        let (start, curve, closed) = (one_of(&STARTS)?, one_of(&["curve"])?, one_of(&["closed"])?);
        Ok(Some(Self { names, place, coordinates, start, curve, closed }))
    }

    /// Returns the columns of a table without a line of names.
    pub fn unnamed(count: usize) -> Self {
        let names = ["row", "col", "t0"].iter().take(count).map(|&name| name.into()).collect();
        let start = (count == 3).then_some(2);
        let coordinates = Coordinates::Grid;
        Self { names, place: [0, 1], coordinates, start, curve: None, closed: None }
    }

    /// Returns the names of columns that are not used. An index column, which has no name or a generic one, is left
    /// out.
    pub fn unused(&self) -> Result<Vec<String>, String> {
        let used = |index: usize| {
            self.place.contains(&index)
                || [self.start, self.curve, self.closed].contains(&Some(index))
        };
        let is_named = |name: &str| {
            let plain = plain(name);
            !plain.is_empty() && !plain.starts_with("unnamed:")
        };
        let unused = self.names.iter().enumerate().filter(|(index, _)| !used(*index));
        let unused: Vec<_> =
            unused.map(|(_, name)| name.clone()).filter(|name| is_named(name)).collect();
        unused.iter().try_for_each(|name| check_unused(name, "column"))?;
        Ok(unused)
    }
}

/// Returns the number of a cell if it is finite. Otherwise returns an error.
pub(super) fn finite(number: f64, text: &str, named: &Named) -> Result<f64, String> {
    match number.is_finite() {
        true => Ok(number),
        false => Err(format!("`{}` {named} is not a finite number", excerpt(text))),
    }
}
