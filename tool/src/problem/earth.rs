//! Converts between the grid of a file and the surface on the Earth made of it, which may have a row more at each
//! pole and a column more where the grid goes round.

use geosweep::Surface;
use geosweep::geometry::{Curve, PathError};
use geosweep::io::{Georeference, GridFrame};
use geosweep::shown::exact;
use geosweep::surface::{Chart, GeodeticGrid, SourceError, SurfaceError};

/// The grid of a file on the Earth. Its rows, columns and points are called *given*, in contrast to those of the
/// surface's grid.
pub struct Earth {
    pub grid: GeodeticGrid,
    /// The size of the given grid.
    pub chart: Chart,
    /// The given grid in longitudes and latitudes, up to the ends of the surface.
    pub frame: GridFrame,
    /// Whether each given point is present.
    present: Vec<bool>,
}

/// Largest distance in columns at which a vertex counts as lying on the line where the grid begins and ends.
const ON_SEAM: f64 = 1e-6;

impl Earth {
    /// Makes the grid of points at these longitudes and latitudes. NaN marks holes.
    pub fn new(georeference: &Georeference, chart: Chart, heights: &[f64]) -> Result<Self, String> {
        let at = |row: usize, col: usize| georeference.coordinates([row as f64, col as f64]);
        let latitudes: Vec<_> = (0..chart.rows).map(|row| at(row, 0)[1]).collect();
        let longitudes: Vec<_> = (0..chart.cols).map(|col| at(0, col)[0]).collect();
        let grid = GeodeticGrid::new(&latitudes, &longitudes).map_err(|error| error.to_string())?;
        let frame = GridFrame::new(chart, Ok(*georeference)).with_margins(grid.margins());
        let present = heights.iter().map(|height| !height.is_nan()).collect();
        Ok(Self { grid, chart, frame, present })
    }

    /// Returns the place on the surface's grid.
    pub fn place(&self, place: [f64; 2]) -> Result<[f64; 2], String> {
        let within = self.frame.within(place).map(|place| self.grid.to_surface(place));
        within.ok_or_else(|| {
            let ([row, col], [last_row, last_col]) = (place.map(exact), self.last());
            format!(
                "{row},{col} lies outside the grid: rows run from 0 to {last_row}, columns from 0 to {last_col}"
            )
        })
    }

    /// Returns the vertices of a curve on the surface's grid, which jumps where it passes a pole or the line where the
    /// grid begins and ends. A vertex on that line is taken on the side of its neighbours.
    pub fn curve(&self, given: &[[f64; 2]], surface: &Surface) -> Result<Vec<[f64; 2]>, String> {
        let given = if self.grid.goes_round() { self.on_sides(given) } else { given.to_vec() };
        let vertices =
            given.into_iter().map(|place| self.place(place)).collect::<Result<_, _>>()?;
        let curve = Curve { vertices, closed: false };
        let half = 0.5 * (surface.cols() - 1) as f64;
        let is_leap = |ends: &&[[f64; 2]]| (ends[0][1] - ends[1][1]).abs() > half;
        let parts = curve.parts(surface);
        let leap = parts.iter().find_map(|part| part.vertices.windows(2).find(is_leap));
        match leap.filter(|_| self.grid.goes_round()) {
            None => Ok(curve.vertices),
            Some(ends) => Err(format!(
                "a curve leads from column {} to column {}, over more than half a turn; divide it \
                 where the grid begins and ends, or give it a vertex there",
                exact(self.grid.to_given(ends[0])[1]),
                exact(self.grid.to_given(ends[1])[1])
            )),
        }
    }

    /// Moves each vertex on the seam to the side of the nearest vertex off the seam: of the one before, or else of
    /// the one after. Where the curve crosses the seam, the vertex is repeated on the other side.
    fn on_sides(&self, given: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let end = self.last()[1] as f64 + self.grid.margins()[1][1];
        let is_on =
            |vertex: &[f64; 2]| vertex[1].abs() <= ON_SEAM || (vertex[1] - end).abs() <= ON_SEAM;
        let side = |vertex: &[f64; 2]| if vertex[1] > 0.5 * end { end } else { 0.0 };
        let (mut placed, mut before, mut next) = (Vec::new(), None, 0);
        for run in given.chunk_by(|a, b| is_on(a) == is_on(b)) {
            next += run.len();
            if !is_on(&run[0]) {
                placed.extend_from_slice(run);
                before = run.last().map(side);
                continue;
            }
            let after = given.get(next).map(side);
            let near = before.or(after).unwrap_or_else(|| side(&run[0]));
            placed.extend(run.iter().map(|&[row, _]| [row, near]));
            if let Some(far) = after.filter(|&far| far != near) {
                placed.push([run[run.len() - 1][0], far]);
            }
        }
        placed
    }

    /// Makes holes of given points, and returns a mask of all points of the surface. A pole is present if a point of
    /// its row is.
    pub fn mask(&mut self, mask: &[bool]) -> Vec<bool> {
        self.present.iter_mut().zip(mask).for_each(|(present, &keep)| *present &= keep);
        let values = self.without_holes(&vec![1.0; mask.len()]);
        self.grid.extend(&values).into_iter().map(|value| !value.is_nan()).collect()
    }

    /// Returns the slowness of all points of the surface. A pole has the mean of its row, so that values are checked
    /// before.
    pub fn slowness(&self, given: &[f64]) -> Result<Vec<f64>, SurfaceError> {
        let given = self.without_holes(given);
        match given.iter().position(|&value| value < 0.0) {
            None => Ok(self.grid.extend(&given)),
            Some(index) => {
                let ((row, col), value) = (self.chart.position(index), given[index]);
                Err(SurfaceError::Slowness { value, row, col })
            }
        }
    }

    /// Returns values at the given points, with NaN at holes.
    fn without_holes(&self, values: &[f64]) -> Vec<f64> {
        let value = |(&value, &present)| if present { value } else { f64::NAN };
        values.iter().zip(&self.present).map(value).collect()
    }

    /// Returns the number of given points of the surface that are present.
    pub fn points(&self, surface: &Surface) -> usize {
        self.grid.crop(surface.present()).into_iter().filter(|&present| present).count()
    }

    /// Converts places in an error on sources to given ones.
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

    /// Converts places in an error on paths to given ones.
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
