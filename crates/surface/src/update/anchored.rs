//! Implements fronts that know their anchor. They are exact over floor plans. The twin of
//! `glsl/update/anchored.glsl` and `glsl/update/anchored_ways.glsl`.
//!
//! A shortest path over a flat grid with holes is a chain of straight lines that bends only at corners of holes. Its
//! last bend, or its source, is the *anchor* of the points that follow (the pseudo-source of exact polyhedral methods;
//! Mitchell, Mount and Papadimitriou, "The discrete geodesic problem", 1987). The distance of a point is the distance
//! of its anchor plus the length of the straight line from there. So no shape of the front is assumed inside a
//! triangle. The candidates of a point are the anchors of two neighbours, and the anchors of these anchors. Of the
//! candidates from which the point can be reached through the triangle, the one with the shortest path is chosen. This
//! test mostly just computes, in whole numbers, the side of a line on which a grid point lies. Where fronts meet, and
//! the corner that shades one point from another is not known, the straight line is followed over the grid.
//!
//! An anchor that no neighbour knows is missed. Among holes of single points, the region in sight of a corner
//! often stays narrower than a cell over a long way, and distances there can be too long.

use glam::DVec2;
use rayon::prelude::*;

use super::anchor::Anchor;
use super::carried::StoredFront;
use super::inside::InsideSources;
use crate::constants::{ALIKE, ALIKE_AT_ANCHOR, BENDS_BACK, LINES_BACK};
use crate::{
    Chart, Direction, EdgeLengths, EdgeSlot, EvenGrid, Offset, Real, Seed, is_corner, is_open, min,
};

/// A floor plan as the update sees it: a flat, evenly spaced grid with holes.
///
/// Anchors are numbered: first the points of a bordered array, then the sources inside cells.
#[derive(Clone, Debug)]
pub struct Floor<R> {
    chart: Chart,
    /// Neighbours to which each point of the bordered array has edges, one bit each.
    edges: Vec<u8>,
    /// Offsets of the eight neighbours in the bordered array.
    around: [Offset; 8],
    /// Tables indexed by the edges of a point: whether it is a corner, and which of the eight sectors between
    /// neighbouring directions lead into a hole.
    corners: [bool; 256],
    blocked: [u8; 256],
    /// The entries of the metric: rr, rc and cc for rows (r) and columns (c).
    metric: [R; 3],
    inside: InsideSources,
}

/// A path to a point: the arrival time, the anchor, and the arrival time at the anchor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way<R> {
    pub time: R,
    pub anchor: usize,
    start: R,
}

impl<R: Real> Way<R> {
    /// The absence of a path.
    pub(crate) const NONE: Self = Self { time: R::FAR, anchor: 0, start: R::FAR };

    /// Returns the shorter of two paths. Of two equally long paths on one line, the path from the last corner
    /// passed is returned.
    fn or(self, other: Self) -> Self {
        let as_long = !is_shorter(self.time, other.time) && !is_shorter(other.time, self.time);
        let second = if as_long { other.start > self.start } else { other.time < self.time };
        if second { other } else { self }
    }
}

/// Returns whether one time is earlier than another by more than rounding.
#[inline(always)]
pub fn is_shorter<R: Real>(a: R, b: R) -> bool {
    a < b * R::of(1.0 - ALIKE * R::epsilon().wide())
}

/// The straight rays from one anchor to the points of a row or column. A ray counts if it passes between the
/// outer two of the three neighbours that the scan has passed. All quantities are linear from point to point,
/// except the length of the ray.
#[derive(Clone, Copy)]
pub struct Rays<R> {
    /// Arrival time stored at the anchor; [`Real::FAR`] if the anchor has not been reached.
    known: R,
    /// Step from the line behind.
    ahead: Step<R>,
    metric: [R; 3],
    /// Step to the anchor, and its change from a point to the next.
    step: Step<R>,
    per_point: Step<R>,
    /// Number of lines by which the anchor lies behind, against the direction of the scan, and number of
    /// points by which it lies aside. Each is given with its change from a point to the next.
    back: [R; 2],
    aside: [R; 2],
}

