//! A cell of the grid and the distances in it, from the lengths of its edges alone.

use crate::surface::{Direction, EdgeLengths, FAR};

/// Weights of a cell's corners, which add up to one: a place in the cell.
pub(super) type Weights = [f64; 4];

/// The corners at both ends of a cell's sides: north, west, east and south.
pub(super) const SIDES: [[usize; 2]; 4] = [[0, 1], [0, 2], [1, 3], [2, 3]];

/// Where the second of these corners lies from the first.
pub(super) const ALONG: [Direction; 4] =
    [Direction::East, Direction::South, Direction::South, Direction::East];

/// Which of a cell's lengths is that between two corners; a corner is no way from itself.
const BETWEEN: [[usize; 4]; 4] = [[6, 0, 1, 2], [0, 6, 3, 4], [1, 3, 6, 5], [2, 4, 5, 6]];

/// Where these lengths are stored: in which of the planes of edges, and at which corner.
const STORED_AT: [(usize, usize); 6] = [(0, 0), (1, 2), (3, 3), (2, 2), (1, 3), (0, 2)];

/// Squares of lengths of edges that do not exist are larger.
pub(super) const NO_EDGE: f64 = FAR * FAR * 1e-20;

/// The four corners of a cell, north-west, north-east, south-west and south-east, and the lengths
/// between them.
///
/// With weights x and y of the corners for two places, d = x - y and S the matrix of squared
/// lengths, the squared distance of the places is -d' S d / 2: exact between the edges of a flat
/// cell, and between those of any cell whose corners lie in space, along the straight line there.
/// With a corner missing its weight is zero, and so is its part.
pub(super) struct CellLengths {
    pub(super) corners: [usize; 4],
    /// By the numbers in [`BETWEEN`].
    lengths: [f64; 7],
}

impl CellLengths {
    /// The cell to the south-east of a point of the bordered array.
    pub(super) fn new(edges: &EdgeLengths<f32>, north_west: usize) -> Self {
        let corners = edges.chart().bordered_corners(north_west);
        let planes = edges.planes();
        let [north, west, falling, rising, east, south] =
            STORED_AT.map(|(plane, corner)| planes[plane][corners[corner]].into());
        Self { corners, lengths: [north, west, falling, rising, east, south, 0.0] }
    }

    /// Length between two corners.
    pub(super) fn length(&self, [a, b]: [usize; 2]) -> f64 {
        self.lengths[BETWEEN[a][b]]
    }

    fn squares(&self) -> [[f64; 4]; 4] {
        let squares = self.lengths.map(|length| length * length);
        BETWEEN.map(|row| row.map(|slot| squares[slot]))
    }

    /// Squared distances from a place to the corners; at corners that are missing, too large for
    /// any distance.
    pub(super) fn from(&self, place: &Weights) -> [f64; 4] {
        let products = self.squares().map(|row| dot(&row, place));
        let spread = 0.5 * dot(&products, place);
        products.map(|product| product - spread)
    }

    /// Squared distance of two places.
    pub(super) fn square(&self, a: &Weights, b: &Weights) -> f64 {
        let apart = std::array::from_fn(|k| a[k] - b[k]);
        (-0.5 * dot(&self.squares().map(|row| dot(&row, &apart)), &apart)).max(0.0)
    }
}

/// Length between two corners of a cell, without a look at the others.
#[inline]
pub(super) fn length(edges: &EdgeLengths<f32>, corners: &[usize; 4], [a, b]: [usize; 2]) -> f64 {
    // A corner reads what is at hand, rather than branch.
    let (plane, corner) = STORED_AT[BETWEEN[a][b] % STORED_AT.len()];
    let length = f64::from(edges.planes()[plane][corners[corner]]);
    if a == b { 0.0 } else { length }
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}
