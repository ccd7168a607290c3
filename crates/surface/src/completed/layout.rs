//! Finds the lines of a closed surface that its grid lacks.

use glam::DVec3;

use super::super::gluing::compile::pairs_of;
use super::super::seams::Rim;
use super::super::{Geometry, GluingError, GridSide, MetricTensor, Seam, Surface};

/// Continuation of a closed surface across the sides of its grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layout {
    /// The last column continues in the first one: a tube.
    Columns,
    /// The last row continues in the first one.
    Rows,
    /// Columns and rows both continue: a torus.
    Both,
    /// The last column continues in the first one in reverse order: a Moebius strip.
    FlippedColumns,
    /// The last row continues in the first one in reverse order.
    FlippedRows,
    /// Rows are latitudes from pole to pole, and the last column continues in the first one.
    Globe,
    /// Six square faces of a cube, with values at the middles of texels. They form 2 x 3, 3 x 2, 1 x 6 or 6 x 1 faces,
    /// or a cross in 3 x 4 or 4 x 3 with holes around it. Faces adjoin, or one line of unused values separates them.
    /// Positions tell which sides meet, and in which order.
    Cube,
}

const COLUMNS: [GridSide; 2] = [GridSide::FirstColumn, GridSide::LastColumn];
const ROWS: [GridSide; 2] = [GridSide::FirstRow, GridSide::LastRow];

/// Accepted ratios of the radius of the second row to that of the first, counted from a pole that the grid lacks. On
/// even grids the ratio is 3 if the pole is half a row beyond the first row, and 2 if it is a whole row.
const RATIOS: std::ops::Range<f64> = 1.5..4.5;

impl Layout {
    /// Returns the seams of a surface: `Sides` and `Pole` where the grid has the line of the seam, `Neighbours` and
    /// `Ring` where the grid lacks this line. Returns `None` for the faces of a cube.
    pub(super) fn seams(self, surface: &Surface) -> Result<Option<Vec<Seam>>, GluingError> {
        let continued = |sides, reversed| continued(surface, sides, reversed);
        Ok(Some(match self {
            Self::Columns => vec![continued(COLUMNS, false)?],
            Self::Rows => vec![continued(ROWS, false)?],
            Self::Both => vec![continued(COLUMNS, false)?, continued(ROWS, false)?],
            Self::FlippedColumns => vec![continued(COLUMNS, true)?],
            Self::FlippedRows => vec![continued(ROWS, true)?],
            Self::Globe => {
                let [north, south] = ROWS.map(|side| pole(surface, side));
                vec![continued(COLUMNS, false)?, north?, south?]
            }
            Self::Cube => return Ok(None),
        }))
    }
}

/// Returns the seam between two opposite sides: `Sides` if both are the same line, else `Neighbours`.
fn continued(surface: &Surface, sides: [GridSide; 2], reversed: bool) -> Result<Seam, GluingError> {
    let (rows, cols) = (surface.rows(), surface.cols());
    if rows.min(cols) < 2 {
        return Err(GluingError::TooSmall { rows, cols });
    }
    let is_repeated = match surface.geometry() {
        Geometry::Positions(_) => {
            let [first, last] = sides.map(|side| Rim::new(surface, side));
            let is_repeated = first.is_along(&last, reversed);
            if !is_repeated && first.gap_to(&last, reversed).is_none() {
                return Err(not_neighbours(surface, sides, reversed));
            }
            is_repeated
        }
        Geometry::Heights { heights, .. } => equal(surface, sides, reversed, |k| [heights[k]; 3]),
        Geometry::Metric(metric) => equal(surface, sides, reversed, |k| {
            let MetricTensor { rr, rc, cc } = metric[k];
            [rr, rc, cc]
        }),
    };
    Ok(match is_repeated {
        true => Seam::Sides { sides, reversed },
        false => Seam::Neighbours { sides, reversed },
    })
}

/// Returns the indices of points of the two sides that lie opposite each other, where both are present.
fn pairs(surface: &Surface, sides: [GridSide; 2], reversed: bool) -> Vec<[usize; 2]> {
    let pairs = pairs_of(surface.chart(), &Seam::Sides { sides, reversed }).unwrap_or_default();
    let are_present = |pair: &[usize; 2]| pair.iter().all(|&index| surface.present()[index]);
    pairs.into_iter().filter(are_present).collect()
}

/// Returns whether `numbers` agrees at all pairs of points of two sides.
fn equal(
    surface: &Surface,
    sides: [GridSide; 2],
    reversed: bool,
    numbers: impl Fn(usize) -> [f64; 3],
) -> bool {
    pairs(surface, sides, reversed).iter().all(|&[a, b]| numbers(a) == numbers(b))
}

/// Returns an error with the distance between two sides.
fn not_neighbours(surface: &Surface, sides: [GridSide; 2], reversed: bool) -> GluingError {
    let chart = surface.chart();
    let position = |index: usize| {
        let (row, col) = chart.position(index);
        surface.position(row, col).unwrap_or(DVec3::NAN)
    };
    let pairs = pairs(surface, sides, reversed);
    let apart = pairs.iter().map(|&[a, b]| position(a).distance(position(b)));
    let steps = sides.into_iter().flat_map(|side| {
        let step = move |(row, col): (usize, usize)| {
            let (r, c) = chart.neighbour(row, col, side.inwards())?;
            Some(surface.position(row, col)?.distance(surface.position(r, c)?))
        };
        side.places(chart).filter_map(step)
    });
    GluingError::NotNeighbours { sides, apart: mean(apart), step: mean(steps) }
}

/// Returns the mean of some lengths, or NaN if there are none.
pub(super) fn mean(lengths: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = lengths.fold((0.0, 0u32), |(sum, count), length| (sum + length, count + 1));
    sum / f64::from(count)
}

/// Returns the seam of the first or last row: `Pole` if the row is a pole, `Ring` if the row surrounds a pole.
fn pole(surface: &Surface, side: GridSide) -> Result<Seam, GluingError> {
    if !surface.geometry().is_in_space() {
        return Err(GluingError::NoPositions { what: "a pole" });
    }
    if let Some(pole) = Rim::new(surface, side).pole() {
        return Ok(pole);
    }
    let chart = surface.chart();
    let radius = |rows: usize| {
        let place = |(row, col)| chart.along((row, col), side.inwards(), rows as isize);
        let points = side.places(chart).filter_map(place);
        let points: Vec<_> = points.filter_map(|(row, col)| surface.position(row, col)).collect();
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        mean(points.iter().map(|point| point.distance(middle)))
    };
    let [inner, outer] = [0, 1].map(radius);
    match RATIOS.contains(&(outer / inner)) {
        true => Ok(Seam::Ring(side)),
        false => Err(GluingError::NoRing { side, inner, outer }),
    }
}