impl<R: Real> Rays<R> {
    /// Returns the arrival time at the i-th point, or [`Real::FAR`], given the time `behind` of the point
    /// behind it.
    #[inline(always)]
    #[doc(hidden)]
    pub fn time(&self, i: usize, behind: R) -> R {
        let i = R::of(i as f64);
        let [back, aside] = [self.back, self.aside].map(|[first, per_point]| first + per_point * i);
        let step = [0, 1].map(|k| self.step[k] + self.per_point[k] * i);
        let passes = (aside.abs() <= back) & (back >= R::one());
        let from_behind = [step[0] + self.ahead[0], step[1] + self.ahead[1]];
        let start = start(self.known, behind, length(self.metric, from_behind));
        if passes { start + length(self.metric, step) } else { R::FAR }
    }
}

/// Returns the arrival time at the anchor of a point that was reached at `time`, a distance `straight` from
/// the anchor.
///
/// If the `known` time of the anchor agrees with `time - straight` up to rounding, the known time is
/// returned, which is the more accurate one. Otherwise `time - straight` is returned, since a change must
/// come from the neighbours.
#[inline(always)]
fn start<R: Real>(known: R, time: R, straight: R) -> R {
    let follows = time - straight;
    let rounding = R::of(ALIKE_AT_ANCHOR) * R::epsilon() * time;
    if (known - follows).abs() <= rounding { known } else { follows }
}

/// Returns the length of a straight line.
#[inline(always)]
fn length<R: Real>([rr, rc, cc]: [R; 3], [row, col]: Step<R>) -> R {
    (row * (rr * row + (rc + rc) * col) + cc * col * col).sqrt()
}

/// A neighbour that has been reached.
#[derive(Clone, Copy)]
struct End<R> {
    point: usize,
    time: R,
    anchor: usize,
    /// Arrival time at the anchor.
    start: R,
}

/// The step in rows and columns from one place to another.
type Step<R> = [R; 2];

/// Decodes the bits of a point's edges: for each direction, whether the neighbour is present.
fn there(edges: usize) -> [bool; 8] {
    std::array::from_fn(|to| edges >> to & 1 != 0)
}

/// Returns twice the area between two steps. Its sign says on which side of one step the other one lies.
fn cross<R: Real>(a: Step<R>, b: Step<R>) -> f64 {
    a[0].wide() * b[1].wide() - a[1].wide() * b[0].wide()
}

fn dot<R: Real>(a: Step<R>, b: Step<R>) -> f64 {
    a[0].wide() * b[0].wide() + a[1].wide() * b[1].wide()
}

/// A path that is not straight.
struct Detour {
    /// The first corner after the anchor at which the path bends. If the path bends at no earlier corner,
    /// this is the end's own anchor.
    first_bend: usize,
    /// Whether the path bends to both sides.
    winds: bool,
}

impl<R: Real> Floor<R> {
    /// Makes a floor with these edges. `grid` is the grid of a floor plan ([`EdgeLengths::floor`]).
    #[doc(hidden)]
    pub fn new(lengths: &EdgeLengths<R>, grid: EvenGrid) -> Self {
        let chart = lengths.chart();
        let slots = Direction::ALL.map(|to| EdgeSlot::of(chart, to));
        let mut edges = vec![0; chart.bordered_points()];
        chart.rows_mut(&mut edges).enumerate().for_each(|(row, inner)| {
            for (bit, &slot) in slots.iter().enumerate() {
                let lengths = lengths.row(chart.bordered(row, 0), slot, chart.cols);
                for (edges, &length) in inner.iter_mut().zip(lengths) {
                    *edges |= if length < R::FAR { 1 << bit } else { 0 };
                }
            }
        });
        Self {
            chart,
            edges,
            around: Direction::ALL.map(|to| chart.offset(to)),
            corners: std::array::from_fn(|edges| is_corner(there(edges))),
            blocked: std::array::from_fn(|edges| {
                let is_blocked = |eighth: &usize| !is_open(there(edges), *eighth);
                (0..8).filter(is_blocked).fold(0, |all, eighth| all | 1 << eighth)
            }),
            metric: grid.metric().map(R::of),
            inside: InsideSources::new(grid),
        }
    }

