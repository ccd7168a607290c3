//! What accompanies a surface: masks, slowness, metrics, curves.

use std::path::Path;

use super::npy::{Dtype, NpyArray, shape_text};
use super::{IoError, checked_points, extension, png, read_bytes};
use crate::surface::{Chart, MetricTensor};

/// One value per grid point, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// `rows * cols` values.
    pub values: Vec<T>,
}

impl<T> Grid<T> {
    /// The values, if the grid has this size; otherwise says both sizes.
    pub fn fit(self, path: &Path, rows: usize, cols: usize) -> Result<Vec<T>, IoError> {
        if (self.rows, self.cols) == (rows, cols) {
            return Ok(self.values);
        }
        let (own_rows, own_cols) = (self.rows, self.cols);
        let reason = format!(
            "has {own_rows} x {own_cols} values, the surface {rows} x {cols} points; both must agree"
        );
        Err(IoError::content(path, reason))
    }

    pub(super) fn map<U>(self, f: impl FnMut(T) -> U) -> Grid<U> {
        Grid { rows: self.rows, cols: self.cols, values: self.values.into_iter().map(f).collect() }
    }
}

/// Reads a mask, true where the surface is: an `.npy` array (M, N) of bool or uint8, or a grey
/// PNG of at most 8 bits, non-zero where the surface is.
pub fn read_mask(path: &Path) -> Result<Grid<bool>, IoError> {
    let grid = match extension(path).as_str() {
        "npy" => {
            let array = read_npy(path)?;
            let Dtype { kind, bytes, .. } = array.dtype;
            if !(kind == b'b' || kind == b'u' && bytes == 1) {
                let reason = "a mask is an array of bool or uint8; use mask.astype(bool)";
                return Err(IoError::content(path, reason));
            }
            matrix(path, array, "a mask")?
        }
        "png" => {
            let reason = |reason| IoError::content(path, reason);
            let picture = png::decode(&read_bytes(path)?).map_err(reason)?;
            if picture.bits > 8 {
                return Err(reason("a mask is an 8-bit grey picture; this one has 16 bits".into()));
            }
            picture.grid
        }
        _ => return Err(IoError::extension(path, "a mask", ".npy or .png")),
    };
    Ok(grid.map(|value| value != 0.0))
}

/// Reads a slowness (reciprocal speed): an `.npy` array (M, N).
pub fn read_slowness(path: &Path) -> Result<Grid<f64>, IoError> {
    match extension(path).as_str() {
        "npy" => matrix(path, read_npy(path)?, "a slowness"),
        _ => Err(IoError::extension(path, "a slowness", ".npy")),
    }
}

/// Reads a metric: an `.npy` array (M, N, 2, 2) of symmetric matrices in index coordinates,
/// axis 0 being the row. A step of `dr` rows and `dc` columns has squared length
/// `g[0,0] dr^2 + (g[0,1] + g[1,0]) dr dc + g[1,1] dc^2`. NaN marks holes.
pub fn read_metric(path: &Path) -> Result<Grid<MetricTensor>, IoError> {
    if extension(path) != "npy" {
        return Err(IoError::extension(path, "a metric", ".npy"));
    }
    let array = read_npy(path)?;
    match *array.shape {
        [_, _, 2, 2] => metric(array).map_err(|reason| IoError::content(path, reason)),
        _ => Err(wrong_shape(path, &array, "a metric has shape (M, N, 2, 2)")),
    }
}

/// Reads curves, each as rows and columns of its vertices: an `.npy` array (K, 2) of one curve, or
/// (K, 5) as the tool writes, with row and column first and a row of NaN between curves; or a text
/// file (any other extension) with `row,col` on each line. There blanks, `;` or tabs may stand for
/// the comma, `#` begins a comment, and a first line may name the columns: those called `row` and
/// `col` count, in any order and among others; a new value in one called `curve` begins another curve,
/// which returns to its first vertex where one called `closed` holds 1.
///
/// # Errors
/// If the file cannot be read, is not of that form, or holds no vertex.
pub fn read_curves(path: &Path) -> Result<Vec<Vec<[f64; 2]>>, IoError> {
    let curves = if extension(path) == "npy" {
        let array = read_npy(path)?;
        match array.shape[..] {
            [_, 2] => vec![array.values.as_chunks().0.to_vec()],
            [_, 5] => {
                let rows = array.values.as_chunks::<5>().0;
                let curves = rows.split(|row| row.iter().all(|value| value.is_nan()));
                curves.map(|curve| curve.iter().map(|row| [row[0], row[1]]).collect()).collect()
            }
            _ => {
                let shapes = "curves have shape (K, 2): row, column, or (K, 5) as the tool writes";
                return Err(wrong_shape(path, &array, shapes));
            }
        }
    } else {
        read_curves_text(path)?
    };
    let curves: Vec<Vec<_>> = curves.into_iter().filter(|curve| !curve.is_empty()).collect();
    if curves.is_empty() {
        return Err(IoError::content(path, "holds no vertex; give at least one row,col"));
    }
    Ok(curves)
}

