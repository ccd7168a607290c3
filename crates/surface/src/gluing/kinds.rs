//! Kinds of gluing that a caller may request.

#[cfg(doc)]
use crate::Surface;
use crate::{Direction, GridSide, Seam};

/// A gluing of sides of the grid. Each variant names points that are the same point of the surface.
///
/// ```
/// use std::f64::consts::TAU;
/// use geosweep::glam::DVec3;
/// use geosweep::surface::Gluing;
/// use geosweep::{Options, Sources, Surface, distance_map};
/// // A tube whose last column repeats its first.
/// let angle = |index: usize| TAU * (index % 65) as f64 / 64.0;
/// let point = |index| DVec3::new(angle(index).cos(), angle(index).sin(), (index / 65) as f64 / 10.0);
/// let tube = Surface::from_positions(33, 65, (0..33 * 65).map(point).collect())?
///     .with_gluing(Gluing::columns())?;
/// // From one side of the seam to the other the way is short.
/// let map = distance_map(&tube, &Sources::point(16.0, 2.0), &Options::default())?;
/// assert!((map.distance(16, 62) as f64 - TAU * 4.0 / 64.0).abs() < 1e-4);
/// # Ok::<(), geosweep::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Gluing {
    /// Seams between sides of the grid, as [`Surface::seams`] finds them: sides that coincide
    /// ([`Seam::Sides`]), the halves of a side ([`Seam::Fold`]), and sides that are one point
    /// ([`Seam::Pole`]).
    Seams(Vec<Seam>),
    /// An octahedral map, with cells of equal areas or not: each side of the square is folded in its middle. The middle
    /// of the grid is one pole and its four corners are the other.
    Octahedral,
    /// Charts that holes separate in one grid, such as the six faces of a cube. All coinciding points beside a hole or
    /// the border are glued.
    Charts,
    /// Runs of points that coincide pair by pair.
    Runs(Vec<[Run; 2]>),
}

impl Gluing {
    /// Glues the last column to the first one.
    pub fn columns() -> Self {
        Self::Seams(vec![COLUMNS])
    }

    /// Glues the last row to the first one.
    pub fn rows() -> Self {
        Self::Seams(vec![ROWS])
    }

    /// Glues the last column to the first one and the last row to the first one, as on a torus.
    pub fn both() -> Self {
        Self::Seams(vec![COLUMNS, ROWS])
    }

    /// Glues the last column to the first one in reverse order, as on a Moebius strip.
    pub fn flipped_columns() -> Self {
        Self::Seams(vec![Seam::Sides { sides: COLUMN_SIDES, reversed: true }])
    }

    /// Glues the last row to the first one in reverse order.
    pub fn flipped_rows() -> Self {
        Self::Seams(vec![Seam::Sides { sides: ROW_SIDES, reversed: true }])
    }

    /// Glues a grid of latitudes (rows) and longitudes (columns): the last column to the first one, and each of
    /// the first and last row to a pole.
    pub fn globe() -> Self {
        let [north, south] = ROW_SIDES.map(|side| Seam::Pole { side, exact: true });
        Self::Seams(vec![COLUMNS, north, south])
    }
}

const COLUMN_SIDES: [GridSide; 2] = [GridSide::FirstColumn, GridSide::LastColumn];
const ROW_SIDES: [GridSide; 2] = [GridSide::FirstRow, GridSide::LastRow];
const COLUMNS: Seam = Seam::Sides { sides: COLUMN_SIDES, reversed: false };
const ROWS: Seam = Seam::Sides { sides: ROW_SIDES, reversed: false };

/// Grid points along a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Row and column of the first point.
    pub from: (usize, usize),
    /// Direction to the next point.
    pub to: Direction,
    /// Number of points.
    pub points: usize,
}
