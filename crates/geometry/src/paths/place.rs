//! Represents a place on the grid that a path passes.

use glam::DVec2;

use super::cell::Weights;
use geosweep_surface::{Chart, Direction};

/// A place on the grid: at a point, on an edge or inside a cell.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    /// A grid point, by its index in bordered arrays.
    Point(usize),
    /// A place on the edge from `first` to the next point to the east or south, at the fraction `share` of
    /// the edge.
    Edge { first: usize, along: Direction, share: f64 },
    /// A place inside the cell with this north-western corner, by the weights of the cell's corners.
    Inside { north_west: usize, weights: Weights },
}

/// The place (row, column) at which a path cannot go on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stuck(pub DVec2);

impl Place {
    /// Returns the row and column.
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

    /// Returns the cells that contain the place, with the place's weights in each, and the number of these
    /// cells; entries after it are unused. Cells are given by their north-western corners. At the grid's sides some of
    /// the cells lie beyond it.
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
