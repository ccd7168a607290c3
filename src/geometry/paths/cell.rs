//! A cell of the grid and the distances in it, from the lengths of its edges alone.

use crate::surface::{Chart, EdgeLengths};

/// Weights of a cell's corners, which add up to one: a place in the cell.
pub(super) type Weights = [f64; 4];

/// The corners at both ends of a cell's sides: north, west, east and south.
pub(super) const SIDES: [[usize; 2]; 4] = [[0, 1], [0, 2], [1, 3], [2, 3]];

/// The four corners of a cell, north-west, north-east, south-west and south-east, and the squared
/// lengths between them.
///
/// With weights x and y of the corners for two places, d = x - y and S the matrix of squared
/// lengths, the squared distance of the places is -d' S d / 2: exact between the edges of a flat
/// cell, and between those of any cell whose corners lie in space, along the straight line there.
/// With a corner missing its weight is zero, and so is its part.
pub(super) struct Cell {
    pub(super) corners: [usize; 4],
    squares: [[f64; 4]; 4],
}

impl Cell {
    /// The cell to the south-east of a point of the bordered array.
    pub(super) fn new(edges: &EdgeLengths<f32>, north_west: usize) -> Self {
        let corners = corners(edges.chart(), north_west);
        let [_, north_east, south_west, south_east] = corners;
        let [to_east, to_north, to_north_east, to_north_west] = edges.planes();
        let square = |length: f32| f64::from(length) * f64::from(length);
        let north = square(to_east[north_west]);
        let west = square(to_north[south_west]);
        let falling = square(to_north_west[south_east]);
        let rising = square(to_north_east[south_west]);
        let east = square(to_north[south_east]);
        let south = square(to_east[south_west]);
        debug_assert_eq!(north_east, north_west + 1);
        let squares = [
            [0.0, north, west, falling],
            [north, 0.0, rising, east],
            [west, rising, 0.0, south],
            [falling, east, south, 0.0],
        ];
        Self { corners, squares }
    }

    /// Squared length between two corners.
    pub(super) fn between(&self, [a, b]: [usize; 2]) -> f64 {
        self.squares[a][b]
    }

    /// Squared distances from a place to the corners; at corners that are missing, too large for
    /// any distance.
    pub(super) fn from(&self, place: &Weights) -> [f64; 4] {
        let products = self.squares.map(|row| dot(&row, place));
        let spread = 0.5 * dot(&products, place);
        products.map(|product| product - spread)
    }

    /// Squared distance of two places.
    pub(super) fn square(&self, a: &Weights, b: &Weights) -> f64 {
        let apart = std::array::from_fn(|k| a[k] - b[k]);
        (-0.5 * dot(&self.squares.map(|row| dot(&row, &apart)), &apart)).max(0.0)
    }
}

/// The corners of the cell to the south-east of a point of the bordered array.
pub(super) fn corners(chart: Chart, north_west: usize) -> [usize; 4] {
    let south_west = north_west + chart.stride();
    [north_west, north_west + 1, south_west, south_west + 1]
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}