    /// Returns the number of bytes held.
    #[doc(hidden)]
    pub fn bytes(&self) -> usize {
        self.edges.len()
    }

    /// Returns the number of a seed's anchor.
    #[doc(hidden)]
    pub fn anchor_of(&mut self, seed: &Seed) -> Anchor<R> {
        let own = self.chart.bordered(seed.row, seed.col);
        Anchor::new(self.inside.number(seed).map_or(own, |source| self.first_inside() + source))
    }

    /// Returns the first number that stands for a source inside a cell.
    #[inline(always)]
    fn first_inside(&self) -> usize {
        self.edges.len()
    }

    /// Forgets the sources inside cells.
    #[doc(hidden)]
    pub fn forget(&mut self) {
        self.inside.truncate(0);
    }

    /// Returns the neighbour of a point in one of the eight directions.
    #[inline]
    fn neighbour(&self, point: usize, to: usize) -> Option<usize> {
        let is_there = self.edges[point] >> to & 1 != 0;
        is_there.then(|| self.around[to].from(point))
    }

    /// Returns whether a point is present and has neighbours.
    #[inline]
    #[doc(hidden)]
    pub fn has(&self, point: usize) -> bool {
        self.edges[point] != 0
    }

    /// Returns whether a point has all three neighbours around the direction `middle`, and paths bend at none
    /// of them.
    #[doc(hidden)]
    pub fn is_open(&self, point: usize, middle: usize) -> bool {
        [7, 0, 1].into_iter().all(|turn| {
            let end = self.neighbour(point, (middle + turn) % 8);
            end.is_some_and(|end| !self.is_corner(end))
        })
    }

    /// Returns whether paths can bend at a point.
    #[inline]
    fn is_corner(&self, point: usize) -> bool {
        self.corners[usize::from(self.edges[point])]
    }

    /// Returns row and column of an anchor, counted from the border. They are whole numbers, except for
    /// sources inside cells.
    #[inline(always)]
    fn place(&self, anchor: usize) -> Step<R> {
        match anchor.checked_sub(self.first_inside()) {
            Some(source) => {
                let place = self.inside.all()[source].place + DVec2::ONE;
                [R::of(place.x), R::of(place.y)]
            }
            None => {
                let (row, col) = self.chart.short_entry(anchor as u32);
                [row, col].map(|line| R::of(f64::from(line)))
            }
        }
    }

    #[inline(always)]
    fn step(&self, from: usize, to: usize) -> Step<R> {
        self.step_to(from, self.place(to))
    }

    #[inline(always)]
    fn step_to(&self, from: usize, to: [R; 2]) -> Step<R> {
        let from = self.place(from);
        [to[0] - from[0], to[1] - from[1]]
    }

    fn length(&self, step: Step<R>) -> R {
        length(self.metric, step)
    }

    /// Returns the rays that a scan brings to the points of a line, from the anchor of the point behind the
    /// first one. The scan moves by `ahead`. The first point is at the row and column `first`, and each
    /// further one lies a step `along` after the one before.
    #[inline(always)]
    #[doc(hidden)]
    pub fn rays(
        &self,
        first: [usize; 2],
        ahead: [isize; 2],
        along: [isize; 2],
        front: impl Fn(usize) -> StoredFront<R, Anchor<R>>,
    ) -> Rays<R> {
        let behind = |axis: usize| first[axis].wrapping_add_signed(-ahead[axis]);
        let behind = self.chart.entry_index(behind(0), behind(1));
        let [ahead, along] = [ahead, along].map(|steps| steps.map(|steps| R::of(steps as f64)));
        let point = first.map(|line| R::of(line as f64));
        let anchor = front(behind).carried.number();
        let place = self.place(anchor);
        let step = [place[0] - point[0], place[1] - point[1]];
        let per_point = along.map(|steps| -steps);
        let across = ahead.map(|steps| R::one() - steps.abs());
        let product = |a: Step<R>, b: Step<R>| a[0] * b[0] + a[1] * b[1];
        Rays {
            known: self.known(anchor, &front),
            ahead,
            metric: self.metric,
            step,
            per_point,
            back: [-product(step, ahead), -product(per_point, ahead)],
            aside: [product(step, across), product(per_point, across)],
        }
    }

