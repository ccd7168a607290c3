//! Searches for the next line of a path among all straight lines across a cell.

use std::cmp::Reverse;
use std::collections::hash_map::Entry;
use std::collections::{BinaryHeap, HashMap};

use glam::DVec2;

use super::cell::{ALONG, CellLengths, NO_EDGE, SIDES, Weights, corner_alone};
use super::edge_times::EdgeTimes;
use super::goals::NearestSource;
use super::place::Place;
use super::slowed_edge::SlowedEdge;
use super::tracer::Tracer;
use geosweep_surface::{Chart, Direction, EdgeSlot, FAR};

/// A straight line of a path across a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellLine {
    /// The copy of the path's place at which the line starts. It is `None` if the line starts at the place
    /// itself.
    pub copy: Option<Place>,
    pub end: End,
    /// The arrival time at the end of the line.
    pub time: f64,
    pub length: f64,
    /// The cell that the line crosses, or `usize::MAX` if the line ends at a source.
    pub cell: usize,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum End {
    Place(Place),
    Source {
        source: usize,
        at: DVec2,
        /// The row and column of this place on the source that the caller gave. On a seam, `at` may be a copy
        /// of it.
        own: DVec2,
    },
}

impl CellLine {
    pub(super) fn arrival(&self) -> f64 {
        self.time + self.length
    }

    /// Returns whether this line is better than `other`, both starting at a place with the arrival time
    /// `time`.
    ///
    /// The earlier line is better if both descend or neither does. Otherwise the descending line is better.
    /// Near a point that is later than its surroundings, a line to the other side of that point does not
    /// descend. It can be so short that its arrival is earlier than that of a descending line. If such lines
    /// were taken, the path would go back and forth.
    fn is_better(&self, other: &Self, time: f64) -> bool {
        let falls = |line: &Self| falls(line.time, line.length, time);
        match (falls(self), falls(other)) {
            (a, b) if a != b => a,
            _ => self.arrival() < other.arrival(),
        }
    }

    /// Returns whether this line arrives so much earlier than a straight line to a source in sight that it is
    /// preferred.
    fn beats_sight_of(&self, source: &Self) -> bool {
        source.time + (1.0 - FITS) * source.length > self.arrival()
    }

    /// Returns whether the line arrives no later than the map's value. Then no other line can be much better.
    fn fits(&self, time: f64) -> bool {
        fits(self.time, self.length, time)
    }
}

/// Returns whether the time decreases by at least [`LEAST_FALL`] of its length along a line, from `time` to `end`.
fn falls(end: f64, length: f64, time: f64) -> bool {
    time - end >= LEAST_FALL * length - ROUNDING * time.abs()
}

/// Returns whether a line of the given length, which ends at the time `end`, fits the arrival time `time` at
/// its start.
#[inline(always)]
pub(super) fn fits(end: f64, length: f64, time: f64) -> bool {
    end + length <= time + FITS * length + ROUNDING * time.abs()
}

/// The largest distance from a grid point, as a fraction of the edge's length, at which the end of a line is
/// moved to that grid point.
pub(super) const AT_POINT: f64 = geosweep_surface::constants::AT_POINT;
/// The fraction of its length by which a straight line to a visible source is preferred to other lines. If a
/// line fits the arrival time within this fraction, the cell on the other side of the edge is not searched.
const FITS: f64 = geosweep_surface::constants::FITS;
/// The rounding of a map to single precision, as a fraction of the arrival time. For short lines the rounding
/// is larger than the tolerances that are fractions of the line's length ([`FITS`] and [`LEAST_FALL`]).
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;
/// The fraction of its length by which a line must decrease the time to count as descending.
const LEAST_FALL: f64 = geosweep_surface::constants::LEAST_FALL;
/// The smallest value of 16 times the squared area of a triangle, as a fraction of the fourth power of its
/// base.
const FLAT: f64 = 1e-14;

/// The distance, in rows and columns, up to which a map over a slowness holds the times along straight lines from a
/// source inside a cell.
const BESIDE_SOURCE: usize = 2;

