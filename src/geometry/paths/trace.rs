//! From cell to cell down the arrival times.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::DVec2;

use super::ahead::Entry;
use super::cell::{Cell, SIDES, Weights};
use super::corners::Corners;
use super::goals::{Goals, Nearest};
use super::profile::Profile;
use super::rests::Rests;
use crate::surface::{Chart, Direction, EdgeLengths, EdgeSlot, FAR, corner_weights};

/// What a tracer knows.
#[derive(Clone, Debug)]
pub(super) struct Field<'a> {
    pub edges: &'a EdgeLengths<f32>,
    /// Arrival times in a bordered array, infinite where no front arrives.
    pub times: Vec<f32>,
    /// The smallest initial value.
    pub start: f64,
    pub goals: Goals,
    pub corners: Corners,
    /// Whether paths are made shorter than the map alone has them.
    pub shortens: bool,
    pub rests: Rests,
}

/// A path's trace: its vertices from the start to the source.
pub(super) struct Trace {
    pub vertices: Vec<DVec2>,
    /// Arrival time at its start.
    pub time: f64,
    pub length: f64,
    pub source: usize,
    /// The source's initial value.
    pub initial: f64,
}

/// Where a path cannot go on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stuck(pub DVec2);

/// Where a path is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    /// At a point of the bordered array.
    Point(usize),
    /// On the edge to the next point or to the next row's, at a share of its length.
    Edge { first: usize, step: usize, share: f64 },
    /// In a cell.
    Inside { north_west: usize, weights: Weights },
}

/// One straight line of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub end: End,
    /// Arrival time at its end.
    pub time: f64,
    pub length: f64,
    /// The cell that it crosses.
    pub cell: usize,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum End {
    Place(Place),
    Source(usize, DVec2),
}

impl Line {
    pub(super) fn arrival(&self) -> f64 {
        self.time + self.length
    }

    /// Whether it is better than another one from where the front arrives at a time: earlier, if
    /// both or neither of them fall. One that does not, to the other side of a point that is later
    /// than its surroundings, may be so short that it is hardly late, and leads to and fro.
    fn is_better(&self, other: &Self, time: f64) -> bool {
        let falls =
            |line: &Self| time - line.time >= LEAST_FALL * line.length - ROUNDING * time.abs();
        match (falls(self), falls(other)) {
            (a, b) if a != b => a,
            _ => self.arrival() < other.arrival(),
        }
    }

    /// Whether it arrives no later than the map says, so that no other can be much better.
    fn fits(&self, time: f64) -> bool {
        fits(self.time, self.length, time)
    }
}

/// The same for a line of a length that ends at a time.
#[inline(always)]
pub(super) fn fits(end: f64, length: f64, time: f64) -> bool {
    end + length <= time + FITS * length + ROUNDING * time.abs()
}

/// A line that ends nearer than this to a grid point, in shares of the edge, ends there.
pub(super) const AT_POINT: f64 = crate::constants::AT_POINT;
/// A straight line to the source in sight is preferred to others by this part of its length; and a
/// line that fits the arrival time as well needs no other to be compared with.
const FITS: f64 = crate::constants::FITS;
/// Maps are rounded to single precision, which over short lines is more than that part of them:
/// such a part of the arrival time.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;
/// A line falls if it does so by this part of its length.
const LEAST_FALL: f64 = crate::constants::LEAST_FALL;
/// Squares of lengths of edges that do not exist are larger.
const NO_EDGE: f64 = FAR * FAR * 1e-20;
/// Areas whose square is a smaller part of the fourth power of a side are no triangles.
const FLAT: f64 = 1e-14;

