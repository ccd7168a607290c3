//! Grids of latitudes and longitudes on the Earth, as closed surfaces.

use glam::DVec3;

use super::completed::completed;
use super::{Chart, CompletedGrid, GluingError, GridSide, Seam, Surface, SurfaceError};

/// The figure of the Earth or of another body: an ellipsoid with two equal axes in the plane of the equator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Radius of the equator, in metres.
    pub equator: f64,
    /// Flattening: 0 for a sphere.
    pub flattening: f64,
}

impl Ellipsoid {
    /// The ellipsoid of WGS 84, the system of GPS.
    pub const WGS_84: Self = Self { equator: 6_378_137.0, flattening: 1.0 / 298.257_223_563 };

    /// Returns the ellipsoid with this radius of the equator in metres and this inverse flattening, which is 0 for a
    /// sphere. Returns `None` if they are those of no ellipsoid.
    pub fn new(equator: f64, inverse_flattening: f64) -> Option<Self> {
        let flattening = if inverse_flattening == 0.0 { 0.0 } else { inverse_flattening.recip() };
        let is_usable = equator.is_finite() && equator > 0.0 && (0.0..1.0).contains(&flattening);
        is_usable.then_some(Self { equator, flattening })
    }

    /// Returns a point given by longitude and latitude in degrees and height in metres, relative to the middle.
    fn position(self, [longitude, latitude]: [f64; 2], height: f64) -> DVec3 {
        let (east_sin, east_cos) = longitude.to_radians().sin_cos();
        let (sin, cos) = match latitude.abs() == POLE {
            true => (latitude.signum(), 0.0),
            false => latitude.to_radians().sin_cos(),
        };
        let squared = self.flattening * (2.0 - self.flattening);
        let across = self.equator / (1.0 - squared * sin * sin).sqrt();
        let out = (across + height) * cos;
        DVec3::new(out * east_cos, out * east_sin, (across * (1.0 - squared) + height) * sin)
    }
}

/// Maximum gap that a single added line closes, in steps between lines: between the outermost row and a pole, or
/// between the last column and the first one.
const LARGEST_GAP: f64 = 1.5;
/// Largest distance of two lines that count as one, as a part of a step.
const SAME_LINE: f64 = 1e-3;
/// A turn round the Earth, and the latitude of a pole, in degrees.
const TURN: f64 = 360.0;
const POLE: f64 = 90.0;

/// The reason why latitudes and longitudes are no grid on the Earth.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeodeticError {
    /// A latitude lies beyond a pole, or is not a number.
    #[error("the latitude of row {row} is {degrees}; latitudes lie between -90 and 90 degrees")]
    Latitude {
        /// Number of the row.
        row: usize,
        /// Latitude of the row.
        degrees: f64,
    },
    /// Lines do not follow each other in one direction.
    #[error(
        "{what} {number} is {degrees} degrees, and the line before is {before}; latitudes and longitudes must \
         ascend or descend all along, by less than half a turn a line"
    )]
    Order {
        /// Kind of the line.
        what: &'static str,
        /// Number of the line.
        number: usize,
        /// Latitude or longitude of the line.
        degrees: f64,
        /// The value at the line before.
        before: f64,
    },
    /// The columns go round the Earth more than once.
    #[error("the columns span {degrees} degrees; give at most a full turn of 360")]
    Span {
        /// Difference of the last longitude and the first one.
        degrees: f64,
    },
    /// The grid has too few lines to determine its ends.
    #[error(
        "a grid of {rows} x {cols} points on the Earth is too small; give at least four of each"
    )]
    TooSmall {
        /// Number of latitudes.
        rows: usize,
        /// Number of longitudes.
        cols: usize,
    },
}

