//! Defines the triangles of the grid through which curves are marched.
//!
//! A cell with four corners present is cut along one of its diagonals. A cell with one missing corner leaves
//! a triangle. So no curve runs where the surface has a hole or no map.

use super::{Chart, Direction};

/// An edge between neighbouring grid points: the index of its first point in row-major order, and the
/// direction of the other point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Edge(u64);

/// Directions from an edge's first point to the other.
const FORWARD: [Direction; 4] =
    [Direction::East, Direction::SouthWest, Direction::South, Direction::SouthEast];

impl Edge {
    /// Returns the edge between two neighbours, given in any order.
    #[doc(hidden)]
    pub fn between(chart: Chart, a: usize, b: usize) -> Self {
        let (first, second) = (a.min(b), a.max(b));
        // On grids of two columns, the steps to the east and to the south-west have the same difference of
        // indices.
        let same_row = first / chart.cols == second / chart.cols;
        let slot = if same_row { 0 } else { second + 2 - first - chart.cols };
        Self(4 * first as u64 + slot as u64)
    }

    /// Returns row and column of the first point, and the direction of the other.
    #[doc(hidden)]
    #[inline]
    pub fn ends(self, chart: Chart) -> ((usize, usize), Direction) {
        (chart.position((self.0 / 4) as usize), FORWARD[(self.0 % 4) as usize])
    }

    /// Returns the indices of both points.
    #[doc(hidden)]
    #[inline]
    pub fn points(self, chart: Chart) -> [usize; 2] {
        let ((row, col), to) = self.ends(chart);
        let last = chart.neighbour(row, col, to).expect("the edge of a chart has two ends");
        [chart.index(row, col), chart.index(last.0, last.1)]
    }

    /// Returns a number that identifies the edge. Numbers larger than those of the grid's edges are unused.
    #[doc(hidden)]
    #[inline]
    pub fn number(self) -> u64 {
        self.0
    }

    #[doc(hidden)]
    #[inline]
    pub fn from_number(number: u64) -> Self {
        Self(number)
    }

    /// Returns a number above those of all edges of the grid.
    #[doc(hidden)]
    #[inline]
    pub fn end(chart: Chart) -> u64 {
        4 * chart.points() as u64
    }
}

/// Returns the triangles of a cell, counter-clockwise as seen in a picture. Corners have the numbers of
/// [`Cell::corners`](super::Cell::corners). If `falling`, the cell is cut from north-west to south-east; this
/// matters only if all corners are present.
pub fn triangles(there: [bool; 4], falling: bool) -> &'static [[usize; 3]] {
    const FALLING: [[usize; 3]; 2] = [[0, 2, 3], [0, 3, 1]];
    const RISING: [[usize; 3]; 2] = [[0, 2, 1], [2, 3, 1]];
    match there {
        [true, true, true, true] if falling => &FALLING,
        [true, true, true, true] => &RISING,
        [true, false, true, true] => &FALLING[..1],
        [true, true, false, true] => &FALLING[1..],
        [true, true, true, false] => &RISING[..1],
        [false, true, true, true] => &RISING[1..],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_know_their_ends_in_narrow_grids_too() {
        for cols in [2, 3, 9] {
            let chart = Chart { rows: 4, cols };
            let mut seen = std::collections::HashSet::new();
            for index in 0..chart.points() {
                let (row, col) = chart.position(index);
                for to in FORWARD {
                    let Some((r, c)) = chart.neighbour(row, col, to) else { continue };
                    let other = chart.index(r, c);
                    let edge = Edge::between(chart, other, index);
                    assert_eq!(edge, Edge::between(chart, index, other));
                    assert_eq!(edge.ends(chart), ((row, col), to));
                    assert!(seen.insert(edge) && edge.number() < Edge::end(chart));
                }
            }
        }
    }

    #[test]
    fn triangles_are_counter_clockwise_and_fill_what_is_there() {
        const PLACE: [[f64; 2]; 4] = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
        for mask in 0..16u32 {
            let there = [0, 1, 2, 3].map(|corner| mask >> corner & 1 == 1);
            for falling in [false, true] {
                let mut area = 0.0;
                for triangle in triangles(there, falling) {
                    assert!(triangle.iter().all(|&corner| there[corner]));
                    let [a, b, c] = triangle.map(|corner| PLACE[corner]);
                    // Rows count downwards.
                    let twice = (b[1] - a[1]) * (a[0] - c[0]) - (c[1] - a[1]) * (a[0] - b[0]);
                    assert_eq!(twice, 1.0);
                    area += 0.5 * twice;
                }
                let expected = [0.0, 0.0, 0.0, 0.5, 1.0][mask.count_ones() as usize];
                assert_eq!(area, expected);
            }
        }
    }
}
