//! Defines straight lines over surfaces whose cells are all alike.

use glam::DVec2;

use geosweep_surface::Origin;

/// The straight lines of the chart over cells that are all alike. Where no hole is in between, they are shortest paths.
#[derive(Clone, Copy, Debug)]
pub(super) struct StraightLines {
    /// The first fundamental form, including slowness: the entries for rows, for both, and for columns.
    metric: [f64; 3],
}

/// Rounding of a foot, as a part of the segment's length and of the distance to its end.
const ROUNDING: f64 = 1e-13;

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
        let length = self.length(at - foot);
        // A point on the segment is a source. The rounding of its foot must not count as a distance.
        if square > 0.0 && length <= ROUNDING * (self.length(at - a) + square.sqrt()) {
            return StraightLine { foot: at, length: 0.0, is_beside };
        }
        StraightLine { foot, length, is_beside }
    }

    #[inline]
    pub(super) fn dot(&self, a: DVec2, b: DVec2) -> f64 {
        let [rr, rc, cc] = self.metric;
        a.x * (rr * b.x + rc * b.y) + a.y * (rc * b.x + cc * b.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_segment_are_sources() {
        let lines = StraightLines::of([900.0, 120.0, 2500.0]);
        let end = |row: f64, col: f64| DVec2::new(row, col);
        for [a, b] in [
            [end(20.0, 0.0), end(20.0, 41.0)],
            [end(3.1, 0.7), end(33.1, 30.7)],
            [end(1.0, 2.0), end(17.0, 7.0)],
        ] {
            let origin = Origin { ends: [a, b], start: 0.0 };
            for k in 0..=41 {
                let share = f64::from(k) / 41.0;
                assert_eq!(lines.from(&origin, a + share * (b - a)).length, 0.0, "{a} {b} {k}");
                let beside = lines.from(&origin, a + share * (b - a) + end(1e-6, 0.0)).length;
                assert!(beside > 0.0, "{a} {b} {k}");
            }
        }
    }
}