    /// Returns the arrival time at an anchor.
    #[inline(always)]
    fn known(&self, anchor: usize, front: &impl Fn(usize) -> StoredFront<R, Anchor<R>>) -> R {
        self.of_anchor(anchor, front).map_or(R::FAR, |(time, _)| time)
    }

    /// Returns the arrival time at an anchor, and the anchor's own anchor. The result is `None` if the anchor
    /// has not been reached.
    #[inline(always)]
    fn of_anchor(
        &self,
        anchor: usize,
        front: &impl Fn(usize) -> StoredFront<R, Anchor<R>>,
    ) -> Option<(R, usize)> {
        if let Some(source) = anchor.checked_sub(self.first_inside()) {
            return Some((R::of(self.inside.all()[source].time), anchor));
        }
        let StoredFront { time, carried } = front(anchor);
        (time < R::FAR).then(|| (time, carried.number()))
    }

    /// Returns the anchor of an anchor, with the arrival time there. The result is `None` for a source.
    #[inline(always)]
    fn before(
        &self,
        anchor: usize,
        front: &impl Fn(usize) -> StoredFront<R, Anchor<R>>,
    ) -> Option<(R, usize)> {
        let (_, before) = self.of_anchor(anchor, front).filter(|&(_, before)| before != anchor)?;
        Some((self.of_anchor(before, front)?.0, before))
    }

    /// Returns the straight path to a point from an anchor that was reached at the time `start`.
    pub(crate) fn way(&self, x0: usize, start: R, anchor: usize) -> Way<R> {
        Way { time: start + self.length(self.step(x0, anchor)), anchor, start }
    }

    /// Returns the neighbour of a point in the direction `to`, if it has been reached.
    #[inline(always)]
    fn end(
        &self,
        x0: usize,
        to: usize,
        front: &impl Fn(usize) -> StoredFront<R, Anchor<R>>,
    ) -> Option<End<R>> {
        let point = self.neighbour(x0, to)?;
        let StoredFront { time, carried } = front(point);
        if time >= R::FAR {
            return None;
        }
        let anchor = carried.number();
        let straight = self.length(self.step(point, anchor));
        let start = start(self.known(anchor, front), time, straight);
        Some(End { point, time, anchor, start })
    }

    /// Returns the shortest path to a point through its three neighbours in the directions `middle - 1` to
    /// `middle + 1`. `front` gives the fronts at grid points.
    #[doc(hidden)]
    pub fn reach(
        &self,
        x0: usize,
        middle: usize,
        front: impl Fn(usize) -> StoredFront<R, Anchor<R>>,
    ) -> Way<R> {
        let end = |turn| self.end(x0, (middle + turn) % 8, &front);
        let ends = [end(7), end(0), end(1)];
        let mut best = Way::NONE;
        for pair in ends.windows(2) {
            if let [Some(a), Some(b)] = *pair {
                best = best.or(self.through(x0, [a, b], &front));
            }
        }
        for end in ends.into_iter().flatten() {
            best = best.or(self.along(x0, end));
        }
        best
    }

    /// Returns the path along an edge: from the end of the edge if that is a corner, else the straight
    /// continuation.
    #[inline(always)]
    fn along(&self, x0: usize, end: End<R>) -> Way<R> {
        if self.is_corner(end.point) {
            return self.way(x0, end.time, end.point);
        }
        let (edge, ray) = (self.step(x0, end.point), self.step(x0, end.anchor));
        let goes_on = cross(edge, ray) == 0.0 && dot(edge, ray) >= dot(edge, edge);
        if goes_on { self.way(x0, end.start, end.anchor) } else { Way::NONE }
    }