/// Reads grid points, as row-major indices of a grid: an `.npy` array (K,) of such indices or
/// (K, 2) of rows and columns, with more columns after these or not, or a text file as for
/// [`read_curves`]. All are whole numbers.
pub fn read_points(path: &Path, chart: Chart) -> Result<Vec<usize>, IoError> {
    let Chart { rows, cols } = chart;
    let content = |reason: String| IoError::content(path, reason);
    let whole = |value: f64, end: usize, what: &str| {
        let fits = value.fract() == 0.0 && (0.0..end as f64).contains(&value);
        fits.then_some(value as usize).ok_or_else(|| {
            content(format!("{what} {value} is none of the grid's, which are 0 to {}", end - 1))
        })
    };
    let place = |[row, col]: [f64; 2]| {
        Ok(chart.index(whole(row, rows, "row")?, whole(col, cols, "column")?))
    };
    let points: Result<Vec<_>, _> = if extension(path) == "npy" {
        let array = read_npy(path)?;
        match array.shape[..] {
            [_] => array.values.iter().map(|&v| whole(v, chart.points(), "point")).collect(),
            [_, width] if width >= 2 => {
                let rows = array.values.chunks_exact(width);
                rows.map(|values| place([values[0], values[1]])).collect()
            }
            _ => {
                let shapes = "grid points have shape (K,), or (K, 2) and more: row, column, ...";
                return Err(wrong_shape(path, &array, shapes));
            }
        }
    } else {
        read_curves_text(path)?.into_iter().flatten().map(place).collect()
    };
    let points = points?;
    if points.is_empty() {
        return Err(content("holds no point; give at least one".into()));
    }
    Ok(points)
}

fn read_curves_text(path: &Path) -> Result<Vec<Vec<[f64; 2]>>, IoError> {
    let bytes = read_bytes(path)?;
    let text = std::str::from_utf8(&bytes)
        .map_err(|_| IoError::content(path, "is no text; give lines of row,col or an .npy"))?;
    curves_text(text).map_err(|reason| IoError::content(path, reason))
}

fn curves_text(text: &str) -> Result<Vec<Vec<[f64; 2]>>, String> {
    let mut vertices = Vec::new();
    let (mut first, mut header) = (true, None);
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        // Blanks at the ends may be empty fields between tabs.
        let content = line.split('#').next().unwrap_or_default();
        if content.trim().is_empty() {
            continue;
        }
        let fields = loose_fields(content);
        if first && fields.iter().all(|field| field.parse::<f64>().is_err()) {
            header = Some(Header::new(content)?);
        } else {
            let vertex = match &header {
                None => two(&fields).map(|place| Vertex { place, curve: None, closed: false }),
                Some(header) => header.read(content),
            };
            vertices.push(vertex.ok_or_else(|| {
                let (number, line) = (index + 1, line.trim());
                let form = header.as_ref().map_or("row,col", |header| header.line.trim());
                format!("line {number}: `{line}` is not of the form {form}")
            })?);
        }
        first = false;
    }
    let curve = |vertices: &[Vertex]| {
        let closed = vertices.first().filter(|first| first.closed);
        vertices.iter().chain(closed).map(|vertex| vertex.place).collect()
    };
    Ok(vertices.chunk_by(|a, b| a.curve == b.curve).map(curve).collect())
}

/// A line of a table of curves.
struct Vertex<'a> {
    place: [f64; 2],
    /// What its curve is called.
    curve: Option<&'a str>,
    /// Whether that goes on to its first vertex after the last.
    closed: bool,
}

/// What lies between commas, `;` and blanks.
fn loose_fields(line: &str) -> Vec<&str> {
    let fields = line.split(|c: char| c.is_whitespace() || c == ',' || c == ';');
    fields.filter(|field| !field.is_empty()).collect()
}

/// Two numbers.
fn two(fields: &[&str]) -> Option<[f64; 2]> {
    let [first, second] = fields else { return None };
    Some([first.parse().ok()?, second.parse().ok()?])
}

/// A line of column names.
struct Header<'a> {
    line: &'a str,
    /// What divides fields, of which some may be empty; anything where there are but two.
    separator: Option<char>,
    columns: usize,
    row: usize,
    col: usize,
    curve: Option<usize>,
    closed: Option<usize>,
}

impl<'a> Header<'a> {
    fn new(line: &'a str) -> Result<Self, String> {
        let two = loose_fields(line).len() == 2;
        let separator = [',', ';', '\t'].into_iter().find(|c| !two && line.contains(*c));
        let names = fields(line, separator);
        let find = |wanted: &str| names.iter().position(|name| name.eq_ignore_ascii_case(wanted));
        let Some((row, col)) = find("row").zip(find("col")) else {
            return Err(format!(
                "the header `{}` names no columns row and col, counted from 0 at the upper left \
                 point; name them so, or leave the header out and give lines of row,col",
                line.trim()
            ));
        };
        let (curve, closed) = (find("curve"), find("closed"));
        Ok(Self { line, separator, columns: names.len(), row, col, curve, closed })
    }

