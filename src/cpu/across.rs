//! The points across the base of a triangle from its x0, where two arcs of a front may touch.

use super::state::TriangleSlots;
use crate::surface::{Chart, Direction, EdgeLengths, EdgeSlot, Real};
use crate::update::Across;

/// A triangle of a point between two directions that follow one another, and the two points that lie
/// two lines away across its base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quad {
    pub triangle: TriangleSlots,
    /// Which of x1 and x2 is the neighbour along an axis of the grid; the other is one across a diagonal.
    pub axis: usize,
    across: [AcrossSlots; 2],
}

/// Where one of these lies, and its edges to x1 and x2, seen from x0.
#[derive(Clone, Copy, Debug)]
struct AcrossSlots {
    offset: isize,
    sides: [EdgeSlot; 2],
}

impl Quad {
    /// The triangle between two directions that follow one another.
    pub(super) fn new(chart: Chart, first: Direction, second: Direction) -> Self {
        // One leads along an axis of the grid, the other across a diagonal.
        let [axis, diagonal] =
            if first.step().0 * first.step().1 == 0 { [first, second] } else { [second, first] };
        let mirrored = Direction::ALL[(2 * axis as usize + 8 - diagonal as usize) % 8];
        // Behind the neighbour along the axis, and behind that across the diagonal.
        let across = [[axis, mirrored], [diagonal, axis]].map(|[from_axis, from_diagonal]| {
            let slot = |at: Direction, to| EdgeSlot::new(chart, chart.offset(at), to);
            let sides = [slot(axis, from_axis), slot(diagonal, from_diagonal)];
            let sides = if axis == first { sides } else { [sides[1], sides[0]] };
            AcrossSlots { offset: chart.offset(axis) + chart.offset(from_axis), sides }
        });
        let triangle = TriangleSlots::new(chart, first, second);
        Self { triangle, axis: usize::from(axis != first), across }
    }

    /// The points across the base of a triangle whose two other corners are reached, with their fronts
    /// as `front` sees them: arrival time and curvature.
    pub(super) fn across<R: Real>(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        front: impl Fn(usize) -> [R; 2],
    ) -> [Across<R>; 2] {
        self.across.map(|AcrossSlots { offset, sides }| {
            let sides = sides.map(|slot| edges.at(point, slot));
            let [time, curvature] = front(point.wrapping_add_signed(offset));
            Across { time, curvature, sides }
        })
    }
}