/// A grid of latitudes (rows) and longitudes (columns) on an ellipsoid, by default that of WGS 84. Its surface is closed
/// where the grid goes round the Earth: across the line between its last and its first column, and at the poles.
///
/// Latitudes ascend or descend. Longitudes ascend or descend from any meridian, up to a full turn: 0 to 360 degrees and
/// -180 to 180 degrees are both accepted, and jumps by a full turn from one column to the next are ignored. Lines may
/// be unevenly spaced. Where the grid ends up to one and a half steps before a pole, or before its first column, the
/// surface has one line more, as with columns from 0 to 359 degrees or with values at the middles of cells.
/// [`CompletedGrid::crop`] takes these lines away from a map.
///
/// ```
/// use geosweep::surface::GeodeticGrid;
/// use geosweep::{Options, Sources, distance_map_f64};
/// // Middles of cells of 5 degrees, from north to south.
/// let latitudes: Vec<_> = (0..36).map(|row| 87.5 - 5.0 * row as f64).collect();
/// let longitudes: Vec<_> = (0..72).map(|col| 2.5 + 5.0 * col as f64).collect();
/// let grid = GeodeticGrid::new(&latitudes, &longitudes).unwrap();
/// let surface = grid.surface(&[0.0; 36 * 72])?;
/// assert_eq!((surface.rows(), surface.cols()), (38, 73));
/// // From Quito to the north pole, a quarter of a meridian.
/// let [row, col] = grid.place([-78.5, 0.0]).unwrap();
/// let map = distance_map_f64(&surface, &Sources::point(row, col), &Options::default())?;
/// assert!((map.distance(0, 0) - 10_001_966.0).abs() < 1e4);
/// assert_eq!(grid.lines().crop(&map.distances).len(), 36 * 72);
/// # Ok::<(), geosweep::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GeodeticGrid {
    /// Latitudes of the surface's rows, in degrees, with the rows that are added.
    latitudes: Vec<f64>,
    /// Longitudes of the surface's columns, in degrees, with the column that is added. They have no jumps.
    longitudes: Vec<f64>,
    lines: CompletedGrid,
    goes_round: bool,
    ellipsoid: Ellipsoid,
}

impl GeodeticGrid {
    /// Makes a grid of latitudes and longitudes in degrees, with one latitude for each row and one longitude for each
    /// column.
    ///
    /// # Errors
    /// If a latitude lies beyond a pole, lines do not ascend or descend, the columns span more than a full turn, or
    /// there are fewer than four rows or columns.
    pub fn new(latitudes: &[f64], longitudes: &[f64]) -> Result<Self, GeodeticError> {
        let (rows, cols) = (latitudes.len(), longitudes.len());
        if rows.min(cols) < 4 {
            return Err(GeodeticError::TooSmall { rows, cols });
        }
        let is_beyond = |degrees: f64| degrees.is_nan() || degrees.abs() > POLE * (1.0 + 1e-9);
        if let Some(row) = latitudes.iter().position(|&degrees| is_beyond(degrees)) {
            return Err(GeodeticError::Latitude { row, degrees: latitudes[row] });
        }
        let mut longitudes = without_jumps(longitudes);
        in_order("latitude", latitudes)?;
        in_order("longitude", &longitudes)?;
        let span = longitudes[cols - 1] - longitudes[0];
        let (gap, step) = (TURN - span.abs(), span.abs() / (cols - 1) as f64);
        if gap < -SAME_LINE * step {
            return Err(GeodeticError::Span { degrees: span.abs() });
        }
        let is_repeated = gap <= SAME_LINE * step;
        let has_column_added = !is_repeated && gap <= LARGEST_GAP * step;
        if has_column_added {
            longitudes.push(longitudes[0] + TURN.copysign(span));
        }
        let ends = [[0, 1], [rows - 1, rows - 2]];
        let ends = ends.map(|[last, before]| End::of(latitudes[before], latitudes[last]));
        let mut given = latitudes.to_vec();
        (given[0], given[rows - 1]) = (ends[0].latitude, ends[1].latitude);
        let goes_round = is_repeated || has_column_added;
        let beyond = gap / (longitudes[cols - 1] - longitudes[cols - 2]).abs();
        let lines = lines_of(Chart { rows, cols }, ends, is_repeated, has_column_added, beyond);
        let lines = lines.map_err(|_| GeodeticError::TooSmall { rows, cols })?;
        let latitudes = ends[0].added.into_iter().chain(given).chain(ends[1].added).collect();
        Ok(Self { latitudes, longitudes, lines, goes_round, ellipsoid: Ellipsoid::WGS_84 })
    }

    /// Sets the ellipsoid on which the latitudes and longitudes are measured.
    pub fn with_ellipsoid(self, ellipsoid: Ellipsoid) -> Self {
        Self { ellipsoid, ..self }
    }