    fn read<'b>(&self, line: &'b str) -> Option<Vertex<'b>> {
        let fields = fields(line, self.separator);
        if fields.len() != self.columns {
            return None;
        }
        Some(Vertex {
            place: two(&[fields[self.row], fields[self.col]])?,
            curve: self.curve.map(|curve| fields[curve]),
            closed: self.closed.is_some_and(|closed| fields[closed] == "1"),
        })
    }
}

fn fields(line: &str, separator: Option<char>) -> Vec<&str> {
    match separator {
        Some(separator) => line.split(separator).map(str::trim).collect(),
        None => loose_fields(line),
    }
}

pub(super) fn read_npy(path: &Path) -> Result<NpyArray, IoError> {
    NpyArray::decode(&read_bytes(path)?).map_err(|reason| IoError::content(path, reason))
}

pub(super) fn wrong_shape(path: &Path, array: &NpyArray, expected: &str) -> IoError {
    let shape = shape_text(&array.shape);
    IoError::content(path, format!("is an array of shape {shape}; {expected}"))
}

/// An array (M, N) as a grid.
pub(super) fn matrix(path: &Path, array: NpyArray, what: &str) -> Result<Grid<f64>, IoError> {
    let [rows, cols] = *array.shape else {
        return Err(wrong_shape(path, &array, &format!("{what} has shape (M, N)")));
    };
    checked_points(rows, cols).map_err(|reason| IoError::content(path, reason))?;
    Ok(Grid { rows, cols, values: array.values })
}

/// An array (M, N, 2, 2) as a metric.
pub(super) fn metric(array: NpyArray) -> Result<Grid<MetricTensor>, String> {
    let (rows, cols) = (array.shape[0], array.shape[1]);
    checked_points(rows, cols)?;
    let tensor = |(index, &[rr, rc, cr, cc]): (usize, &[f64; 4])| {
        // Rounding in single precision may leave a little asymmetry.
        if (rc - cr).abs() > 1e-5 * (rr.abs() + cc.abs()) {
            let (row, col) = Chart { rows, cols }.position(index);
            return Err(format!(
                "the metric at row {row}, column {col} is not symmetric: its mixed entries are {rc} and {cr}"
            ));
        }
        Ok(MetricTensor { rr, rc: 0.5 * (rc + cr), cc })
    };
    let values =
        array.values.as_chunks().0.iter().enumerate().map(tensor).collect::<Result<_, _>>()?;
    Ok(Grid { rows, cols, values })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_leniently_and_errors_name_the_line() {
        let expected = vec![vec![[1.0, 2.5], [3.0, -4.0]]];
        for text in ["1,2.5\n3,-4\n", "row;col\n1; 2.5\n\n3;-4", "# curve\r\n1 2.5 # a\r\n3\t-4"] {
            assert_eq!(curves_text(text), Ok(expected.clone()), "{text:?}");
        }
        for (text, line) in [
            ("1,2\n3\n", "line 2"),
            ("1,2\nx,y", "line 2"),
            ("1,2,3", "line 1"),
            ("row,col,x\n1,2\n", "line 2"),
            ("row,col\n1,2\nrow,col\n", "line 3"),
        ] {
            assert!(curves_text(text).unwrap_err().contains(line), "{text:?}");
        }
    }

    #[test]
    fn headers_say_which_columns_count() {
        let expected = vec![vec![[1.0, 2.5], [3.0, -4.0]]];
        for text in [
            "col,row\n2.5,1\n-4,3\n",
            "COL Row\n2.5 1\n-4 3",
            "name,row,col,x\na,1,2.5,\n\n,3,-4,7",
            "x\ty\tcol\trow\n\t\t2.5\t1\n8\t9\t-4\t3",
        ] {
            assert_eq!(curves_text(text), Ok(expected.clone()), "{text:?}");
        }
        let divided = vec![vec![[1.0, 2.0], [3.0, 4.0]], vec![[5.0, 6.0]]];
        assert_eq!(curves_text("curve,row,col\n0,1,2\n0,3,4\n1,5,6"), Ok(divided));
        let closed = vec![vec![[1.0, 2.0], [3.0, 4.0], [1.0, 2.0]]];
        assert_eq!(curves_text("closed,row,col\n1,1,2\n1,3,4"), Ok(closed));
        for header in ["x,y", "lat;lon", "row,x", "row"] {
            let error = curves_text(&format!("{header}\n1,2\n")).unwrap_err();
            assert!(error.contains(header) && error.contains("row and col"), "{error}");
        }
    }
}
