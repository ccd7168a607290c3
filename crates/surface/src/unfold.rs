//! Splits obtuse triangles by grid points beyond their bases (paper, end of section 3, after Kimmel and
//! Sethian). The twin of `glsl/update/splits.glsl`.
//!
//! A front that runs through a triangle with an obtuse angle at x0 may reach x0 before it reaches one end of
//! the base. Then points depend on one another in a cycle. The result depends on the order of updates, and
//! where fronts meet, arrival times that are too early spread. So an obtuse triangle is not used for updates;
//! only its edges are. Instead, the triangles beyond its base are unfolded into its plane, one after another,
//! until a grid point lies between both edges. That point splits the triangle in two. At most one part is
//! obtuse, and it is split again. Where a hole or the border ends the unfolding first, no path from any grid
//! point comes through the remaining part, and this part is not used either.

use super::chart::{Direction, EdgeSlot, Offset, STORED};
use super::edges::EdgeLengths;
use super::obtuse::is_obtuse;
use super::real::{Real, max, min};
use crate::constants::{EVEN_SLOWNESS, SPLIT_MARGIN, SPLIT_REACH, SPLIT_STEPS, STEPS_PER_LINE};

impl<R: Real> EdgeLengths<R> {
    /// Returns the length on the surface of the edge from a point of the bordered array to the neighbour at a
    /// step of rows and columns.
    #[inline(always)]
    pub(super) fn along(&self, point: usize, (down, right): Step) -> R {
        if down.unsigned_abs().max(right.unsigned_abs()) > 1 {
            return R::FAR;
        }
        let Some((stored, is_of_neighbour)) = STORED_AT[(3 * down + right + 4) as usize] else {
            return R::FAR;
        };
        let step = self.chart().offset_by((down, right));
        let offset = if is_of_neighbour { step } else { Offset::NONE };
        let length = self.at(point, EdgeSlot { stored, offset });
        let Some(slowness) = self.slowness().filter(|_| length < R::FAR) else { return length };
        (length + length) / (slowness[point] + slowness[step.from(point)])
    }

