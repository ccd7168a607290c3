//! Where a path is.

use glam::DVec2;

use super::cell::Weights;
use crate::surface::{Chart, Direction};

/// Where a path is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    /// At a point of the bordered array.
    Point(usize),
    /// On the edge to the next point to the east or south, at a share of its length.
    Edge { first: usize, along: Direction, share: f64 },
    /// In a cell.
    Inside { north_west: usize, weights: Weights },
}

/// Where a path cannot go on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stuck(pub DVec2);

impl Place {
    /// Row and column.
    pub(super) fn at(self, chart: Chart) -> DVec2 {
        match self {
            Self::Point(point) => chart.bordered_place(point),
            Self::Edge { first, along, share } => {
                chart.bordered_place(first) + share * along.vector()
            }
            Self::Inside { north_west, weights: [_, ne, sw, se] } => {
                chart.bordered_place(north_west) + DVec2::new(sw + se, ne + se)
            }
        }
    }

    /// The cells that it lies in, by their north-western corners, its weights there, and how many they are.
    pub(super) fn cells(self, chart: Chart) -> ([(usize, Weights); 4], usize) {
        use Direction::{North, NorthWest, West};
        let none = (0, [0.0; 4]);
        match self {
            Self::Point(point) => {
                let cells = [
                    (point, [1.0, 0.0, 0.0, 0.0]),
                    (chart.beside(point, West), [0.0, 1.0, 0.0, 0.0]),
                    (chart.beside(point, North), [0.0, 0.0, 1.0, 0.0]),
                    (chart.beside(point, NorthWest), [0.0, 0.0, 0.0, 1.0]),
                ];
                (cells, 4)
            }
            Self::Edge { first, along: Direction::East, share } => {
                let rest = 1.0 - share;
                let (south, north) = ([rest, share, 0.0, 0.0], [0.0, 0.0, rest, share]);
                ([(first, south), (chart.beside(first, North), north), none, none], 2)
            }
            Self::Edge { first, share, .. } => {
                let rest = 1.0 - share;
                let (east, west) = ([rest, 0.0, share, 0.0], [0.0, rest, 0.0, share]);
                ([(first, east), (chart.beside(first, West), west), none, none], 2)
            }
            Self::Inside { north_west, weights } => ([(north_west, weights), none, none, none], 1),
        }
    }
}