    /// Makes the surface, in metres from the middle of the Earth. `heights` are the heights of the given points above
    /// the ellipsoid, in metres, row-major; NaN marks holes. Heights above sea level differ from these by up to 107 m,
    /// which changes distances by at most a 60,000th. The height of a pole is the mean height of its row, or of the row
    /// beside it if the pole is added.
    ///
    /// # Errors
    /// If the number of heights is not the number of given points, a height is infinite, or the points make no surface.
    pub fn surface(&self, heights: &[f64]) -> Result<Surface, SurfaceError> {
        let Chart { rows, cols } = self.lines.given();
        if heights.len() != rows * cols {
            return Err(SurfaceError::Shape { what: "heights", found: heights.len(), rows, cols });
        }
        // Infinite heights are found before the grid is extended. Afterwards rows and columns have other numbers, and
        // the mean at a pole may hide such a height.
        if let Some(index) = heights.iter().position(|height| height.is_infinite()) {
            let (row, col) = (index / cols, index % cols);
            return Err(SurfaceError::Infinite { what: "heights", row, col });
        }
        let heights = self.lines.extend(heights);
        let places = self.latitudes.iter().flat_map(|&latitude| {
            self.longitudes.iter().map(move |&longitude| [longitude, latitude])
        });
        let points = places.zip(heights);
        let points = points.map(|(place, height)| self.ellipsoid.position(place, height)).collect();
        let (rows, cols) = (self.latitudes.len(), self.longitudes.len());
        let surface = Surface::from_positions(rows, cols, points)?;
        match self.goes_round {
            true => surface.with_gluing(self.lines.gluing().clone()),
            false => Ok(surface),
        }
    }

    /// Returns the completed grid, with the added lines: a row at a pole, and a column where the grid goes round. It
    /// converts values and positions between the given grid and the surface's. The value at a pole is a mean
    /// ([`CompletedGrid::extend`]).
    pub fn lines(&self) -> &CompletedGrid {
        &self.lines
    }

    /// Returns whether the columns go round the Earth, so that the surface is closed.
    pub fn goes_round(&self) -> bool {
        self.goes_round
    }

    /// Returns the row and column, which may be fractional, of a place on the surface's grid, given by longitude and
    /// latitude in degrees. The result is `None` if the place lies outside the grid.
    pub fn place(&self, [longitude, latitude]: [f64; 2]) -> Option<[f64; 2]> {
        let (first, last) = (self.longitudes[0], self.longitudes[self.longitudes.len() - 1]);
        let turns = ((longitude - first.min(last)) / TURN).floor();
        let col = between(&self.longitudes, longitude - turns * TURN)?;
        Some([between(&self.latitudes, latitude)?, col])
    }
}

/// An end of the rows of a grid.
#[derive(Clone, Copy)]
struct End {
    /// Latitude of the outermost row. It is exactly the latitude of the pole if the row lies there up to rounding.
    latitude: f64,
    /// Latitude of the row that is added beyond the outermost one.
    added: Option<f64>,
    /// Distance of the pole from the outermost row, in steps between rows.
    gap: f64,
}

impl End {
    /// Returns the end of the rows whose outermost latitude is `last` and whose next latitude inwards is `before`.
    fn of(before: f64, last: f64) -> Self {
        let pole = POLE.copysign(last - before);
        let (gap, step) = ((pole - last).abs(), (last - before).abs());
        if gap <= SAME_LINE * step {
            return Self { latitude: pole, added: None, gap: 0.0 };
        }
        let added = (gap <= LARGEST_GAP * step).then_some(pole);
        Self { latitude: last, added, gap: gap / step }
    }

    /// Returns the seam of the first or the last row, if there is a pole.
    fn seam(self, side: GridSide) -> Option<Seam> {
        match (self.added, self.latitude.abs() == POLE) {
            (Some(_), _) => Some(Seam::Ring(side)),
            (None, true) => Some(Seam::Pole { side, exact: true }),
            (None, false) => None,
        }
    }
}

