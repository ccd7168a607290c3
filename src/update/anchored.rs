//! Fronts that know their anchor: exact over floor plans.
//!
//! A shortest path over a flat grid with holes is a chain of straight lines that bends only at corners of
//! holes. Its last bend, or its source, is the *anchor* of what follows (the pseudosource of exact
//! polyhedral methods; Mitchell, Mount and Papadimitriou, "The discrete geodesic problem", 1987): a point's
//! distance is its anchor's and that of the straight line from there. So no front has to be assumed inside
//! a triangle: a point takes the nearest of the anchors of two neighbours, and of these anchors' own, that
//! it can be reached from through the triangle. All that is asked of them is on which side of a line a
//! grid point lies, in whole numbers.
//!
//! What no neighbour knows of is missed: among holes of single points a corner often lights less than a
//! cell for long, and there distances can be too long.
//!
//! The twin of `glsl/anchored.glsl`.

use glam::DVec2;

use crate::constants::{ALIKE, ALIKE_AT_ANCHOR, GENERATIONS};
use crate::surface::{Direction, EdgeLengths, EdgeSlot, Real, Seed, is_corner};

/// A source inside a cell: its row and column, from the border, and its time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inside<R> {
    pub place: DVec2,
    pub time: R,
}

/// A floor plan as the update sees it: a flat, evenly spaced grid with holes.
///
/// Anchors are numbered: first the points of a bordered array, then sources inside cells.
#[derive(Clone, Debug)]
pub(crate) struct Floor<'a, R> {
    edges: &'a EdgeLengths<R>,
    stride: usize,
    points: usize,
    /// Where the eight neighbours lie, and the edges to them.
    around: [(isize, EdgeSlot); 8],
    /// The metric: of rows, of both, of columns.
    metric: [R; 3],
    inside: Vec<Inside<R>>,
}

/// How a point is reached: when, from which anchor, and when that was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Way<R> {
    pub time: R,
    pub anchor: usize,
    start: R,
}

impl<R: Real> Way<R> {
    /// Not at all.
    pub(crate) const NONE: Self = Self { time: R::FAR, anchor: 0, start: R::FAR };

    /// The shorter of two ways; of two that are as long, on one line, that from the corner passed last.
    fn or(self, other: Self) -> Self {
        let as_long = !is_shorter(self.time, other.time) && !is_shorter(other.time, self.time);
        let second = if as_long { other.start > self.start } else { other.time < self.time };
        if second { other } else { self }
    }
}

/// Whether one time is earlier than another by more than rounding.
#[inline(always)]
pub(crate) fn is_shorter<R: Real>(a: R, b: R) -> bool {
    a < b * R::of(1.0 - ALIKE * R::epsilon().wide())
}

/// Where a front comes from: its anchor's time, row and column.
pub(crate) struct From<R> {
    start: R,
    place: Step<R>,
}

impl<R: Real> From<R> {
    /// Its time, and the rows and columns to it.
    pub(crate) fn seen_from(self, [row, col]: [usize; 2]) -> [R; 3] {
        let [to_row, to_col] = self.place;
        [self.start, to_row - R::of(row as f64), to_col - R::of(col as f64)]
    }
}

/// A neighbour that has been reached.
#[derive(Clone, Copy)]
struct End<R> {
    point: usize,
    time: R,
    anchor: usize,
    /// When the anchor was reached.
    start: R,
}

/// Rows and columns from one place to another.
type Step<R> = [R; 2];

/// Twice the area between two steps; its sign says on which side of one the other is.
fn cross<R: Real>(a: Step<R>, b: Step<R>) -> f64 {
    a[0].wide() * b[1].wide() - a[1].wide() * b[0].wide()
}

fn dot<R: Real>(a: Step<R>, b: Step<R>) -> f64 {
    a[0].wide() * b[0].wide() + a[1].wide() * b[1].wide()
}

impl<'a, R: Real> Floor<'a, R> {
    /// If the edges are those of one.
    pub(crate) fn of(edges: &'a EdgeLengths<R>) -> Option<Self> {
        let (chart, grid) = (edges.chart(), edges.floor()?);
        Some(Self {
            edges,
            stride: chart.stride(),
            points: chart.bordered_points(),
            around: Direction::ALL.map(|to| (chart.offset(to), EdgeSlot::new(chart, 0, to))),
            metric: grid.metric().map(R::of),
            inside: Vec::new(),
        })
    }