    /// Splits a point's triangle between two neighbours in successive directions, if it is obtuse. Calls
    /// `part` for each part with three arguments: the indices of its two other corners in the bordered array;
    /// the lengths of x0 x1, x0 x2 and x1 x2 in the plane; and the slowness by which they are weighted at x0,
    /// x1 and x2.
    ///
    /// A part may cover several cells, whose slowness may differ from the slowness at the part's corners. If
    /// the slowness jumps there, the largest slowness seen in the search for the part counts, so that no
    /// front passes through slow regions too fast.
    #[doc(hidden)]
    pub fn split(
        &self,
        x0: usize,
        directions: [Direction; 2],
        mut part: impl FnMut([usize; 2], [R; 3], [R; 3]),
    ) {
        let chart = self.chart();
        // Sorts the directions, so that the first one is the same for all scans.
        let [first, second] = directions;
        let [a, b] = if first.next() == second { directions } else { [second, first] };
        let base = (b.step().0 - a.step().0, b.step().1 - a.step().1);
        let point_at = |step: Step| chart.offset_by(step).from(x0);
        let [la, lb, c] = [
            self.along(x0, a.step()),
            self.along(x0, b.step()),
            self.along(point_at(a.step()), base),
        ];
        if max(la, max(lb, c)) >= R::FAR {
            return;
        }
        // x0 is the origin, and x1 lies on the first axis.
        let x = R::of(0.5) * (la * la + lb * lb - c * c) / la;
        let height_squared = lb * lb - x * x;
        if !(height_squared > R::zero() && is_obtuse(la * la / (c * c), lb * lb / (c * c))) {
            return;
        }
        let mut wedge = [
            Unfolded { step: a.step(), place: [la, R::zero()] },
            Unfolded { step: b.step(), place: [x, height_squared.sqrt()] },
        ];
        let slowness_at = |point: usize| self.slowness().map_or(R::one(), |of| of[point]);
        let ends =
            [slowness_at(x0), slowness_at(point_at(a.step())), slowness_at(point_at(b.step()))];
        let mut range = [min(ends[0], min(ends[1], ends[2])), max(ends[0], max(ends[1], ends[2]))];
        let mut tell = |[a, b]: [Unfolded<R>; 2], [least, largest]: [R; 2]| {
            let corners = [a, b].map(|end| point_at(end.step));
            let squares = [a.squared(), b.squared(), a.squared_to(&b)];
            let lengths = squares.map(|square| square.sqrt());
            if self.slowness().is_none() {
                return part(corners, lengths, [R::one(); 3]);
            }
            let jumps = largest > R::of(EVEN_SLOWNESS) * least;
            let known = [x0, corners[0], corners[1]].map(slowness_at);
            let [s0, s1, s2] = if jumps { [largest; 3] } else { known };
            let half = R::of(0.5);
            let [l1, l2, c] = lengths;
            let weighted = [half * (s0 + s1) * l1, half * (s0 + s2) * l2, half * (s1 + s2) * c];
            part(corners, weighted, [s0, s1, s2]);
        };
        // The edge beyond which the next point is searched. As seen from x0, its first end is to the right.
        let mut edge = wedge;
        // The sense of the quarter turn that turns an edge to point away from x0.
        let turn = if base.1 * a.step().0 - base.0 * a.step().1 > 0 { 1 } else { -1 };
        let reach = self.reach() as isize;
        let is_far = reach > SPLIT_REACH as isize;
        let steps = if is_far { STEPS_PER_LINE as isize * reach } else { SPLIT_STEPS as isize };
        for _ in 0..steps {
            let Some(apex) = self.beyond(edge, turn, wedge, reach, point_at) else { return };
            let of_apex = slowness_at(point_at(apex.step));
            range = [min(range[0], of_apex), max(range[1], of_apex)];
            if !apex.follows(&wedge[0]) {
                edge[0] = apex;
                continue;
            }
            if !wedge[1].follows(&apex) {
                edge[1] = apex;
                continue;
            }
            let halves = [[wedge[0], apex], [apex, wedge[1]]];
            let obtuse = halves.map(|[a, b]| {
                let base = a.squared_to(&b);
                is_obtuse(a.squared() / base, b.squared() / base)
            });
            if !obtuse[0] {
                tell(halves[0], range);
            }
            if !obtuse[1] {
                tell(halves[1], range);
            }
            match obtuse {
                [true, _] => (wedge[1], edge[1]) = (apex, apex),
                [_, true] => (wedge[0], edge[0]) = (apex, apex),
                _ => return,
            }
        }
    }

