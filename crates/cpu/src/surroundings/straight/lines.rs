//! Defines straight lines over surfaces whose cells are all alike.

use glam::DVec2;

use geosweep_surface::Origin;

/// The straight lines of the chart over cells that are all alike. Where no hole is in between, they are shortest paths.
#[derive(Clone, Copy, Debug)]
pub(super) struct StraightLines {
    /// The first fundamental form, including slowness: the entries for rows, for both, and for columns.
    metric: [f64; 3],
}

/// The straight line from the nearest point of an origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct StraightLine {
    /// Row and column of the point of the origin.
    pub foot: DVec2,
    /// Length of the line, weighted by the slowness.
    pub length: f64,
    /// Whether the origin is a segment and the line leaves it at a right angle.
    pub is_beside: bool,
}

impl StraightLines {
    /// Returns the lines under a metric ([`geosweep_surface::Surface::even_metric`]).
    pub(super) fn of(metric: [f64; 3]) -> Self {
        Self { metric }
    }

    /// Returns the length of the straight line over `step` rows and columns.
    #[inline]
    pub(super) fn length(&self, step: DVec2) -> f64 {
        self.dot(step, step).max(0.0).sqrt()
    }

    /// Returns the line from an origin to a place.
    #[inline]
    pub(super) fn from(&self, origin: &Origin, at: DVec2) -> StraightLine {
        let [a, b] = origin.ends;
        let along = b - a;
        let square = self.dot(along, along);
        let share = if square > 0.0 { self.dot(at - a, along) / square } else { 0.0 };
        let foot = a + share.clamp(0.0, 1.0) * along;
        let is_beside = square > 0.0 && (0.0..=1.0).contains(&share);
        StraightLine { foot, length: self.length(at - foot), is_beside }
    }

    #[inline]
    pub(super) fn dot(&self, a: DVec2, b: DVec2) -> f64 {
        let [rr, rc, cc] = self.metric;
        a.x * (rr * b.x + rc * b.y) + a.y * (rc * b.x + cc * b.y)
    }
}
