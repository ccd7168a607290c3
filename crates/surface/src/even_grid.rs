//! Defines even grids, whose positions are an affine function of row and column.

use glam::{DVec2, DVec3};

/// A grid whose positions are an affine function of row and column.
#[derive(Clone, Copy, Debug)]
pub struct EvenGrid {
    /// The vectors from a row to the next and from a column to the next.
    pub(super) steps: [DVec3; 2],
}

impl EvenGrid {
    /// Returns the first fundamental form: the entries for rows, for both, and for columns.
    #[doc(hidden)]
    pub fn metric(self) -> [f64; 3] {
        let [a, b] = self.steps;
        [a.dot(a), a.dot(b), b.dot(b)]
    }

    /// Returns a place, given by row and column, relative to the first point.
    pub(crate) fn at(self, place: DVec2) -> DVec3 {
        self.steps[0] * place.x + self.steps[1] * place.y
    }

    /// Returns the length of the straight line over `step` rows and columns.
    pub(crate) fn length(self, step: DVec2) -> f64 {
        self.at(step).length()
    }

    /// Returns whether one of the triangles of neighbours has an obtuse angle.
    pub(crate) fn is_obtuse(self) -> bool {
        let [a, b] = self.steps;
        a.dot(b).abs() > a.length_squared().min(b.length_squared())
    }
}
