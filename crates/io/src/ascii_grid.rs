//! Decodes ESRI ASCII grids (`.asc`): a header of keys, then numbers row by row from the north.

use std::collections::HashMap;

use super::file_spacing::{FileSpacing, LinearUnit};
use super::limits::{check_memory, checked_points};
use super::no_data::{Held, means_no_data};
use super::{Georeference, Grid};
use geosweep_crs::c_number::c_number;
use geosweep_crs::projection_file::{Projection, ProjectionFile};
use geosweep_surface::{Ellipsoid, Spacing};

/// A grid of values. Values are NaN where the file has no data.
pub(super) struct AsciiGrid {
    pub grid: Grid<f64>,
    pub spacing: FileSpacing,
    /// The location of the points, or a message that says which information is missing.
    pub georeference: Result<Georeference, String>,
    /// The ellipsoid of longitudes and latitudes, if it is known.
    pub ellipsoid: Result<Option<Ellipsoid>, String>,
    /// The length of the unit of heights in metres.
    pub metres: f64,
}

/// Default value of cells without data, according to ESRI's description.
const NO_DATA: f64 = -9999.0;

const KEYS: [&str; 10] = [
    "ncols",
    "nrows",
    "xllcorner",
    "xllcenter",
    "yllcorner",
    "yllcenter",
    "cellsize",
    "dx",
    "dy",
    "nodata_value",
];

/// The header: each key with its value as text.
struct Header<'a>(HashMap<String, &'a str>);

/// Decodes a file. `projection` is the text of the `.prj` file beside it.
pub(super) fn decode(bytes: &[u8], projection: Option<&str>) -> Result<AsciiGrid, String> {
    let text =
        std::str::from_utf8(bytes).map_err(|_| "is not an ESRI ASCII grid: it is not text")?;
    let mut tokens = text.trim_start_matches('\u{feff}').split_ascii_whitespace().peekable();
    let mut header = Header(HashMap::new());
    while let Some(key) = tokens.next_if(|token| c_number(token).is_none()) {
        let name = key.to_ascii_lowercase();
        if !KEYS.contains(&&name[..]) {
            let (key, keys) = (shortened(key), KEYS.join(", "));
            return Err(format!("has `{key}` in its header; an ESRI ASCII grid has {keys}"));
        }
        let value = tokens.next().ok_or_else(|| format!("ends after the key {key}"))?;
        if header.0.insert(name, value).is_some() {
            return Err(format!("has the key {key} twice"));
        }
    }
    let (rows, cols) = (header.count("nrows")?, header.count("ncols")?);
    let points = checked_points(rows, cols)?;
    // Each value takes at least two bytes, a digit and a blank. A header that claims more values is rejected here.
    if points > bytes.len() / 2 + 1 {
        return Err(format!("is cut short: it has no room for {rows} x {cols} values"));
    }
    check_memory::<[u64; 2]>(points)?;
    let no_data = header.number("nodata_value")?.unwrap_or(NO_DATA);
    let mut values = Vec::with_capacity(points);
    for token in tokens.by_ref().take(points) {
        let value = c_number(token).ok_or_else(|| {
            let (row, col) = (values.len() / cols, values.len() % cols);
            format!("row {row}, column {col}: `{}` is not a number", shortened(token))
        })?;
        let is_no_data = means_no_data(value, no_data, Held::Single);
        values.push(if is_no_data { f64::NAN } else { value });
    }
    if values.len() < points || tokens.next().is_some() {
        let holds = if values.len() < points { values.len().to_string() } else { "more".into() };
        return Err(format!("holds {holds} values, where {rows} x {cols} make {points}"));
    }
    let cell = header.cell()?;
    let georeference = header.georeference(rows, cell);
    let projection = projection.map(ProjectionFile::parse);
    let spacing = spacing(cell, rows, cols, georeference.as_ref().ok(), projection.as_ref());
    let ellipsoid = match projection.as_ref().map(|file| &file.projection) {
        Some(Projection::Degrees(ellipsoid)) => ellipsoid.clone(),
        _ => Ok(None),
    };
    let metres = projection.and_then(|file| file.height_unit).unwrap_or(1.0);
    Ok(AsciiGrid { grid: Grid::new(rows, cols, values), spacing, georeference, ellipsoid, metres })
}

