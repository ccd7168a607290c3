//! Adds a line to opposite sides of a grid, and at poles.

use super::super::gluing::Lattice;
use super::super::{Chart, Gluing, GluingError, GridSide, Seam};
use super::added::Added;
use super::axis::Axis;
use super::grid::CompletedGrid;

/// Smallest number of given lines along a seam between opposite sides, and of rows between poles.
const LEAST_LINES: usize = 4;

/// Lines that a grid has or lacks.
#[derive(Default)]
struct Lines {
    /// Order of the continuation from the last column to the first one and from the last row to the first one.
    lattice: Lattice,
    /// Whether a column or a row that continues the grid is lacking.
    has_column_added: bool,
    has_row_added: bool,
    /// For the first and the last row: `None` if no pole is there, else whether the row of the pole is lacking.
    poles: [Option<bool>; 2],
}

/// Completes a grid with seams, as [`CompletedGrid::with_seams`] does. `beyond` holds the distances of added poles from
/// the first and the last row, and `step` is the distance of an added column from the last one. Both count in steps
/// between given lines.
pub(in super::super) fn completed(
    chart: Chart,
    seams: &[Seam],
    beyond: [f64; 2],
    step: f64,
) -> Result<CompletedGrid, GluingError> {
    let lines = Lines::of(chart, seams)?;
    let [before, after] = [0, 1].map(|end| match lines.poles[end] {
        Some(true) => beyond[end],
        _ => 0.0,
    });
    let margin = |is_added: bool, step: f64| if is_added { step } else { 0.0 };
    let mut grid = CompletedGrid {
        rows: Axis::single(chart.rows, [before, after + margin(lines.has_row_added, 1.0)]),
        cols: Axis::single(chart.cols, [0.0, margin(lines.has_column_added, step)]),
        added: Vec::new(),
        gluing: Gluing::Seams(seams.iter().copied().map(repeated).collect()),
    };
    lines.add_to(&mut grid);
    Ok(grid)
}

/// Returns a seam after its lines have been added.
fn repeated(seam: Seam) -> Seam {
    match seam {
        Seam::Neighbours { sides, reversed } => Seam::Sides { sides, reversed },
        Seam::Ring(side) | Seam::Pole { side, .. } => Seam::Pole { side, exact: true },
        other => other,
    }
}

impl Lines {
    fn of(chart: Chart, seams: &[Seam]) -> Result<Self, GluingError> {
        let mut lines = Self::default();
        let unsupported = |what, instead| Err(GluingError::Unsupported { what, instead });
        for seam in seams {
            let lattice = Lattice::of(&repeated(*seam));
            let is_added = matches!(seam, Seam::Neighbours { .. });
            match *seam {
                Seam::Ring(side) | Seam::Pole { side, .. } if side.is_row() => {
                    let end = usize::from(side == GridSide::LastRow);
                    lines.poles[end] = Some(matches!(seam, Seam::Ring(_)));
                }
                Seam::Sides { .. } | Seam::Neighbours { .. } if lattice != Lattice::default() => {
                    lines.has_column_added |= is_added && lattice.cols.is_some();
                    lines.has_row_added |= is_added && lattice.rows.is_some();
                }
                _ => {
                    return unsupported(
                        "a grid that lacks lines, with a fold, a pole at a column or a seam between a row and a column,",
                        "append the lines that it lacks",
                    );
                }
            }
            lines.lattice = lines.lattice.and(lattice);
        }
        let Lattice { cols, rows, .. } = lines.lattice;
        let has_few_rows = chart.rows < LEAST_LINES && (rows.is_some() || lines.poles != [None; 2]);
        if has_few_rows || chart.cols < LEAST_LINES && cols.is_some() {
            return Err(GluingError::TooSmall { rows: chart.rows, cols: chart.cols });
        }
        if cols == Some(true) && lines.has_row_added || rows == Some(true) && lines.has_column_added
        {
            return unsupported(
                "a reversed seam beside lines that are added",
                "append the lines that the grid lacks at its other sides",
            );
        }
        if rows.is_some() && lines.poles != [None; 2] {
            return unsupported(
                "a seam between rows that are poles",
                "name either the seam or the poles",
            );
        }
        Ok(lines)
    }

    /// Adds the points of the lines that are lacking. Poles come last, since the row of a pole includes the end of an
    /// added column.
    fn add_to(&self, grid: &mut CompletedGrid) {
        let (given, chart) = (grid.given(), grid.chart());
        let Lattice { cols, rows, .. } = self.lattice;
        if self.has_column_added {
            let copy = |row: usize| {
                let from = if cols == Some(true) { given.rows - 1 - row } else { row };
                let at = chart.index(grid.rows.line(0, row as isize), chart.cols - 1);
                Added::copy(at, given.index(from, 0))
            };
            grid.added.extend((0..given.rows).map(copy));
        }
        if self.has_row_added {
            let copy = |col: usize| {
                let from = if rows == Some(true) { given.cols - 1 - col } else { col };
                Added::copy(chart.index(chart.rows - 1, col), given.index(0, from % given.cols))
            };
            grid.added.extend((0..chart.cols).map(copy));
        }
        let ends = [[0, 0, 1], [chart.rows - 1, given.rows - 1, given.rows - 2]];
        // A column that the grid repeats at both sides counts once in a ring.
        let repeated = usize::from(cols.is_some() && !self.has_column_added);
        for ([line, near, far], is_added) in ends.into_iter().zip(self.poles) {
            let Some(is_added) = is_added else { continue };
            let ring =
                |row: usize| (0..given.cols - repeated).map(|col| given.index(row, col)).collect();
            grid.added.push(Added {
                at: chart.row(line).collect(),
                near: ring(near),
                far: if is_added { ring(far) } else { Vec::new() },
            });
        }
    }
}
