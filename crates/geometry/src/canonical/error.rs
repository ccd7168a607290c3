//! Defines the errors of canonical forms, and the limits on matrices. Most messages say what to do.

use std::ops::RangeInclusive;

/// The largest allowed difference between the two distances of a pair of points, as a fraction of the largest
/// distance of the matrix.
///
/// With a planar wavefront on a coarse grid, the two distances differ by up to a few hundredths. A matrix
/// with larger differences is not a matrix of distances.
pub const ASYMMETRY: f32 = 0.05;

/// The allowed range of the largest distance. Within it, squared distances stay in the range of single
/// precision.
pub const EXTENT: RangeInclusive<f32> = 1e-15..=1e15;

/// The reason why a canonical form cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CanonicalError {
    /// The array is not a square matrix.
    #[error(
        "{values} values do not form a matrix of {points} x {points} distances, which has {}",
        .points * .points
    )]
    NotSquare {
        /// Number of values in the array.
        values: usize,
        /// Number of points that the caller stated.
        points: usize,
    },
    /// A distance is not a number.
    #[error(
        "the distance from point {from} to point {to} is NaN; mark unreachable points by +infinity"
    )]
    NotANumber {
        /// Row of the matrix.
        from: usize,
        /// Column of the matrix.
        to: usize,
    },
    /// A distance is negative.
    #[error("the distance from point {from} to point {to} is negative: {distance}")]
    Negative {
        /// Row of the matrix.
        from: usize,
        /// Column of the matrix.
        to: usize,
        /// The distance.
        distance: f32,
    },
    /// The distance of a point from itself is not zero.
    #[error(
        "the distance from point {point} to itself is {distance}, not 0, so this is not a matrix of distances"
    )]
    Diagonal {
        /// The point.
        point: usize,
        /// The distance.
        distance: f32,
    },
    /// The two distances of a pair of points differ by more than a solver's error.
    #[error(
        "the distance from point {from} to point {to} is {there}, but {back} in the other direction; a matrix of \
         distances is symmetric up to errors below {} of the largest distance; symmetrise it first if \
         the difference is intended",
        ASYMMETRY
    )]
    Asymmetric {
        /// Row of the matrix.
        from: usize,
        /// Column of the matrix.
        to: usize,
        /// The distance in one direction.
        there: f32,
        /// The distance in the other direction.
        back: f32,
    },
    /// No path leads from one point to another.
    #[error(
        "point {to} cannot be reached from point {from}: how far apart to place them is not known; \
         leave out all but one piece"
    )]
    Unreachable {
        /// Row of the matrix.
        from: usize,
        /// Column of the matrix.
        to: usize,
    },
    /// There are too few points for the requested number of dimensions.
    #[error("{points} points do not span {dimensions} dimensions; at least {} are needed", .dimensions + 1)]
    TooFewPoints {
        /// Number of points.
        points: usize,
        /// Requested number of dimensions.
        dimensions: usize,
    },
    /// All distances are zero.
    #[error("all distances are zero: give at least two distinct points")]
    NoExtent,
    /// Squared distances are outside the range of single precision.
    #[error(
        "the largest distance is {largest:e}; choose a unit of length in which it lies between \
         {:e} and {:e}",
        EXTENT.start(),
        EXTENT.end()
    )]
    Extent {
        /// The largest distance.
        largest: f32,
    },
    /// The number of starting coordinates does not match the form.
    #[error(
        "the start has {found} coordinates; {points} points in {dimensions} dimensions have {}",
        .points * .dimensions
    )]
    StartSize {
        /// Number of coordinates in the start.
        found: usize,
        /// Number of points.
        points: usize,
        /// Requested number of dimensions.
        dimensions: usize,
    },
    /// A coordinate of the start is NaN or infinite.
    #[error("the start's coordinate {axis} of point {point} is not finite")]
    StartNotFinite {
        /// The point.
        point: usize,
        /// The axis of the coordinate, from 0.
        axis: usize,
    },
    /// An option is out of its range.
    #[error("{0}")]
    Options(String),
}
