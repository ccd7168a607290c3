//! Finds the lines of a closed surface that its grid lacks.

use glam::DVec3;

use super::super::gluing::compile::pairs_of;
use super::super::seams::Rim;
use super::super::{Geometry, GluingError, GridSide, Seam, Surface};

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

/// Whether the last line of a grid is the first one again, where its sides continue each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LastLine {
    /// The last line repeats the first one: 37 longitudes from 0 to 360 degrees.
    Repeats,
    /// The last line lies one step before the first one: 36 longitudes from 0 to 350 degrees.
    IsApart,
}

const COLUMNS: [GridSide; 2] = [GridSide::FirstColumn, GridSide::LastColumn];
const ROWS: [GridSide; 2] = [GridSide::FirstRow, GridSide::LastRow];

/// Accepted ratios of the radius of the second row to that of the first, counted from a pole that the grid lacks. On
/// even grids the ratio is 3 if the pole is half a row beyond the first row, and 2 if it is a whole row.
const RATIOS: std::ops::Range<f64> = 1.5..4.5;

impl Layout {
    /// Returns the seams of a surface: `Sides` and `Pole` where the grid has the line of the seam, `Neighbours` and
    /// `Ring` where the grid lacks this line. Returns `None` for the faces of a cube.
    /// `last` is what the caller says about the last line.
    pub(super) fn seams(
        self,
        surface: &Surface,
        last: Option<LastLine>,
    ) -> Result<Option<Vec<Seam>>, GluingError> {
        let continued = |sides, reversed| continued(surface, sides, reversed, last);
        Ok(Some(match self {
            Self::Columns => vec![continued(COLUMNS, false)?],
            Self::Rows => vec![continued(ROWS, false)?],
            Self::Both => vec![continued(COLUMNS, false)?, continued(ROWS, false)?],
            Self::FlippedColumns => vec![continued(COLUMNS, true)?],
            Self::FlippedRows => vec![continued(ROWS, true)?],
            Self::Globe => {
                if !surface.geometry().is_in_space() {
                    return Err(GluingError::NoPositions { what: "a pole" });
                }
                let [north, south] = ROWS.map(|side| pole(surface, side));
                vec![continued(COLUMNS, false)?, north?, south?]
            }
            Self::Cube => return Ok(None),
        }))
    }
}

/// Largest difference, relative to the size of the values, that counts as the rounding of one value.
const ROUNDING: f64 = 1e-6;

/// Returns the seam between two opposite sides: `Sides` if both are the same line, else `Neighbours`. Positions tell
/// that. Lines of heights, or of a metric, that differ are two lines. If they are equal, the caller must say it.
fn continued(
    surface: &Surface,
    sides: [GridSide; 2],
    reversed: bool,
    last: Option<LastLine>,
) -> Result<Seam, GluingError> {
    let (rows, cols) = (surface.rows(), surface.cols());
    if rows.min(cols) < 2 {
        return Err(GluingError::TooSmall { rows, cols });
    }
    let one_line = Seam::Sides { sides, reversed };
    let two_lines = Seam::Neighbours { sides, reversed };
    if surface.geometry().is_in_space() {
        if let Some(side) = sides.into_iter().find(|&side| is_hole(surface, side)) {
            return Err(GluingError::Holes { side });
        }
        let [first, other] = sides.map(|side| Rim::new(surface, side));
        let is_repeated = first.is_along(&other, reversed);
        if is_repeated && last == Some(LastLine::IsApart)
            || !is_repeated && first.gap_to(&other, reversed).is_none()
        {
            return Err(not_neighbours(surface, sides, reversed));
        }
        let is_repeated = is_repeated || last == Some(LastLine::Repeats);
        return Ok(if is_repeated { one_line } else { two_lines });
    }
    match last {
        Some(LastLine::Repeats) => Ok(one_line),
        Some(LastLine::IsApart) => Ok(two_lines),
        None if may_be_one_line(surface, &one_line) => Err(GluingError::Unclear { sides }),
        None => Ok(two_lines),
    }
}

/// Returns whether a side has no point that is present.
fn is_hole(surface: &Surface, side: GridSide) -> bool {
    side.places(surface.chart()).all(|(row, col)| !surface.has(row, col))
}

/// Returns whether the heights or tensors, the slowness and the holes of two sides are equal, up to rounding.
fn may_be_one_line(surface: &Surface, seam: &Seam) -> bool {
    let numbers = |index: usize| match surface.geometry() {
        Geometry::Heights { heights, .. } => [heights[index], 0.0, 0.0],
        Geometry::Metric(metric) => [metric[index].rr, metric[index].rc, metric[index].cc],
        Geometry::Positions(positions) => positions[index].to_array(),
    };
    let pairs = pairs_of(surface.chart(), seam).unwrap_or_default();
    let sizes = pairs.iter().flatten().filter(|&&index| surface.present()[index]);
    let size = sizes.flat_map(|&index| numbers(index)).map(f64::abs).fold(0.0, f64::max);
    let step = match surface.geometry() {
        Geometry::Heights { spacing, .. } => spacing.dx.max(spacing.dy),
        _ => 0.0,
    };
    let same = |a: f64, b: f64, size: f64| a == b || (a - b).abs() <= ROUNDING * size;
    pairs.iter().all(|&[a, b]| {
        let [here, there] = [a, b].map(|index| surface.present()[index]);
        if !(here && there) {
            return here == there;
        }
        let slowness = surface.slowness().map_or([1.0; 2], |slowness| [slowness[a], slowness[b]]);
        let all_same = numbers(a).iter().zip(numbers(b)).all(|(a, b)| same(*a, b, size + step));
        all_same && same(slowness[0], slowness[1], slowness[0])
    })
}

/// Returns the indices of points of the two sides that lie opposite each other, where both are present.
fn pairs(surface: &Surface, sides: [GridSide; 2], reversed: bool) -> Vec<[usize; 2]> {
    let pairs = pairs_of(surface.chart(), &Seam::Sides { sides, reversed }).unwrap_or_default();
    let are_present = |pair: &[usize; 2]| pair.iter().all(|&index| surface.present()[index]);
    pairs.into_iter().filter(are_present).collect()
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

/// Returns the seam of the first or last row: `Pole` if the row is a pole, `Ring` if the row surrounds a pole. The
/// surface has positions.
fn pole(surface: &Surface, side: GridSide) -> Result<Seam, GluingError> {
    if let Some(pole) = Rim::new(surface, side).pole() {
        return Ok(pole);
    }
    let chart = surface.chart();
    if is_hole(surface, side) {
        return Err(GluingError::Holes { side });
    }
    let radius = |rows: usize| {
        let place = |(row, col)| chart.along((row, col), side.inwards(), rows as isize);
        let points = side.places(chart).filter_map(place);
        let points: Vec<_> = points.filter_map(|(row, col)| surface.position(row, col)).collect();
        if points.is_empty() {
            return 0.0;
        }
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        mean(points.iter().map(|point| point.distance(middle)))
    };
    let [inner, outer] = [0, 1].map(radius);
    match RATIOS.contains(&(outer / inner)) {
        true => Ok(Seam::Ring(side)),
        false => Err(GluingError::NoRing { side, inner, outer }),
    }
}