/// Returns the lines of a grid between two ends. `step` is the distance of an added column from the last one, in steps
/// between columns.
fn lines_of(
    chart: Chart,
    ends: [End; 2],
    is_repeated: bool,
    has_column_added: bool,
    step: f64,
) -> Result<CompletedGrid, GluingError> {
    let sides = [GridSide::FirstColumn, GridSide::LastColumn];
    let columns = match (has_column_added, is_repeated) {
        (true, _) => Some(Seam::Neighbours { sides, reversed: false }),
        (false, true) => Some(Seam::Sides { sides, reversed: false }),
        (false, false) => None,
    };
    let rows = [GridSide::FirstRow, GridSide::LastRow];
    let poles = ends.into_iter().zip(rows).filter_map(|(end, side)| end.seam(side));
    let seams: Vec<_> = columns.into_iter().chain(poles).collect();
    completed(chart, &seams, ends.map(|end| end.gap), step)
}

/// Returns longitudes without jumps by full turns.
fn without_jumps(longitudes: &[f64]) -> Vec<f64> {
    let mut before = longitudes[0];
    let next = |&longitude: &f64| {
        before = longitude + TURN * ((before - longitude) / TURN).round();
        before
    };
    longitudes.iter().map(next).collect()
}

/// Checks that lines ascend or descend, in steps of less than half a turn.
fn in_order(what: &'static str, lines: &[f64]) -> Result<(), GeodeticError> {
    let way = lines[1] - lines[0];
    let follows = |pair: &[f64]| {
        let step = (pair[1] - pair[0]) * way.signum();
        step > 0.0 && step < 0.5 * TURN
    };
    match lines.windows(2).position(|pair| !follows(pair)) {
        None => Ok(()),
        Some(index) => {
            let (before, degrees) = (lines[index], lines[index + 1]);
            Err(GeodeticError::Order { what, number: index + 1, degrees, before })
        }
    }
}

