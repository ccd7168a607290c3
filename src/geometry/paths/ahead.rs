//! The next line of a path where nothing bends it much, for a fraction of what a search costs.

use glam::DVec2;

use super::cell::Cell;
use super::trace::{AT_POINT, End, Field, Line, Place, is_triangle};

/// A heading that leaves a cell within less than this part of itself leaves it over the edge that it
/// came by.
const LEAVES_AT_ONCE: f64 = 1e-9;

/// Where a path enters a cell.
pub(super) struct Entry {
    pub north_west: usize,
    /// Over which side, by its corners, and at which share of it.
    pub side: [usize; 2],
    pub share: f64,
}

impl Field<'_> {
    /// The line across the cell that a path has come to, if it ends on the side to which the line
    /// before points and fits the arrival time `below`, so that a search would find nothing better:
    /// but beside sources, at corners of holes and where fronts meet, it does.
    pub(super) fn ahead(
        &self,
        moment: f64,
        entry: Entry,
        heading: DVec2,
        below: f64,
    ) -> Option<Line> {
        let Entry { north_west, side: own, share } = entry;
        if self.goals.touches(north_west) {
            return None;
        }
        let (side, near) = exit(own, share, heading)?;
        let cell = Cell::new(self.edges, north_west);
        let points = side.map(|corner| cell.corners[corner]);
        let (ends, length) = (cell.between_sides(own, share, side), cell.length(side));
        let is_reached = points.iter().all(|&point| self.is_reached(point));
        if !(is_reached && is_triangle(ends, length * length)) {
            return None;
        }
        let crossing = self.profile(moment, points, length).crossing_near(near, ends)?;
        let end =
            Place::Edge { first: points[0], step: points[1] - points[0], share: crossing.share };
        let line = Line {
            end: End::Place(end),
            time: crossing.time,
            length: crossing.distance,
            cell: north_west,
        };
        let between = (AT_POINT..=1.0 - AT_POINT).contains(&crossing.share);
        (between && line.time < below && line.fits(below)).then_some(line)
    }
}

/// The side of a cell, by its corners, and the share of it at which a straight line on the grid
/// leaves the cell that enters it at a share of another.
fn exit(own: [usize; 2], share: f64, heading: DVec2) -> Option<([usize; 2], f64)> {
    // Corners count rows by two and columns by one.
    let place = |corner: usize| DVec2::new((corner / 2) as f64, (corner % 2) as f64);
    let at = place(own[0]).lerp(place(own[1]), share);
    let until = |at: f64, by: f64| match by {
        _ if by > 0.0 => (1.0 - at) / by,
        _ if by < 0.0 => -at / by,
        _ => f64::INFINITY,
    };
    let (by_row, by_col) = (until(at.x, heading.x), until(at.y, heading.y));
    let (way, side, share) = if by_row < by_col {
        let side = if heading.x > 0.0 { [2, 3] } else { [0, 1] };
        (by_row, side, at.y + by_row * heading.y)
    } else {
        let side = if heading.y > 0.0 { [1, 3] } else { [0, 2] };
        (by_col, side, at.x + by_col * heading.x)
    };
    (way > LEAVES_AT_ONCE && way < f64::INFINITY).then_some((side, share))
}
