//! Defines one source of a map.

use glam::DVec2;

/// A source of a map. Rows and columns may be fractional, and count from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A point, at a grid point or inside a cell.
    Point {
        /// Row and column.
        at: DVec2,
        /// Arrival time at the source itself.
        initial: f64,
    },
    /// A polyline over the grid. Every point on it is a source.
    Curve {
        /// Rows and columns of the vertices. The last vertex may repeat the first.
        vertices: Vec<DVec2>,
        /// Arrival time along the curve.
        initial: f64,
    },
}

impl Source {
    /// Returns the arrival time at the source.
    pub fn initial(&self) -> f64 {
        match self {
            Self::Point { initial, .. } | Self::Curve { initial, .. } => *initial,
        }
    }
}