    /// Returns the next point beyond an edge of the grid, in x0's plane. Beyond an edge along an axis there
    /// are two candidates. A candidate within the wedge is preferred, then the nearer one, then the one with
    /// the shorter sides. This choice does not depend on how the grid is numbered. Where rounding would
    /// decide, the first candidate is taken.
    fn beyond(
        &self,
        [u, w]: [Unfolded<R>; 2],
        turn: isize,
        [right, left]: [Unfolded<R>; 2],
        reach: isize,
        point_at: impl Fn(Step) -> usize,
    ) -> Option<Unfolded<R>> {
        let along = (w.step.0 - u.step.0, w.step.1 - u.step.1);
        let away = (turn * along.1, -turn * along.0);
        let is_diagonal = along.0 != 0 && along.1 != 0;
        // Beyond a diagonal, the point is halfway between both steps.
        let first =
            if is_diagonal { ((along.0 + away.0) / 2, (along.1 + away.1) / 2) } else { away };
        let second = (along.0 + away.0, along.1 + away.1);
        let base = self.along(point_at(u.step), along);
        let clearly = R::of(1.0 - SPLIT_MARGIN);
        // A candidate, whether it lies within the wedge, and the length of its sides.
        let candidate = |step: Step| {
            let from_w = (step.0 - along.0, step.1 - along.1);
            let from_x0 = (u.step.0 + step.0, u.step.1 + step.1);
            if from_x0.0.abs().max(from_x0.1.abs()) > reach {
                return None;
            }
            let sides = [self.along(point_at(u.step), step), self.along(point_at(w.step), from_w)];
            let place = unfolded([u.place, w.place], base, sides)?;
            let apex = Unfolded { step: from_x0, place };
            Some((apex, apex.follows(&right) && left.follows(&apex), sides[0] + sides[1]))
        };
        let best = candidate(first);
        if is_diagonal {
            return best.map(|(apex, ..)| apex);
        }
        let Some((apex, inside, around)) = candidate(second) else {
            return best.map(|(apex, ..)| apex);
        };
        let is_better = best.is_none_or(|(other, was_inside, other_around)| {
            let (squared, other) = (apex.squared(), other.squared());
            let as_near = (squared >= other * clearly) & (other >= squared * clearly);
            let nearer = if as_near { around < other_around * clearly } else { squared < other };
            if inside == was_inside { nearer } else { inside }
        });
        if is_better { Some(apex) } else { best.map(|(apex, ..)| apex) }
    }
}

/// For each step to a neighbour, three per row: the index of its stored edge, and whether the neighbour
/// stores it.
const STORED_AT: [Option<(usize, bool)>; 9] = {
    let mut found = [None; 9];
    let mut stored = 0;
    while stored < STORED.len() {
        let (down, right) = STORED[stored].step();
        let along = 3 * down + right;
        found[(4 + along) as usize] = Some((stored, false));
        found[(4 - along) as usize] = Some((stored, true));
        stored += 1;
    }
    found
};

/// A step in rows and columns.
pub(super) type Step = (isize, isize);

/// A grid point unfolded into the plane of x0's triangle.
#[derive(Clone, Copy, Debug)]
struct Unfolded<R> {
    /// Step from x0, in rows and columns.
    step: Step,
    place: [R; 2],
}

impl<R: Real> Unfolded<R> {
    /// Returns whether this point lies to the left of another one, seen from x0, by more than rounding can
    /// cause.
    fn follows(&self, other: &Self) -> bool {
        let across = other.place[0] * self.place[1] - other.place[1] * self.place[0];
        across > R::of(SPLIT_MARGIN) * (self.squared() + other.squared())
    }

    /// Returns the squared distance from x0.
    fn squared(&self) -> R {
        let [x, y] = self.place;
        x * x + y * y
    }

    fn squared_to(&self, other: &Self) -> R {
        let [x, y] = [self.place[0] - other.place[0], self.place[1] - other.place[1]];
        x * x + y * y
    }
}

/// Returns the point at the given distances from both ends of an edge, to the right of the edge. Returns `None` if the
/// three lengths do not make a triangle.
fn unfolded<R: Real>([u, w]: [[R; 2]; 2], base: R, [to_u, to_w]: [R; 2]) -> Option<[R; 2]> {
    if max(base, max(to_u, to_w)) >= R::FAR {
        return None;
    }
    let (per_base, half) = (R::one() / base, R::of(0.5));
    let (to_u, to_w) = (to_u * per_base, to_w * per_base);
    let foot = half * ((to_u * to_u - to_w * to_w) + R::one());
    let height_squared = (to_u - foot) * (to_u + foot);
    // The value is NaN where lengths are NaN.
    if height_squared.is_nan() || height_squared <= R::zero() {
        return None;
    }
    let (height, along) = (height_squared.sqrt(), [w[0] - u[0], w[1] - u[1]]);
    Some([u[0] + foot * along[0] + height * along[1], u[1] + foot * along[1] - height * along[0]])
}
