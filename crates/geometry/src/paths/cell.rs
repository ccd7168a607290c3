//! Measures distances in a cell of the grid from the lengths of its edges alone.

use geosweep_surface::{Direction, EdgeLengths, FAR};

/// The weights of a cell's corners. They add up to one and define a place in the cell.
pub(super) type Weights = [f64; 4];

/// The corners at both ends of each side of a cell. The sides are north, west, east and south.
pub(super) const SIDES: [[usize; 2]; 4] = [[0, 1], [0, 2], [1, 3], [2, 3]];

/// The direction from the first corner of each side to the second.
pub(super) const ALONG: [Direction; 4] =
    [Direction::East, Direction::South, Direction::South, Direction::East];

/// The index of the length between two corners among a cell's lengths. Index 6 stands for the length from a
/// corner to itself, which is zero.
const BETWEEN: [[usize; 4]; 4] = [[6, 0, 1, 2], [0, 6, 3, 4], [1, 3, 6, 5], [2, 4, 5, 6]];

/// The location of each of a cell's lengths: the plane of the edge lengths, and the corner at which the
/// length is stored.
const STORED_AT: [(usize, usize); 6] = [(0, 0), (1, 2), (3, 3), (2, 2), (1, 3), (0, 2)];

/// The limit of squared edge lengths. A larger value means that the edge does not exist.
pub(super) const NO_EDGE: f64 = FAR * FAR * 1e-20;

/// The four corners of a cell (north-west, north-east, south-west, south-east) and the lengths between them.
///
/// Let x and y be the weights of two places, d = x - y, and S the matrix of squared lengths. The squared
/// distance of the places is then -d' S d / 2. This is exact between the edges of a flat cell. For any cell
/// whose corners lie in space it is exact along the straight line between the places. A missing corner has
/// weight zero and contributes nothing.
///
/// Over a slowness the lengths of edges are travel times. The lengths on the surface follow from the slowness at the
/// corners, and a straight line costs its length times the mean slowness of its ends.
pub(super) struct CellLengths {
    pub(super) corners: [usize; 4],
    /// The lengths on the surface, indexed by [`BETWEEN`].
    lengths: [f64; 7],
    /// The slowness at the corners, if there is one.
    slowness: Option<[f64; 4]>,
}

impl CellLengths {
    /// Reads the cell whose north-western corner is the point `north_west` of the bordered array.
    pub(super) fn new(edges: &EdgeLengths<f32>, north_west: usize) -> Self {
        let corners = edges.chart().bordered_corners(north_west);
        let planes = edges.planes();
        let [north, west, falling, rising, east, south] =
            STORED_AT.map(|(plane, corner)| planes[plane][corners[corner]].into());
        let lengths = [north, west, falling, rising, east, south, 0.0];
        let Some(slowness) = edges.slowness() else {
            return Self { corners, lengths, slowness: None };
        };
        let slowness = corners.map(|corner| f64::from(slowness[corner]));
        let mut cell = Self { corners, lengths, slowness: Some(slowness) };
        for (a, row) in BETWEEN.into_iter().enumerate() {
            for (b, slot) in row.into_iter().enumerate().skip(a + 1) {
                let mean = 0.5 * (slowness[a] + slowness[b]);
                // Where travel is free, the length on the surface is not known, and does not count.
                cell.lengths[slot] = if mean > 0.0 { lengths[slot] / mean } else { lengths[slot] };
            }
        }
        cell
    }

    /// Returns the cost of a straight line between two places whose squared distance is given.
    #[inline]
    pub(super) fn cost(&self, square: f64, a: &Weights, b: &Weights) -> f64 {
        let length = square.max(0.0).sqrt();
        match &self.slowness {
            Some(slowness) => length * 0.5 * (dot(slowness, a) + dot(slowness, b)),
            None => length,
        }
    }

    /// Returns the slowness at a place and at both corners, if there is a slowness.
    pub(super) fn slowness(&self, place: &Weights, corners: [usize; 2]) -> Option<[f64; 3]> {
        let slowness = self.slowness.as_ref()?;
        Some([dot(slowness, place), slowness[corners[0]], slowness[corners[1]]])
    }

    /// Returns the length between two corners.
    pub(super) fn length(&self, [a, b]: [usize; 2]) -> f64 {
        self.lengths[BETWEEN[a][b]]
    }

    fn squares(&self) -> [[f64; 4]; 4] {
        let squares = self.lengths.map(|length| length * length);
        BETWEEN.map(|row| row.map(|slot| squares[slot]))
    }

    /// Returns the squared distances from a place to the corners. For a missing corner the value is larger
    /// than any squared distance.
    pub(super) fn from(&self, place: &Weights) -> [f64; 4] {
        let products = self.squares().map(|row| dot(&row, place));
        let spread = 0.5 * dot(&products, place);
        products.map(|product| product - spread)
    }

    /// Returns the squared distance between two places.
    #[inline]
    pub(super) fn square(&self, a: &Weights, b: &Weights) -> f64 {
        let (d, l) = ([a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]], &self.lengths);
        // The sum over all pairs of corners, in the order of `STORED_AT`.
        let first = d[0] * (l[0] * l[0] * d[1] + l[1] * l[1] * d[2] + l[2] * l[2] * d[3]);
        let others = d[1] * (l[3] * l[3] * d[2] + l[4] * l[4] * d[3]) + d[2] * d[3] * l[5] * l[5];
        (-(first + others)).max(0.0)
    }
}

/// Returns the length between two corners of a cell without reading the other lengths.
#[inline]
pub(super) fn length(edges: &EdgeLengths<f32>, corners: &[usize; 4], [a, b]: [usize; 2]) -> f64 {
    // If both corners are the same, an arbitrary entry is read, which avoids a branch.
    let (plane, corner) = STORED_AT[BETWEEN[a][b] % STORED_AT.len()];
    let length = f64::from(edges.planes()[plane][corners[corner]]);
    if a == b { 0.0 } else { length }
}

/// Returns the weights of a corner.
pub(super) fn corner_alone(corner: usize) -> Weights {
    std::array::from_fn(|k| if k == corner { 1.0 } else { 0.0 })
}

#[inline]
fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}
