//! Defines straight lines over surfaces whose cells are all alike.

use glam::DVec2;

use super::around::Surroundings;
use geosweep_surface::{Direction, EdgeLengths, Origin, Real, Surface};

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
    /// Returns the lines over cells like those around a place. The result is `None` if edges there are too long or too
    /// short.
    pub(super) fn around(surface: &Surface, at: DVec2) -> Option<Self> {
        let around = Surroundings::new(surface, at, [1, 1]);
        Some(Self { metric: metric(around.edges()?) })
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
    fn dot(&self, a: DVec2, b: DVec2) -> f64 {
        let [rr, rc, cc] = self.metric;
        a.x * (rr * b.x + rc * b.y) + a.y * (rc * b.x + cc * b.y)
    }
}

/// Returns the metric of cells that are all alike, from the lengths of edges in the middle of a part of the
/// surface. It is 1 in directions that have no edges. The middle is used since arcs at the sides of the part differ
/// from those of the whole surface.
fn metric<R: Real>(edges: &EdgeLengths<R>) -> [f64; 3] {
    let chart = edges.chart();
    let from_middle = |&(row, col): &(usize, usize)| {
        (2 * row).abs_diff(chart.rows - 1).max((2 * col).abs_diff(chart.cols - 1))
    };
    let mut places: Vec<_> = chart.places().collect();
    places.sort_by_key(from_middle);
    let length = |to: Direction| {
        let mut all = places.iter().map(|&(row, col)| edges.length(row, col, to));
        all.find(|length| *length < R::FAR).map(R::wide)
    };
    let square = |to| length(to).map(|length| length * length);
    let (rr, cc) =
        (square(Direction::South).unwrap_or(1.0), square(Direction::East).unwrap_or(1.0));
    let falling = square(Direction::SouthEast).map(|square| 0.5 * (square - rr - cc));
    let rising = square(Direction::SouthWest).map(|square| 0.5 * (rr + cc - square));
    [rr, falling.or(rising).unwrap_or(0.0), cc]
}
