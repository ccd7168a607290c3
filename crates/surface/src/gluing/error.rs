//! The reasons why a surface cannot be glued.

use super::super::GridSide;

/// The reason why a surface cannot be glued, or why something cannot be computed on a glued one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GluingError {
    /// Two points that should be joined lie apart.
    #[error(
        "row {}, column {} and row {}, column {} should be the same point of the surface, but differ by \
         {apart:e}; at most 5 % of {edge:e} is allowed there. Check which sides continue each other, and in which order",
        .places[0].0, .places[0].1, .places[1].0, .places[1].1
    )]
    Apart {
        /// Rows and columns of both points.
        places: [(usize, usize); 2],
        /// Distance between the points, or the difference of their heights, tensors or slowness.
        apart: f64,
        /// Reference size of the difference: the length of an edge or of the seam, or the size of a tensor or slowness.
        /// The difference may be up to 5 % of this size.
        edge: f64,
    },
    /// Two sides have different numbers of points.
    #[error("the {} has {} points and the {} has {}; glued sides need equal numbers",
        .sides[0], .points[0], .sides[1], .points[1])]
    Lengths {
        /// The two sides.
        sides: [GridSide; 2],
        /// Number of points of each one.
        points: [usize; 2],
    },
    /// Two runs have different numbers of points.
    #[error("a run of {} points is glued to one of {}; runs need equal numbers", .points[0], .points[1])]
    Runs {
        /// Number of points of each one.
        points: [usize; 2],
    },
    /// A run leaves the grid.
    #[error("a run from row {row}, column {col} leaves the grid of {rows} x {cols} points")]
    Outside {
        /// Row of the run's first point.
        row: usize,
        /// Column of the run's first point.
        col: usize,
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// A seam or a pair of points is glued a second time.
    #[error("row {}, column {} and row {}, column {} are already one point; name each seam once",
        .places[0].0, .places[0].1, .places[1].0, .places[1].1)]
    Twice {
        /// Rows and columns of both points.
        places: [(usize, usize); 2],
    },
    /// The grid has too few lines for the gluing.
    #[error(
        "a grid of {rows} x {cols} points is too small to be glued; give it at least four lines parallel to the seam"
    )]
    TooSmall {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// Two sides that should continue each other are neither the same line nor neighbours.
    #[error(
        "the {} and the {} should continue each other, but are {apart:e} apart on average, while the next line of \
         the grid is {step:e} from each. The step between them may be up to twice as long as those beside it, or half, \
         and turn by up to 60 degrees. Check which sides continue each other, and in which order",
        .sides[0], .sides[1]
    )]
    NotNeighbours {
        /// The two sides.
        sides: [GridSide; 2],
        /// Mean distance between their points.
        apart: f64,
        /// Mean distance from each side to the next line inwards.
        step: f64,
    },
    /// Opposite sides are equal, so that they may be one line of the surface or two.
    #[error(
        "the {} and the {} hold the same values, so they may be one line that the grid repeats or two lines one step \
         apart; say whether the last line repeats the first one (with the tool, --wrap columns:repeated or \
         columns:apart; in Python, CompletedGrid's last=\"repeated\" or \"apart\")",
        .sides[0], .sides[1]
    )]
    Unclear {
        /// The two sides.
        sides: [GridSide; 2],
    },
    /// A side that should continue another one, or be a pole, has no point.
    #[error(
        "the {side} has only holes, so nothing goes on there; leave it out of the gluing, or give its points"
    )]
    Holes {
        /// The side.
        side: GridSide,
    },
    /// Copies of one point have different values of slowness.
    #[error(
        "row {}, column {} and row {}, column {} are the same point of the surface, but have a slowness of {} and of {}. \
         Give both the same, or two lines that are apart (with the tool, --wrap columns:apart)",
        .places[0].0, .places[0].1, .places[1].0, .places[1].1, .values[0], .values[1]
    )]
    Slowness {
        /// Rows and columns of both points.
        places: [(usize, usize); 2],
        /// The slowness at each.
        values: [f64; 2],
    },
    /// A row should be at a pole or surround one, but does neither.
    #[error(
        "the {side} should be at a pole or surround one. Its points lie {inner:e} from their mean position on average, \
         and those of the next row lie {outer:e} from theirs, so no pole lies half a row or one row beyond it. Leave \
         poles out of the gluing if the grid has none"
    )]
    NoRing {
        /// The row.
        side: GridSide,
        /// Mean distance of the row's points from their mean position.
        inner: f64,
        /// Mean distance of the points of the row beside it from their mean position.
        outer: f64,
    },
    /// A grid does not hold the six faces of a cube.
    #[error(
        "a grid of {rows} x {cols} points does not hold the six square faces of a cube. Arrange 2 x 3, 3 x 2, 1 x 6 or \
         6 x 1 faces, or a cross in 3 x 4 or 4 x 3, side by side or with a line of holes between neighbours. Mark all \
         other points as holes, and give each face at least 4 x 4 texels"
    )]
    NotCube {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// A grid of an octahedral map without known positions is not a square with a point in the middle of each side.
    #[error(
        "an octahedral map of {rows} x {cols} points; its grid is a square with an odd number of points a side, so that \
         a point lies in the middle of each side"
    )]
    NoOddSquare {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// A side of a cube's face has no side of another face beside it.
    #[error(
        "the {side} of the face whose first texel is at row {row}, column {col} has no other face beside it: the nearest \
         side is {apart:e} away, where texels are {step:e} apart. Check the positions and the order of the faces"
    )]
    FaceSide {
        /// The side of the face.
        side: GridSide,
        /// Row of the face's first texel.
        row: usize,
        /// Column of the face's first texel.
        col: usize,
        /// Mean distance to the texels of the nearest side.
        apart: f64,
        /// Mean distance from the side's texels to the next line of texels inwards.
        step: f64,
    },
    /// No two points of the surface coincide.
    #[error(
        "no two points next to a hole or a border of the surface coincide, so there is nothing to glue"
    )]
    Nothing,
    /// The geometry does not allow the gluing.
    #[error(
        "{what} needs positions; heights and metrics can be glued only where opposite sides continue each other"
    )]
    NoPositions {
        /// Name of the gluing.
        what: &'static str,
    },
    /// A metric is glued in reverse order.
    #[error("a metric cannot be glued in reverse order; give positions")]
    ReversedMetric,
    /// A coarser grid of every second row and column would not be glued as the surface is.
    #[error(
        "the seams of the surface do not meet on the coarser grid of every second row and column, with which the map is \
         compared; use a grid of {rows} x {cols} points, or charts with an odd number of points on each side"
    )]
    Uneven {
        /// Number of rows of a grid that has a coarser one.
        rows: usize,
        /// Number of columns of that grid.
        cols: usize,
    },
    /// Something is not available on glued surfaces.
    #[error("{what} does not pass seams yet; {instead}")]
    Unsupported {
        /// Name of the unavailable function, kind of seam or kind of grid.
        what: &'static str,
        /// Advice on an alternative.
        instead: &'static str,
    },
}