/// Returns the fractional number of the line on which a value lies, between lines in ascending or descending order.
fn between(lines: &[f64], value: f64) -> Option<f64> {
    let holds = |pair: &[f64]| (pair[0] - value) * (pair[1] - value) <= 0.0;
    let index = lines.windows(2).position(holds)?;
    Some(index as f64 + (value - lines[index]) / (lines[index + 1] - lines[index]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(count: usize, first: f64, step: f64) -> Vec<f64> {
        (0..count).map(|k| first + step * k as f64).collect()
    }

    #[test]
    fn lines_are_added_where_the_earth_has_no_sample() {
        let size = |latitudes: &[f64], longitudes: &[f64]| {
            let grid = GeodeticGrid::new(latitudes, longitudes).unwrap();
            let Chart { rows, cols } = grid.lines().given();
            assert_eq!([rows, cols], [latitudes.len(), longitudes.len()]);
            let surface = grid.surface(&vec![0.0; rows * cols]).unwrap();
            assert!(surface.seams().is_empty());
            let all: Vec<_> = (0..surface.chart().points()).collect();
            let first = grid.lines().crop(&all)[0];
            (surface.rows(), surface.cols(), first, surface.is_glued())
        };
        // Samples lie on lines, at the middles of cells, or on lines without the poles, in either order of latitudes.
        let (whole, round) = (lines(19, 90.0, -10.0), lines(37, -180.0, 10.0));
        assert_eq!(size(&whole, &round), (19, 37, 0, true));
        assert_eq!(size(&lines(19, -90.0, 10.0), &lines(36, 0.0, 10.0)), (19, 37, 0, true));
        assert_eq!(size(&lines(18, 85.0, -10.0), &lines(36, 5.0, 10.0)), (20, 37, 37, true));
        assert_eq!(size(&lines(17, -80.0, 10.0), &round), (19, 37, 37, true));
        // A cap is open at one end, and a region on all sides.
        assert_eq!(size(&lines(8, 85.0, -10.0), &round), (9, 37, 37, true));
        assert_eq!(size(&lines(8, 65.0, -10.0), &lines(20, 5.0, 10.0)), (8, 20, 0, false));
        // 170, 180, -170 and so on.
        let jumping: Vec<_> = (0..36).map(|k| f64::from((k * 10 + 180) % 360) - 180.0).collect();
        assert_eq!(size(&whole, &jumping), (19, 37, 0, true));
    }

    #[test]
    fn places_lie_between_lines() {
        let grid = GeodeticGrid::new(&lines(18, 85.0, -10.0), &lines(36, 5.0, 10.0)).unwrap();
        assert_eq!(grid.place([5.0, 85.0]), Some([1.0, 0.0]));
        assert_eq!(grid.place([-0.0, 90.0]), Some([0.0, 35.5]));
        assert_eq!(grid.place([360.0 + 20.0, 87.5]), Some([0.5, 1.5]));
        assert_eq!(grid.place([-178.0, -80.0]), Some([17.5, 17.7]));
        assert_eq!(grid.place([f64::NAN, 0.0]), None);
        let region = GeodeticGrid::new(&lines(9, 10.0, 1.0), &lines(9, 170.0, 2.0)).unwrap();
        assert_eq!(region.place([-180.0, 10.5]), Some([0.5, 5.0]));
        assert_eq!(region.place([160.0, 10.5]), None);
        assert_eq!(region.place([172.0, 30.0]), None);
    }

    #[test]
    fn given_places_are_those_of_the_surface() {
        // Poles lie half a step beyond the outermost rows, and the seam 1.12 steps beyond the last column.
        let grid = GeodeticGrid::new(&lines(18, 85.0, -10.0), &lines(36, 5.0, 9.966)).unwrap();
        let [[north, south], [west, east]] = grid.lines().margins();
        assert_eq!([north, south, west], [0.5, 0.5, 0.0]);
        assert!((east - (360.0 - 35.0 * 9.966) / 9.966).abs() < 1e-9, "{east}");
        for (given, surface) in [
            ([-0.5, 3.0], [0.0, 3.0]),
            ([-0.25, 3.5], [0.5, 3.5]),
            ([0.0, 35.0], [1.0, 35.0]),
            ([17.5, 0.0], [19.0, 0.0]),
            ([8.5, 35.0 + 0.25 * east], [9.5, 35.25]),
        ] {
            assert_eq!(grid.lines().to_completed(given), Some(surface));
            assert_eq!(grid.lines().to_given(surface), given);
        }
        // A region with a row at a pole and no line added.
        let region = GeodeticGrid::new(&lines(8, 90.0, -10.0), &lines(20, 5.0, 10.0)).unwrap();
        assert_eq!(region.lines().margins(), [[0.0; 2]; 2]);
        assert_eq!(region.lines().to_completed([0.5, 19.0]), Some([0.5, 19.0]));
        assert!(!region.lines().is_extended() && !region.goes_round());
        assert!(grid.lines().is_extended());
    }

    #[test]
    fn poles_have_the_mean_of_their_row() {
        let grid = GeodeticGrid::new(&lines(4, 67.5, -45.0), &lines(8, 0.0, 45.0)).unwrap();
        let mut values = vec![1.0; 32];
        (values[0], values[1], values[2]) = (5.0, f64::NAN, f64::INFINITY);
        let all = grid.lines().extend(&values);
        assert_eq!(all[..9], [10.0 / 6.0; 9]);
        assert_eq!((all[9], all[17], all[18]), (5.0, 5.0, 1.0));
        assert_eq!(grid.lines().crop(&all)[3..], values[3..]);
    }

    #[test]
    fn lines_off_the_earth_are_refused() {
        let refused = |latitudes: &[f64], longitudes: &[f64]| {
            GeodeticGrid::new(latitudes, longitudes).unwrap_err()
        };
        let round = lines(37, -180.0, 10.0);
        let beyond = refused(&lines(19, 95.0, -10.0), &round);
        assert_eq!(beyond, GeodeticError::Latitude { row: 0, degrees: 95.0 });
        assert!(matches!(
            refused(&[0.0, f64::NAN, 2.0, 3.0], &round),
            GeodeticError::Latitude { row: 1, .. }
        ));
        let turns = refused(&lines(9, 0.0, 1.0), &lines(60, 0.0, 10.0));
        assert_eq!(turns, GeodeticError::Span { degrees: 590.0 });
        let back = refused(&[0.0, 1.0, 0.5, 2.0], &round);
        assert!(matches!(back, GeodeticError::Order { what: "latitude", number: 2, .. }), "{back}");
        assert!(matches!(refused(&lines(3, 0.0, 1.0), &round), GeodeticError::TooSmall { .. }));
    }
}