    /// Returns the shortest straight path through a triangle, from the anchor of one of its ends or from an
    /// earlier anchor on the path to that end.
    fn through(
        &self,
        x0: usize,
        ends: [End<R>; 2],
        front: &impl Fn(usize) -> StoredFront<R, Anchor<R>>,
    ) -> Way<R> {
        let [e1, e2] = ends.map(|end| self.step(x0, end.point));
        let turn = cross(e1, e2);
        let mut best = Way::NONE;
        // If both ends have the same anchor, this anchor alone is in sight of all points between them.
        let is_of_one = ends[0].anchor == ends[1].anchor;
        for end in &ends[..if is_of_one { 1 } else { 2 }] {
            let (mut start, mut anchor, mut next) = (end.start, end.anchor, end.point);
            let mut bends = 0;
            for _ in 0..=LINES_BACK {
                let ray = self.step(x0, anchor);
                let [a, b] = [cross(ray, e2) * turn, cross(e1, ray) * turn];
                // A path from an end itself comes along its edge (`along`). If two points learned of such an
                // anchor from each other, they would keep a time that the anchor no longer has.
                let is_end = ends.iter().any(|end| end.point == anchor);
                let beyond_base = a >= 0.0 && b >= 0.0 && a + b >= turn * turn && !is_end;
                let way = self.way(x0, start, anchor);
                if beyond_base && ends.iter().all(|end| self.sees(x0, way, end, front)) {
                    best = best.or(way);
                }
                let Some((time, before)) = self.before(anchor, front) else { break };
                bends += u32::from(self.turn(before, anchor, next) != 0.0);
                if is_of_one || bends > BENDS_BACK {
                    break;
                }
                (start, anchor, next) = (time, before, anchor);
            }
        }
        best
    }

    /// Returns the side of the ray from an anchor to a corner on which the corner's hole lies: 1, -1, or 0 if
    /// there are holes on both sides.
    fn shadow(&self, anchor: usize, corner: usize) -> f64 {
        let ray = self.step(anchor, corner);
        let blocked = self.blocked[usize::from(self.edges[corner])];
        let (mut left, mut right) = (false, false);
        for eighth in (0..8).filter(|eighth| blocked >> eighth & 1 != 0) {
            let [a, b] = [eighth, (eighth + 1) % 8].map(|to| Direction::ALL[to].step());
            let side = cross(ray, [R::of((a.0 + b.0) as f64), R::of((a.1 + b.1) as f64)]);
            left |= side > 0.0;
            right |= side < 0.0;
        }
        f64::from(u8::from(left)) - f64::from(u8::from(right))
    }

    /// Returns the side to which a path turns at the second of three points: positive, negative, or 0 if it is
    /// straight.
    #[inline(always)]
    fn turn(&self, before: usize, at: usize, next: usize) -> f64 {
        cross(self.step(before, at), self.step(at, next))
    }

    /// Returns the shape of the path from an anchor to an end, or `None` if it is unknown.
    fn detour(
        &self,
        anchor: usize,
        start: R,
        end: &End<R>,
        front: &impl Fn(usize) -> StoredFront<R, Anchor<R>>,
    ) -> Option<Detour> {
        let (mut at, mut next, mut first_bend) = (end.anchor, end.point, end.anchor);
        let (mut left, mut right) = (false, false);
        for _ in 0..LINES_BACK {
            let (time, before) = self.before(at, front)?;
            let turn = self.turn(before, at, next);
            left |= turn > 0.0;
            right |= turn < 0.0;
            if before == anchor {
                return Some(Detour { first_bend, winds: left && right });
            }
            if is_shorter(time, start) {
                return None;
            }
            if self.turn(anchor, before, at) != 0.0 {
                first_bend = before;
            }
            (at, next) = (before, at);
        }
        None
    }