impl Field<'_> {
    pub(super) fn chart(&self) -> Chart {
        self.edges.chart()
    }

    pub(super) fn time(&self, point: usize) -> f64 {
        self.times[point].into()
    }

    pub(super) fn is_reached(&self, point: usize) -> bool {
        self.times[point] < f32::INFINITY
    }

    /// Whether the surface is there and a front arrives; rows and columns inside the grid.
    pub(super) fn reaches(&self, at: DVec2) -> bool {
        self.place(at).is_some()
    }

    /// The place at a row and column, if it has been reached.
    pub(super) fn place(&self, at: DVec2) -> Option<Place> {
        let (row, col) = (at.x as usize, at.y as usize);
        let (v, u) = (at.x.fract(), at.y.fract());
        let north_west = self.chart().bordered(row, col);
        let reached = |point: usize| self.is_reached(point).then_some(point);
        let edge = |step, share| {
            let first = reached(north_west)?;
            reached(north_west + step)?;
            Some(Place::Edge { first, step, share })
        };
        match (v > 0.0, u > 0.0) {
            (false, false) => Some(Place::Point(reached(north_west)?)),
            (false, true) => edge(1, u),
            (true, false) => edge(self.chart().stride(), v),
            (true, true) => {
                let corners = super::cell::corners(self.chart(), north_west);
                let weights = corner_weights(corners.map(|c| self.is_reached(c)), v, u)?;
                Some(Place::Inside { north_west, weights })
            }
        }
    }

    pub(super) fn position(&self, place: Place) -> DVec2 {
        let at = |point: usize| {
            let stride = self.chart().stride();
            DVec2::new((point / stride) as f64 - 1.0, (point % stride) as f64 - 1.0)
        };
        match place {
            Place::Point(point) => at(point),
            Place::Edge { first, step: 1, share } => at(first) + DVec2::new(0.0, share),
            Place::Edge { first, share, .. } => at(first) + DVec2::new(share, 0.0),
            Place::Inside { north_west, weights: [_, ne, sw, se] } => {
                at(north_west) + DVec2::new(sw + se, ne + se)
            }
        }
    }

    /// The cells that a place lies in, and its weights there.
    fn cells(&self, place: Place) -> ([(usize, Weights); 4], usize) {
        let stride = self.chart().stride();
        let none = (0, [0.0; 4]);
        match place {
            Place::Point(point) => {
                let cells = [
                    (point, [1.0, 0.0, 0.0, 0.0]),
                    (point - 1, [0.0, 1.0, 0.0, 0.0]),
                    (point - stride, [0.0, 0.0, 1.0, 0.0]),
                    (point - stride - 1, [0.0, 0.0, 0.0, 1.0]),
                ];
                (cells, 4)
            }
            Place::Edge { first, step: 1, share } => {
                let rest = 1.0 - share;
                let (south, north) = ([rest, share, 0.0, 0.0], [0.0, 0.0, rest, share]);
                ([(first, south), (first - stride, north), none, none], 2)
            }
            Place::Edge { first, share, .. } => {
                let rest = 1.0 - share;
                let (east, west) = ([rest, 0.0, share, 0.0], [0.0, rest, 0.0, share]);
                ([(first, east), (first - 1, west), none, none], 2)
            }
            Place::Inside { north_west, weights } => ([(north_west, weights), none, none, none], 1),
        }
    }

    /// The reached corners of the cells that a place lies in, and how far they are.
    pub(super) fn corners(&self, place: Place) -> impl Iterator<Item = (usize, f64)> {
        let (cells, count) = self.cells(place);
        cells.into_iter().take(count).flat_map(|(north_west, weights)| {
            let cell = Cell::new(self.edges, north_west);
            let squares = cell.from(&weights);
            (0..4)
                .map(move |corner| (cell.corners[corner], squares[corner]))
                .filter(|&(corner, square)| self.is_reached(corner) && square < NO_EDGE)
                .map(|(corner, square)| (corner, square.max(0.0).sqrt()))
        })
    }

    /// The cell that a path from a cell enters over an edge, and where.
    pub(super) fn entry(&self, place: Place, from: usize) -> Option<Entry> {
        let Place::Edge { first, step, share } = place else { return None };
        let (before, sides) = if step == 1 { (self.chart().stride(), [0, 3]) } else { (1, [1, 2]) };
        let (north_west, side) =
            if first == from { (first - before, sides[1]) } else { (first, sides[0]) };
        let corner = self.position(Place::Point(north_west));
        Some(Entry { north_west, corner, side, share })
    }

    /// The straight line across a cell, ending lower than `below`, on which the front arrives
    /// first; the cell beside the one the path comes `from` is tried first.
    pub(super) fn line(&self, moment: f64, place: Place, below: f64, from: usize) -> Option<Line> {
        let (mut cells, count) = self.cells(place);
        if cells[0].0 == from {
            cells[..count].rotate_left(1);
        }
        let (mut best, mut source): (Option<Line>, Option<Nearest>) = (None, None);
        for (north_west, weights) in &cells[..count] {
            let cell = Cell::new(self.edges, *north_west);
            self.cross(moment, *north_west, &cell, weights, below, &mut best);
            let nearest = self.goals.nearest(*north_west, &cell, weights);
            source = match (source, nearest) {
                (Some(a), Some(b)) if a.time + a.distance <= b.time + b.distance => Some(a),
                (a, b) => b.or(a),
            };
            let fits = best.is_some_and(|line| below < f64::INFINITY && line.fits(below));
            if count == 2 && fits && source.is_none() {
                break;
            }
        }
        let line = |Nearest { source, at, time, distance }| Line {
            end: End::Source(source, at),
            time,
            length: distance,
            cell: usize::MAX,
        };
        let in_sight = source.map(line).filter(|line| match best {
            Some(best) => line.time + (1.0 - FITS) * line.length <= best.arrival(),
            None => line.time <= below,
        });
        in_sight.or(best)
    }

    /// Looks for a better line through a cell.
    fn cross(
        &self,
        moment: f64,
        north_west: usize,
        cell: &Cell,
        weights: &Weights,
        below: f64,
        best: &mut Option<Line>,
    ) {
        let squares = cell.from(weights);
        let reached = cell.corners.map(|corner| self.is_reached(corner));
        let support = weights.iter().filter(|weight| **weight > 0.0).count();
        let mut offer = |end: Place, time: f64, length: f64| {
            let line = Line { end: End::Place(end), time, length, cell: north_west };
            let better = best.is_none_or(|best| line.is_better(&best, below));
            if better && time < below {
                *best = Some(line);
            }
        };
        for side in SIDES {
            let [a, b] = side;
            // The place's own edge, or an edge that ends there.
            let own = weights[a] + weights[b];
            let is_own = match support {
                1 => own > 0.0,
                2 => own >= 1.0,
                _ => false,
            };
            if is_own {
                continue;
            }
            let points = side.map(|corner| cell.corners[corner]);
            let (ends, length) = (side.map(|corner| squares[corner]), cell.length(side));
            let is_flat = !is_triangle(ends, length * length);
            // A start that lies on a side as far as one can tell.
            let is_beside =
                is_flat && support > 2 && length > 0.0 && ends[0].max(ends[1]) < NO_EDGE;
            if reached[a] && reached[b] && (is_beside || !is_flat) {
                let profile = Profile::new(moment, self.times_along(points), length);
                let crossing = if is_beside { profile.foot(ends) } else { profile.crossing(ends) };
                let end = usize::from(crossing.share > 0.5);
                let away = (crossing.share - end as f64).abs();
                // A line past a point later than its own start does not end there.
                let at_point = away == 0.0 || away < AT_POINT && self.time(points[end]) < below;
                if at_point {
                    let length = ends[end].max(0.0).sqrt();
                    offer(Place::Point(points[end]), self.time(points[end]), length);
                } else {
                    let step = points[1] - points[0];
                    let place = Place::Edge { first: points[0], step, share: crossing.share };
                    offer(place, crossing.time, crossing.distance);
                }
                continue;
            }
            // Without a triangle paths run along edges.
            for (end, corner) in side.into_iter().enumerate() {
                let along = support == 1 || weights[corner] > 0.0 || support > 2;
                if reached[corner] && along && ends[end] < NO_EDGE {
                    let length = ends[end].max(0.0).sqrt();
                    offer(Place::Point(points[end]), self.time(points[end]), length);
                }
            }
        }
    }

    /// The arrival times at the ends of an edge and at the points next to them in its line.
    #[inline]
    pub(super) fn times_along(&self, [first, last]: [usize; 2]) -> [f64; 4] {
        let step = last - first;
        [first - step, first, last, last + step].map(|point| self.time(point))
    }

    pub(super) fn length(&self, a: usize, b: usize) -> f64 {
        let to = Direction::ALL
            .into_iter()
            .find(|&to| a.wrapping_add_signed(self.chart().offset(to)) == b)
            .expect("the points are neighbours");
        self.edges.at(a, EdgeSlot::new(self.chart(), 0, to)).into()
    }

    /// The earliest of a place's own grid points.
    pub(super) fn lower_end(&self, place: Place) -> usize {
        let (cells, _) = self.cells(place);
        let (north_west, weights) = cells[0];
        let corners = super::cell::corners(self.chart(), north_west);
        let own = corners.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
        own.map(|(corner, _)| corner)
            .min_by(|&a, &b| self.times[a].total_cmp(&self.times[b]))
            .expect("a place has weights")
    }

    /// The way along edges from a point to one where the front has arrived earlier than `below`,
    /// or that has a source beside it, over no later points than needed: across points that
    /// coincide, as at a pole, and out of pits that rounding leaves between long triangles.
    pub(super) fn detour(&self, from: usize, below: f64) -> Option<Vec<usize>> {
        let Chart { rows, cols } = self.chart();
        let mut back = HashMap::from([(from, from)]);
        let mut open = BinaryHeap::from([Reverse((self.times[from].to_bits(), from))]);
        for _ in 0..8 * (rows + cols) + 64 {
            let Reverse((_, point)) = open.pop()?;
            if self.time(point) < below {
                let mut way = vec![point];
                while let Some(&before) = way.last().and_then(|point| back.get(point)) {
                    if Some(&before) == way.last() {
                        break;
                    }
                    way.push(before);
                }
                way.reverse();
                return Some(way);
            }
            for to in Direction::ALL {
                let there = point.wrapping_add_signed(self.chart().offset(to));
                let slot = EdgeSlot::new(self.chart(), 0, to);
                let is_edge = f64::from(self.edges.at(point, slot)) < 0.5 * FAR;
                if is_edge && self.is_reached(there) && !back.contains_key(&there) {
                    back.insert(there, point);
                    open.push(Reverse((self.times[there].to_bits(), there)));
                }
            }
        }
        None
    }
}

/// Whether a place and an edge, both given by squared lengths, span a triangle.
#[inline(always)]
pub(super) fn is_triangle(ends: [f64; 2], base: f64) -> bool {
    let skew = ends[1] - ends[0] - base;
    (ends[0].max(ends[1]) < NO_EDGE) & (4.0 * ends[0] * base - skew * skew > FLAT * base * base)
}
