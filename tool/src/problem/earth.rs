//! Converts between the grid of a file and the surface on the Earth made of it, which may have a row more at each
//! pole and a column more where the grid goes round.

use geosweep::Surface;
use geosweep::geometry::PathError;
use geosweep::io::Georeference;
use geosweep::shown::exact;
use geosweep::surface::{Chart, GeodeticGrid, SourceError};

/// A grid of a file on the Earth. Its places are *given*, those of the surface's grid are not.
pub struct Earth {
    pub grid: GeodeticGrid,
    /// The size of the given grid.
    pub chart: Chart,
}

impl Earth {
    /// Makes the grid of points at these longitudes and latitudes.
    pub fn new(georeference: &Georeference, chart: Chart) -> Result<Self, String> {
        let at = |row: usize, col: usize| georeference.coordinates([row as f64, col as f64]);
        let latitudes: Vec<_> = (0..chart.rows).map(|row| at(row, 0)[1]).collect();
        let longitudes: Vec<_> = (0..chart.cols).map(|col| at(0, col)[0]).collect();
        let grid = GeodeticGrid::new(&latitudes, &longitudes).map_err(|error| error.to_string())?;
        Ok(Self { grid, chart })
    }

    /// Returns the place on the surface's grid.
    pub fn place(&self, [row, col]: [f64; 2]) -> Result<[f64; 2], String> {
        let [last_row, last_col] = self.last();
        let [of_rows, of_cols] = self.grid.margins();
        let is_within = |at: f64, last: usize, [before, after]: [f64; 2]| {
            (-before..=last as f64 + after).contains(&at)
        };
        if is_within(row, last_row, of_rows) && is_within(col, last_col, of_cols) {
            return Ok(self.grid.to_surface([row, col]));
        }
        Err(format!(
            "{},{} lies outside the grid: rows run from 0 to {last_row}, columns from 0 to {last_col}",
            exact(row),
            exact(col)
        ))
    }

    /// Returns the places of a curve on the surface's grid. A vertex on the line where the grid begins and ends is
    /// taken on the side of its neighbour.
    pub fn curve(&self, vertices: &[[f64; 2]]) -> Result<Vec<[f64; 2]>, String> {
        let mut vertices = vertices.to_vec();
        if self.grid.goes_round() {
            let turn = self.last()[1] as f64 + self.grid.margins()[1][1];
            let is_far = |from: f64, to: f64| (from - to).abs() > 0.5 * turn;
            for index in 0..vertices.len() {
                let beside = index.checked_sub(1).unwrap_or(1).min(vertices.len() - 1);
                let (col, near) = (vertices[index][1], vertices[beside][1]);
                if (col == 0.0 || col == turn) && is_far(col, near) {
                    vertices[index][1] = turn - col;
                }
            }
            let is_leap = |ends: &&[[f64; 2]]| is_far(ends[0][1], ends[1][1]);
            if let Some(ends) = vertices.windows(2).find(is_leap) {
                return Err(format!(
                    "a curve leads from column {} to column {}, over more than half a turn; divide it \
                     where the grid begins and ends, or give it more vertices",
                    exact(ends[0][1]),
                    exact(ends[1][1])
                ));
            }
        }
        vertices.into_iter().map(|vertex| self.place(vertex)).collect()
    }

    /// Returns a mask of all points of the surface. A pole is present if a point of its row is.
    pub fn extend_mask(&self, mask: &[bool]) -> Vec<bool> {
        let values: Vec<_> = mask.iter().map(|&keep| if keep { 1.0 } else { f64::NAN }).collect();
        self.grid.extend(&values).into_iter().map(|value| !value.is_nan()).collect()
    }

    /// Returns the number of given points of the surface that are no holes.
    pub fn points(&self, surface: &Surface) -> usize {
        self.grid.crop(surface.present()).into_iter().filter(|&present| present).count()
    }

    /// Lets an error on sources name given places.
    pub fn of_sources(&self, mut error: SourceError) -> SourceError {
        match &mut error {
            SourceError::Outside { row, col, .. }
            | SourceError::Hole { row, col }
            | SourceError::Curvature { row, col, .. }
            | SourceError::Initial { row, col, .. } => self.give(row, col),
            _ => {}
        }
        error
    }

    /// Lets an error on paths name given places.
    pub fn of_paths(&self, mut error: PathError) -> PathError {
        match &mut error {
            PathError::Source(_) => {}
            PathError::Hole { row, col } | PathError::Unreachable { row, col } => {
                self.give(row, col)
            }
            PathError::Lost { row, col, lost_row, lost_col } => {
                self.give(row, col);
                self.give(lost_row, lost_col);
            }
            _ => {}
        }
        match error {
            PathError::Source(error) => PathError::Source(self.of_sources(error)),
            other => other,
        }
    }

    /// Returns the last given row and column.
    fn last(&self) -> [usize; 2] {
        [self.chart.rows - 1, self.chart.cols - 1]
    }

    fn give(&self, row: &mut f64, col: &mut f64) {
        [*row, *col] = self.grid.to_given([*row, *col]);
    }
}