    /// Returns whether an anchor is visible from x0, given one end of the base.
    ///
    /// The end's path shows which corner may hide the anchor: the first corner on the path from the anchor to
    /// the end. The corner's shadow lies behind the corner, on the side of its hole. If the end lies in this
    /// shadow, an x0 in the shadow does not see the anchor. An x0 outside of it does, unless the end's path
    /// winds between holes. In all other cases another corner may hide the anchor, but only if the straight
    /// line to the end would be shorter than the end's path. Then the straight line from x0 is followed over
    /// the grid.
    fn sees(
        &self,
        x0: usize,
        way: Way<R>,
        end: &End<R>,
        front: &impl Fn(usize) -> StoredFront<R, Anchor<R>>,
    ) -> bool {
        let Way { anchor, start, .. } = way;
        if end.anchor == anchor {
            return true;
        }
        if let Some(Detour { first_bend, winds }) = self.detour(anchor, start, end, front)
            && first_bend < self.first_inside()
        {
            let shadow = self.shadow(anchor, first_bend);
            let border = self.step(anchor, first_bend);
            let side = |point| shadow * cross(border, self.step(anchor, point));
            // On the border of the shadow the end's own anchor serves equally well, and it knows which
            // corners come next.
            let is_own = first_bend == end.anchor;
            if shadow != 0.0 && (is_own || side(end.point) > 0.0) {
                let of_x0 = side(x0);
                if of_x0 > 0.0 || of_x0 == 0.0 && !is_own {
                    return false;
                }
                if !winds {
                    return true;
                }
            }
        }
        // Times are compared last, since their rounding hides small detours.
        let is_hidden = is_shorter(self.way(end.point, start, anchor).time, end.time);
        !is_hidden || self.is_clear(x0, anchor)
    }

    /// Returns whether the straight line from a point to an anchor passes over floor only. The line is
    /// followed from one grid line to the next: from column to column if it passes more columns than rows,
    /// otherwise from row to row.
    fn is_clear(&self, x0: usize, anchor: usize) -> bool {
        let [rows, cols] = self.step(x0, anchor);
        let axis = |by_cols, step: R| match (by_cols, step > R::zero()) {
            (true, true) => 0,
            (false, false) => 2,
            (true, false) => 4,
            (false, true) => 6,
        };
        let by_cols = cols.abs() >= rows.abs();
        let [along, aside] = if by_cols { [cols, rows] } else { [rows, cols] };
        let (ahead, toward) = (axis(by_cols, along), axis(!by_cols, aside));
        let [lines, aside] = [along.abs(), aside.abs()];
        let is_left = toward == (ahead + 2) % 8;
        let blocked = |point: usize| self.blocked[usize::from(self.edges[point])];
        let beside = |to: usize| 1u8 << to | 1u8 << ((to + 7) % 8);
        let past = |point: usize, to: usize| self.around[to].from(point);

        // If the line runs along edges, the cell on at least one side of each edge must be present.
        if aside == R::zero() || aside == lines {
            let diagonal = if is_left { ahead + 1 } else { (ahead + 7) % 8 };
            let to = if aside == R::zero() { ahead } else { diagonal };
            let (mut point, mut left) = (x0, lines);
            while left > R::zero() && blocked(point) & beside(to) != beside(to) {
                (point, left) = (past(point, to), left - R::one());
            }
            return left <= R::zero();
        }

        // Otherwise the line must cross edges with cells on both sides, or pass through points.
        let eighth = if is_left { ahead } else { (ahead + 7) % 8 };
        let through_point = 1u8 << eighth | 1u8 << ((eighth + 4) % 8);
        let (mut point, mut beyond, mut left) = (x0, R::zero(), lines);
        while left > R::zero() {
            // `beyond` is the offset of the line from `point` on the next grid line, times the total number
            // of grid lines.
            beyond = beyond + aside * min(left, R::one());
            if beyond > lines && blocked(past(point, toward)) & beside(ahead) != 0 {
                return false;
            }
            if beyond >= lines {
                (point, beyond) = (past(point, toward), beyond - lines);
            }
            (point, left) = (past(point, ahead), left - R::one());
            let way = if beyond == R::zero() { through_point } else { beside(toward) };
            if left > R::zero() && blocked(point) & way != 0 {
                return false;
            }
        }
        true
    }
}