impl Header<'_> {
    fn count(&self, key: &str) -> Result<usize, String> {
        let text = self.0.get(key);
        let text =
            text.ok_or_else(|| format!("is not an ESRI ASCII grid: its header lacks {key}"))?;
        text.parse().map_err(|_| format!("its {key} `{}` is not a whole number", shortened(text)))
    }

    fn number(&self, key: &str) -> Result<Option<f64>, String> {
        let Some(text) = self.0.get(key) else { return Ok(None) };
        let number = c_number(text);
        number.map(Some).ok_or_else(|| format!("its {key} `{}` is not a number", shortened(text)))
    }

    fn cell(&self) -> Result<Spacing, String> {
        let cell = match (self.number("cellsize")?, self.number("dx")?, self.number("dy")?) {
            (Some(size), None, None) => Spacing::square(size),
            (None, Some(dx), Some(dy)) => Spacing { dx, dy },
            _ => return Err("its header must have either cellsize or both dx and dy".into()),
        };
        let usable = |side: f64| side.is_finite() && side > 0.0;
        match usable(cell.dx) && usable(cell.dy) {
            true => Ok(cell),
            false => {
                Err("its cells have no size: cellsize, dx and dy must be positive and finite"
                    .into())
            }
        }
    }

    fn georeference(&self, rows: usize, cell: Spacing) -> Result<Georeference, String> {
        let middle = |corner: &str, center: &str, side: f64| match (
            self.number(corner)?,
            self.number(center)?,
        ) {
            (Some(corner), None) => Ok(corner + 0.5 * side),
            (None, Some(center)) => Ok(center),
            (None, None) => Err(format!("is not georeferenced: its header lacks {corner}")),
            _ => Err(format!("has both {corner} and {center}")),
        };
        let x = middle("xllcorner", "xllcenter", cell.dx)?;
        let y = middle("yllcorner", "yllcenter", cell.dy)?;
        let origin = [x, y + (rows - 1) as f64 * cell.dy];
        match origin.iter().all(|number| number.is_finite()) {
            true => {
                let (down, right) = ([0.0, -cell.dy], [cell.dx, 0.0]);
                Ok(Georeference { origin, down, right, system: None })
            }
            false => Err("is not georeferenced: its corner is not finite".into()),
        }
    }
}

/// Returns the distance between points, or the reason why it is not a length.
fn spacing(
    cell: Spacing,
    rows: usize,
    cols: usize,
    georeference: Option<&Georeference>,
    projection: Option<&ProjectionFile>,
) -> FileSpacing {
    let known = |name, said| FileSpacing::Known(cell, LinearUnit { name, said });
    let Some(projection) = projection else {
        if georeference.is_some_and(|georeference| seems_in_degrees(georeference, rows, cols)) {
            return FileSpacing::Degrees(
                "the file's corners and cell size look like degrees, and it does not say its unit (a .prj \
                 beside it would)",
            );
        }
        return known(None, false);
    };
    let height_unit = projection.height_unit.unwrap_or(1.0);
    match &projection.projection {
        Projection::Degrees(_) => {
            FileSpacing::Degrees("the .prj beside the file gives its cell size in degrees")
        }
        map if map.is_in_metres() && height_unit == 1.0 => known(Some("m"), true),
        map if map.is_in_metres() => FileSpacing::Unusable(
            "the .prj beside the file gives its cell size in metres and its heights in another unit".into(),
        ),
        map if map.is_in(height_unit) => known(None, true),
        // Heights have no unit in this format and are usually in metres, so distances in another unit are of no use.
        Projection::Map(_) => FileSpacing::Unusable(
            "the .prj beside the file gives its cell size in a unit other than metres".into(),
        ),
    }
}

/// Returns whether coordinates look like degrees: in the range of longitude and latitude, with small cells, and not at
/// the origin.
fn seems_in_degrees(georeference: &Georeference, rows: usize, cols: usize) -> bool {
    let corners = [[-0.5, -0.5], [rows as f64 - 0.5, cols as f64 - 0.5]];
    let inside = corners.map(|corner| {
        let [x, y] = georeference.coordinates(corner);
        x.abs() <= 360.5 && y.abs() <= 90.5
    });
    let [[west, north], [_, south]] = corners.map(|corner| georeference.coordinates(corner));
    let at_origin = west == 0.0 && (south == 0.0 || north == 0.0);
    inside == [true; 2] && georeference.right[0] < 1.0 && !at_origin
}

