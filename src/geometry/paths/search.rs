//! The next line of a path, looked for among all straight lines across a cell.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::DVec2;

use super::cell::{ALONG, CellLengths, NO_EDGE, SIDES, Weights};
use super::edge_times::EdgeTimes;
use super::goals::NearestSource;
use super::place::Place;
use super::tracer::Tracer;
use crate::surface::{Chart, Direction, EdgeSlot, FAR};

/// One straight line of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellLine {
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

impl CellLine {
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
/// Areas whose square is a smaller part of the fourth power of a side are no triangles.
const FLAT: f64 = 1e-14;

impl Tracer<'_> {
    /// The straight line across a cell, ending lower than `below`, on which the front arrives
    /// first; the cell beside the one the path comes `from` is tried first.
    pub(super) fn line(
        &self,
        moment: f64,
        place: Place,
        below: f64,
        from: usize,
    ) -> Option<CellLine> {
        let (mut cells, count) = place.cells(self.chart());
        if cells[0].0 == from {
            cells[..count].rotate_left(1);
        }
        let (mut best, mut source): (Option<CellLine>, Option<NearestSource>) = (None, None);
        for (north_west, weights) in &cells[..count] {
            let cell = CellLengths::new(self.edges, *north_west);
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
        let line = |NearestSource { source, at, time, distance }| CellLine {
            end: End::Source(source, at),
            time,
            length: distance,
            cell: usize::MAX,
        };
        let in_sight = source.map(line).filter(|line| match best {
            Some(best) => line.time + (1.0 - FITS) * line.length <= best.arrival(),
            None => line.time <= below + ROUNDING * below.abs(),
        });
        in_sight.or(best)
    }

    /// Looks for a better line through a cell.
    fn cross(
        &self,
        moment: f64,
        north_west: usize,
        cell: &CellLengths,
        weights: &Weights,
        below: f64,
        best: &mut Option<CellLine>,
    ) {
        let squares = cell.from(weights);
        let reached = cell.corners.map(|corner| self.is_reached(corner));
        let support = weights.iter().filter(|weight| **weight > 0.0).count();
        let mut offer = |end: Place, time: f64, length: f64| {
            let line = CellLine { end: End::Place(end), time, length, cell: north_west };
            let better = best.is_none_or(|best| line.is_better(&best, below));
            if better && time < below {
                *best = Some(line);
            }
        };
        for (side, along) in SIDES.into_iter().zip(ALONG) {
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
                let times = EdgeTimes::new(moment, self.times_along(points), length);
                let crossing = if is_beside { times.foot(ends) } else { times.crossing(ends) };
                let end = usize::from(crossing.share > 0.5);
                let away = (crossing.share - end as f64).abs();
                // A line past a point later than its own start does not end there.
                let at_point = away == 0.0 || away < AT_POINT && self.time(points[end]) < below;
                if at_point {
                    let length = ends[end].max(0.0).sqrt();
                    offer(Place::Point(points[end]), self.time(points[end]), length);
                } else {
                    let place = Place::Edge { first: points[0], along, share: crossing.share };
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
                let there = self.chart().beside(point, to);
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