    /// The number of the anchor of a seed, among those of other seeds.
    pub(crate) fn seed(&mut self, seed: &Seed) -> R {
        let own = self.edges.chart().bordered(seed.row, seed.col);
        let Some(from) = seed.from else { return R::of_number(own) };
        let place = from + DVec2::ONE;
        let ahead = self.length(self.step_to(own, [R::of(place.x), R::of(place.y)]));
        let time = R::of(seed.time) - ahead;
        let near = |known: &Inside<R>| {
            known.place == place
                && (known.time - time).abs()
                    <= R::of(ALIKE_AT_ANCHOR) * R::epsilon() * ahead.max(R::of(seed.time).abs())
        };
        let number = match self.inside.iter().position(near) {
            Some(known) => known,
            None => {
                self.inside.push(Inside { place, time });
                self.inside.len() - 1
            }
        };
        R::of_number(self.points + number)
    }

    /// Forgets the sources inside cells.
    pub(crate) fn forget(&mut self) {
        self.inside.clear();
    }

    /// The neighbour of a point in one of the eight directions.
    pub(crate) fn neighbour(&self, point: usize, to: usize) -> Option<usize> {
        let (offset, edge) = self.around[to];
        (self.edges.at(point, edge) < R::FAR).then(|| point.wrapping_add_signed(offset))
    }

    /// Whether paths can bend at a point.
    pub(crate) fn is_corner(&self, point: usize) -> bool {
        let there: [bool; 8] = std::array::from_fn(|to| self.neighbour(point, to).is_some());
        // Most points have all their edges, which is found sooner.
        there.contains(&false) && is_corner(there)
    }

    /// Row and column, from the border: whole numbers, but for sources.
    fn place(&self, anchor: usize) -> Step<R> {
        match anchor.checked_sub(self.points) {
            Some(source) => {
                let place = self.inside[source].place;
                [R::of(place.x), R::of(place.y)]
            }
            None => [anchor / self.stride, anchor % self.stride].map(|line| R::of(line as f64)),
        }
    }

    fn step(&self, from: usize, to: usize) -> Step<R> {
        self.step_to(from, self.place(to))
    }

    fn step_to(&self, from: usize, to: [R; 2]) -> Step<R> {
        let from = self.place(from);
        [to[0] - from[0], to[1] - from[1]]
    }

    /// Length of a straight line.
    #[inline(always)]
    pub(crate) fn length(&self, step: Step<R>) -> R {
        let ([rr, rc, cc], [row, col]) = (self.metric, step);
        (row * (rr * row + (rc + rc) * col) + cc * col * col).sqrt()
    }

    /// Where the front at a point comes from that has been reached.
    pub(crate) fn anchor_of(&self, point: usize, front: impl Fn(usize) -> [R; 2]) -> From<R> {
        let end = self.end_at(point, &front);
        From { start: end.start, place: self.place(end.anchor) }
    }

    /// When an anchor was reached, and from which; nothing if it has not been.
    fn of_anchor(&self, anchor: usize, front: &impl Fn(usize) -> [R; 2]) -> Option<(R, usize)> {
        if let Some(source) = anchor.checked_sub(self.points) {
            return Some((self.inside[source].time, anchor));
        }
        let [time, code] = front(anchor);
        (time < R::FAR).then(|| (time, code.number()))
    }

    /// The anchor of an anchor, and when it was reached; a source has none.
    fn before(&self, anchor: usize, front: &impl Fn(usize) -> [R; 2]) -> Option<(R, usize)> {
        let (_, before) = self.of_anchor(anchor, front).filter(|&(_, before)| before != anchor)?;
        Some((self.of_anchor(before, front)?.0, before))
    }

    /// The way to a point from an anchor that was reached at some time.
    pub(crate) fn way(&self, x0: usize, start: R, anchor: usize) -> Way<R> {
        Way { time: start + self.length(self.step(x0, anchor)), anchor, start }
    }

    /// The neighbour of a point in some direction, if it has been reached.
    ///
    /// Its anchor's time is the one that is known there, to which what follows from the neighbour is rounded;
    /// but the latter where the two differ, since a change must come from the neighbours.
    fn end(&self, x0: usize, to: usize, front: &impl Fn(usize) -> [R; 2]) -> Option<End<R>> {
        let point = self.neighbour(x0, to)?;
        // A front that its scan has taken back has no anchor.
        (front(point)[0] < R::FAR).then(|| self.end_at(point, front))
    }