fn shortened(token: &str) -> String {
    match token.char_indices().nth(24) {
        Some((end, _)) => format!("{}...", &token[..end]),
        None => token.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const HEADER: &str = "ncols 3\nnrows 2\nxllcorner 1000\nyllcorner 2000\ncellsize 10\n";

    fn grid(text: &str) -> AsciiGrid {
        decode(text.as_bytes(), None).unwrap_or_else(|error| panic!("{text}: {error}"))
    }

    #[test]
    fn headers_vary() {
        let centers = "NCOLS 3 NROWS 2 XLLCENTER 1005 YLLCENTER 2005 DX 10 DY 10";
        for text in [
            format!("{HEADER}1 2 3 4 5 6"),
            format!("{centers}\r\n1 2\t3\r\n\r\n4 5 6"),
            format!("{HEADER}nodata_value NaN\n1,0 2 3\n4 5e0 6"),
        ] {
            let read = grid(&text);
            assert_eq!(read.grid.values, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{text}");
            assert_eq!(read.georeference.unwrap().origin, [1005.0, 2015.0], "{text}");
            let unit = LinearUnit { name: None, said: false };
            assert_eq!(read.spacing, FileSpacing::Known(Spacing::square(10.0), unit));
        }
        let long = grid("ncols 2 nrows 1 xllcenter 0 yllcenter 5 dx 2 dy 3\n-9999 1");
        assert!(long.grid.values[0].is_nan(), "ESRI's own value for no data");
        let unit = LinearUnit { name: None, said: false };
        assert_eq!(long.spacing, FileSpacing::Known(Spacing { dx: 2.0, dy: 3.0 }, unit));
    }

    proptest! {
        #[test]
        fn values_and_places_of_any_shape_are_read(
            (cols, values) in (1..9usize, 1..9usize).prop_flat_map(|(rows, cols)| {
                (Just(cols), prop::collection::vec(-8000..8000i32, rows * cols))
            }),
            corner in prop::array::uniform2(1e3..1e6f64),
            cell in prop::array::uniform2(1.0..100.0f64),
            separators in prop::collection::vec(prop::sample::select(vec![" ", "\n", "\r\n", "\t "]), 64),
            no_data in -10..10i32,
        ) {
            let rows = values.len() / cols;
            let ([x, y], [dx, dy]) = (corner, cell);
            let mut text = format!(
                "NROWS {rows}\nNCOLS {cols}\nyllcenter {y}\nxllcorner {x}\ndx {dx}\ndy {dy}\n\
                 nodata_value {}\n",
                0.125 * f64::from(no_data)
            );
            for (value, separator) in values.iter().zip(separators.iter().cycle()) {
                text += &format!("{}{separator}", 0.125 * f64::from(*value));
            }
            let read = grid(&text);
            prop_assert_eq!((read.grid.rows, read.grid.cols), (rows, cols));
            for (found, value) in read.grid.values.iter().zip(&values) {
                let expected = 0.125 * f64::from(*value);
                let is_right = if *value == no_data { found.is_nan() } else { *found == expected };
                prop_assert!(is_right, "{} for {}", found, expected);
            }
            let last = read.georeference.unwrap().coordinates([(rows - 1) as f64, 0.0]);
            prop_assert!((last[0] - x - 0.5 * dx).abs() < 1e-6 && (last[1] - y).abs() < 1e-6);
        }
    }

    #[test]
    fn errors_name_the_fault() {
        for (text, part) in [
            ("".into(), "nrows"),
            ("ncols 3\n".into(), "nrows"),
            (format!("{HEADER}1 2 3 4 5"), "5 values"),
            (format!("{HEADER}1 2 3 4 5 6 7"), "more values"),
            (format!("{HEADER}1 2 3 4 x 6"), "row 1, column 1"),
            (format!("{HEADER}zfactor 2\n1 2 3 4 5 6"), "zfactor"),
            (format!("{HEADER}dx 2\n1 2 3 4 5 6"), "either cellsize"),
            (format!("{HEADER}ncols 2\n1 2 3 4 5 6"), "twice"),
            ("ncols 3 nrows 2 cellsize -1 1 2 3 4 5 6".into(), "no size"),
            ("ncols 99999 nrows 99999 cellsize 1 1 2".into(), "too large"),
            ("ncols 9999 nrows 9999 cellsize 1 1 2".into(), "cut short"),
        ] {
            let error = decode(text.as_bytes(), None).err().unwrap();
            assert!(error.contains(part), "{text}: {error}");
        }
        let nowhere = grid("ncols 2 nrows 1 cellsize 1 3 4").georeference.unwrap_err();
        assert!(nowhere.contains("xllcorner"), "{nowhere}");
    }

    #[test]
    fn degrees_are_no_lengths() {
        let degrees = "ncols 2 nrows 1 xllcorner 8.5 yllcorner 47 cellsize 0.01 1 2";
        let metres = r#"PROJCS["UTM",GEOGCS["WGS",UNIT["Degree",0.017]],UNIT["Meter",1.0]]"#;
        let feet = r#"PROJCS["NY",GEOGCS["N",UNIT["Degree",0.017]],UNIT["Foot_US",0.3048006096]]"#;
        let geographic = r#"GEOGCS["WGS",DATUM["D"],UNIT["Degree",0.017]]"#;
        let spacing = |projection| decode(degrees.as_bytes(), projection).unwrap().spacing;
        for projection in [None, Some(geographic)] {
            assert!(matches!(spacing(projection), FileSpacing::Degrees(_)), "{projection:?}");
        }
        let FileSpacing::Unusable(why) = spacing(Some(feet)) else { panic!("feet") };
        assert!(why.contains("metres"), "{why}");
        let unit = LinearUnit { name: Some("m"), said: true };
        assert_eq!(spacing(Some(metres)), FileSpacing::Known(Spacing::square(0.01), unit));
    }
}