impl Tracer<'_> {
    /// Returns the straight line across a cell on which the wavefront arrives first and which ends at a time below
    /// `below`. A source in sight and a line that descends are preferred to a line that is merely earlier. If the
    /// path comes from the cell `from`, the cell on the other side of the edge is tried first. `zero_time` is the
    /// time that is subtracted before times are squared.
    ///
    /// On a seam the line may cross a cell beside a copy of the place.
    pub(super) fn line(
        &self,
        zero_time: f64,
        place: Place,
        below: f64,
        from: usize,
    ) -> Option<CellLine> {
        let own = self.line_from(zero_time, place, below, from);
        if self.seams.is_none() {
            return own;
        }
        let copies = self.seams.others(self.chart(), place).into_iter().filter_map(|copy| {
            let line = self.line_from(zero_time, copy, below, from)?;
            Some(CellLine { copy: Some(copy), ..line })
        });
        own.into_iter().chain(copies).reduce(|best, line| match (best.end, line.end) {
            // A source in sight is preferred here too, as among the lines from a single place in `line_from`.
            (End::Source { .. }, End::Place(_)) if !line.beats_sight_of(&best) => best,
            (End::Place(_), End::Source { .. }) if !best.beats_sight_of(&line) => line,
            _ if line.is_better(&best, below) => line,
            _ => best,
        })
    }

    /// Returns the best line from a place across one of the cells that contain the place.
    fn line_from(&self, zero_time: f64, place: Place, below: f64, from: usize) -> Option<CellLine> {
        let (mut cells, count) = place.cells(self.chart());
        if cells[0].0 == from {
            cells[..count].rotate_left(1);
        }
        let (mut best, mut source): (Option<CellLine>, Option<NearestSource>) = (None, None);
        for (north_west, weights) in &cells[..count] {
            let cell = CellLengths::new(self.edges, *north_west);
            self.cross(zero_time, *north_west, &cell, weights, below, &mut best);
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
        if self.edges.slowness().is_some() && source.is_none() {
            source = self.source_beside(place);
        }
        let line = |NearestSource { source, at, own, time, distance }| CellLine {
            copy: None,
            end: End::Source { source, at, own },
            time,
            length: distance,
            cell: usize::MAX,
        };
        let in_sight = source.map(line).filter(|line| match best {
            Some(best) => !best.beats_sight_of(line),
            None => line.time <= below + ROUNDING * below.abs(),
        });
        in_sight.or(best)
    }

    /// Returns the point source some cells away from which a straight line arrives first. Maps over a slowness hold the
    /// times along such lines, which the times between their points do not show.
    fn source_beside(&self, place: Place) -> Option<NearestSource> {
        let (chart, at) = (self.chart(), self.at(place));
        let around = chart.around_place(at, BESIDE_SOURCE);
        let cells = around.rows.flat_map(|row| around.cols.clone().map(move |col| (row, col)));
        let points = cells.flat_map(|(row, col)| self.goals.points(chart.bordered(row, col)));
        points
            .filter_map(|source| {
                Some(NearestSource { distance: self.straight(at, source.at)?, ..source })
            })
            .min_by(|a, b| (a.time + a.distance).total_cmp(&(b.time + b.distance)))
    }

    /// Searches one cell for a line better than `best`.
    fn cross(
        &self,
        zero_time: f64,
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
            let line =
                CellLine { copy: None, end: End::Place(end), time, length, cell: north_west };
            let better = best.is_none_or(|best| line.is_better(&best, below));
            if better && time < below {
                *best = Some(line);
            }
        };
        for (side, along) in SIDES.into_iter().zip(ALONG) {
            let [a, b] = side;
            // Skips the edge on which the place lies, and edges that end at the place.
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
            // The place lies on this side up to rounding.
            let is_beside =
                is_flat && support > 2 && length > 0.0 && ends[0].max(ends[1]) < NO_EDGE;
            if reached[a] && reached[b] && (is_beside || !is_flat) {
                let slowness = cell.slowness(weights, side);
                let along_side = slowness.map_or(length, |[_, s, t]| length * 0.5 * (s + t));
                let times = EdgeTimes::new(
                    zero_time,
                    self.times_along(points),
                    self.ratios_along(points),
                    along_side,
                );
                let crossing = match slowness {
                    Some(slowness) => SlowedEdge::new(&times, slowness, ends, length).crossing(),
                    None if is_beside => times.foot(ends),
                    None => times.crossing(ends),
                };
                let end = usize::from(crossing.share > 0.5);
                let away = (crossing.share - end as f64).abs();
                // The end of a line is not moved to a nearby grid point that is later than the start of the line, or
                // lies beside the course of a line that is itself short.
                let at_end = cell.cost(ends[end], weights, &corner_alone(side[end]));
                let (time, length) = (self.time(points[end]), at_end);
                let leads_on = || time < below && falls(time, length, below);
                if away == 0.0 || away < AT_POINT && leads_on() {
                    offer(Place::Point(points[end]), time, length);
                } else {
                    let place = Place::Edge { first: points[0], along, share: crossing.share };
                    offer(place, crossing.time, crossing.distance);
                }
                continue;
            }
            // Without a triangle, paths run along edges.
            for (end, corner) in side.into_iter().enumerate() {
                let along = support == 1 || weights[corner] > 0.0 || support > 2;
                if reached[corner] && along && ends[end] < NO_EDGE {
                    let length = cell.cost(ends[end], weights, &corner_alone(corner));
                    offer(Place::Point(points[end]), self.time(points[end]), length);
                }
            }
        }
    }

    /// Returns a path along edges from a point to a point whose arrival time is below `below`.
    ///
    /// The path avoids late points as far as possible. Such a path is needed to cross points that coincide,
    /// as at a pole, and to leave local minima that rounding produces between long triangles.
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
                let slot = EdgeSlot::of(self.chart(), to);
                let is_edge = f64::from(self.edges.at(point, slot)) < 0.5 * FAR;
                if is_edge && self.is_reached(there) && !back.contains_key(&there) {
                    back.insert(there, point);
                    open.push(Reverse((self.times[there].to_bits(), there)));
                }
            }
            for copy in self.seams.copies(point) {
                if let Entry::Vacant(unseen) = back.entry(copy) {
                    unseen.insert(point);
                    open.push(Reverse((self.times[copy].to_bits(), copy)));
                }
            }
        }
        None
    }
}

/// Returns whether a place and an edge span a triangle. `ends` are the squared distances from the place to
/// the ends of the edge, and `base` is the squared length of the edge.
#[inline(always)]
pub(super) fn is_triangle(ends: [f64; 2], base: f64) -> bool {
    let skew = ends[1] - ends[0] - base;
    (ends[0].max(ends[1]) < NO_EDGE) & (4.0 * ends[0] * base - skew * skew > FLAT * base * base)
}