    fn end_at(&self, point: usize, front: &impl Fn(usize) -> [R; 2]) -> End<R> {
        let [time, code] = front(point);
        let anchor = code.number();
        let follows = time - self.length(self.step(point, anchor));
        let rounding = R::of(ALIKE_AT_ANCHOR) * R::epsilon() * time;
        let known = self.of_anchor(anchor, front).map(|(known, _)| known);
        let start = known.filter(|&known| (known - follows).abs() <= rounding).unwrap_or(follows);
        End { point, time, anchor, start }
    }

    /// The shortest way to a point past three neighbours that follow one another, in directions
    /// `middle - 1` to `middle + 1`, with the fronts at points of the grid (time and
    /// [number](Real::number) of the anchor) seen through `front`.
    pub(crate) fn reach(
        &self,
        x0: usize,
        middle: usize,
        front: impl Fn(usize) -> [R; 2],
    ) -> Way<R> {
        let ends = [7, 0, 1].map(|turn| self.end(x0, (middle + turn) % 8, &front));
        let through = |a: usize, b: usize| match [ends[a], ends[b]] {
            [Some(a), Some(b)] => self.through(x0, [a, b], &front),
            _ => Way::NONE,
        };
        let along = ends.into_iter().flatten().map(|end| self.along(x0, end));
        along.fold(through(0, 1).or(through(1, 2)), Way::or)
    }

    /// The way along an edge: from its end, if that is a corner, or straight on.
    fn along(&self, x0: usize, end: End<R>) -> Way<R> {
        if self.is_corner(end.point) {
            return self.way(x0, end.time, end.point);
        }
        let (edge, ray) = (self.step(x0, end.point), self.step(x0, end.anchor));
        let goes_on = cross(edge, ray) == 0.0 && dot(edge, ray) >= dot(edge, edge);
        if goes_on { self.way(x0, end.start, end.anchor) } else { Way::NONE }
    }

    /// The shortest straight way through a triangle, from an anchor of its ends or from these' own.
    fn through(&self, x0: usize, ends: [End<R>; 2], front: &impl Fn(usize) -> [R; 2]) -> Way<R> {
        let [e1, e2] = ends.map(|end| self.step(x0, end.point));
        let turn = cross(e1, e2);
        let mut best = Way::NONE;
        for end in ends {
            let (mut start, mut anchor) = (end.start, end.anchor);
            for _ in 0..=GENERATIONS {
                let ray = self.step(x0, anchor);
                let [a, b] = [cross(ray, e2) * turn, cross(e1, ray) * turn];
                let beyond_base = a >= 0.0 && b >= 0.0 && a + b >= turn * turn;
                let way = self.way(x0, start, anchor);
                if beyond_base && ends.iter().all(|end| self.sees(x0, way, end, front)) {
                    best = best.or(way);
                }
                let Some(before) = self.before(anchor, front) else { break };
                (start, anchor) = before;
            }
        }
        best
    }

    /// Whether x0 is out of the shadow that an end of its base lies in, as seen from an anchor. It lies in
    /// one if the straight line would have been shorter. The shadow's border runs through the first corner
    /// on the way from that anchor to the end.
    fn sees(&self, x0: usize, way: Way<R>, end: &End<R>, front: &impl Fn(usize) -> [R; 2]) -> bool {
        let Way { anchor, start, .. } = way;
        if end.anchor == anchor || !is_shorter(self.way(end.point, start, anchor).time, end.time) {
            return true;
        }
        let (mut corner, mut at) = (end.anchor, end.anchor);
        for _ in 0..=GENERATIONS {
            let Some((_, before)) = self.before(at, front) else { break };
            if before == anchor {
                corner = at;
                break;
            }
            at = before;
        }
        let border = self.step(anchor, corner);
        let [of_x0, of_end] = [x0, end.point].map(|point| cross(border, self.step(anchor, point)));
        // On the border the corner serves as well, and knows which corners come next.
        if corner != end.anchor { of_x0 * of_end < 0.0 } else { of_x0 * of_end <= 0.0 }
    }
}
