//! Converts between the grid of a file and the grid of a surface. The surface may have more lines: copies of lines that
//! a closed surface needs at both ends of its grid, and poles.

use geosweep::Surface;
use geosweep::geometry::{Curve, PathError};
use geosweep::io::{Georeference, GridFrame};
use geosweep::shown::exact;
use geosweep::surface::{Chart, CompletedGrid, SourceError};

/// The grid of a file. Its rows, columns and points are called *given*, in contrast to those of the surface's grid.
pub struct GivenGrid {
    pub lines: CompletedGrid,
    /// The size of the given grid.
    pub chart: Chart,
    /// The map coordinates of the given grid, with margins that reach to the ends of the surface.
    pub frame: GridFrame,
    /// Whether the last column continues in the first one.
    pub goes_round: bool,
}

/// Largest distance in columns at which a vertex counts as lying on the line where the grid begins and ends.
const ON_SEAM: f64 = 1e-6;

impl GivenGrid {
    /// Makes the grid of a file. `lines` are the lines of the surface's grid.
    pub fn new(
        lines: CompletedGrid,
        georeference: Result<Georeference, String>,
        goes_round: bool,
    ) -> Self {
        let chart = lines.given();
        let frame = GridFrame::new(chart, georeference).with_margins(lines.margins());
        Self { lines, chart, frame, goes_round }
    }

    /// Converts a given place to a place on the surface's grid.
    pub fn place(&self, place: [f64; 2]) -> Result<[f64; 2], String> {
        let within = self.frame.within(place).and_then(|place| self.lines.to_completed(place));
        within.ok_or_else(|| {
            let ([row, col], [last_row, last_col]) = (place.map(exact), self.last());
            format!(
                "{row},{col} lies outside the grid: rows run from 0 to {last_row}, columns from 0 to {last_col}"
            )
        })
    }

    /// Returns the vertices of a given curve on the surface's grid. They jump where the curve passes a pole or the line
    /// where the grid begins and ends. A vertex on that line is put on the side of its neighbours.
    pub fn curve(&self, given: &[[f64; 2]], surface: &Surface) -> Result<Vec<[f64; 2]>, String> {
        let given = if self.goes_round { self.on_sides(given) } else { given.to_vec() };
        let vertices =
            given.into_iter().map(|place| self.place(place)).collect::<Result<_, _>>()?;
        let curve = Curve { vertices, closed: false };
        let half = 0.5 * (surface.cols() - 1) as f64;
        let is_leap = |ends: &&[[f64; 2]]| (ends[0][1] - ends[1][1]).abs() > half;
        let parts = curve.parts(surface);
        let leap = parts.iter().find_map(|part| part.vertices.windows(2).find(is_leap));
        match leap.filter(|_| self.goes_round) {
            None => Ok(curve.vertices),
            Some(ends) => Err(format!(
                "a curve leads from column {} to column {}, over more than half a turn; divide it \
                 where the grid begins and ends, or give it a vertex there",
                exact(self.lines.to_given(ends[0])[1]),
                exact(self.lines.to_given(ends[1])[1])
            )),
        }
    }

    /// Moves each vertex on the seam to the side of the last vertex before it that is off the seam, or, if there is
    /// none, of the next one. Where the curve crosses the seam, the vertex is repeated on the other side.
    fn on_sides(&self, given: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let end = self.last()[1] as f64 + self.lines.margins()[1][1];
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

    /// Returns the number of given points of the surface that are present.
    pub fn points(&self, surface: &Surface) -> usize {
        self.lines.crop(surface.present()).into_iter().filter(|&present| present).count()
    }

    /// Converts the places in an error on sources to given places.
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

    /// Converts the places in an error on paths to given places.
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
        [*row, *col] = self.lines.to_given([*row, *col]);
    }
}
