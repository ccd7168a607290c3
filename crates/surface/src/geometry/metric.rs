//! The metric tensor of a grid point.

use glam::DMat2;

/// The first fundamental form at a grid point in index coordinates. A small step of `dr` rows and `dc`
/// columns has the squared length `rr dr^2 + 2 rc dr dc + cc dc^2` (paper, eq. 3, with u^1 the row and u^2
/// the column).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MetricTensor {
    /// Entry for rows.
    pub rr: f64,
    /// Mixed entry.
    pub rc: f64,
    /// Entry for columns.
    pub cc: f64,
}

impl MetricTensor {
    /// Returns the length of a step of rows and columns.
    pub(crate) fn length(&self, [rows, cols]: [f64; 2]) -> f64 {
        let Self { rr, rc, cc } = self;
        (rr * rows * rows + 2.0 * rc * rows * cols + cc * cols * cols).max(0.0).sqrt()
    }

    pub(super) fn is_hole(self) -> bool {
        self.rr.is_nan() || self.rc.is_nan() || self.cc.is_nan()
    }

    pub(super) fn is_positive_definite(self) -> bool {
        let finite = self.rr.is_finite() && self.rc.is_finite() && self.cc.is_finite();
        finite && self.rr > 0.0 && self.cc > 0.0 && self.rr * self.cc > self.rc * self.rc
    }

    pub(super) fn matrix(self) -> DMat2 {
        DMat2::from_cols_array(&[self.rr, self.rc, self.rc, self.cc])
    }
}
