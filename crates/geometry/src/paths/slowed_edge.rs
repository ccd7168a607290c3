//! Finds the straight line to an edge that arrives first over a slowness.

use super::edge_times::{Crossing, EdgeTimes};

/// The side of a cell, seen from a place in the cell, over a slowness that is linear along the side.
pub(super) struct SlowedEdge<'a> {
    times: &'a EdgeTimes,
    /// The slowness at the place and at both ends of the side.
    slowness: [f64; 3],
    /// The squared distances on the surface from the place to both ends, and the side's squared length.
    ends: [f64; 2],
    square: f64,
}

/// Number of parts in which the first arrival is searched: where fronts meet or the slowness jumps, there may be several
/// minima.
const PARTS: usize = 8;

/// Number of steps by the golden section. They leave 1e-5 of a part.
const STEPS: usize = 24;

impl<'a> SlowedEdge<'a> {
    pub(super) fn new(
        times: &'a EdgeTimes,
        slowness: [f64; 3],
        ends: [f64; 2],
        length: f64,
    ) -> Self {
        Self { times, slowness, ends, square: length * length }
    }

    /// Returns the crossing from which the wavefront arrives first at the place.
    pub(super) fn crossing(&self) -> Crossing {
        let part = 1.0 / PARTS as f64;
        let sum = |share: f64| {
            let Crossing { time, distance, .. } = self.at(share);
            time + distance
        };
        let shares = (0..=PARTS).map(|k| part * k as f64);
        let first = shares.min_by(|&a, &b| sum(a).total_cmp(&sum(b))).unwrap_or(0.0);
        let (mut low, mut high) = ((first - part).max(0.0), (first + part).min(1.0));
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let inner =
            |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
        let [mut a, mut b] = inner(low, high);
        let [mut of_a, mut of_b] = [sum(a), sum(b)];
        for _ in 0..STEPS {
            if of_a <= of_b {
                (high, b, of_b) = (b, a, of_a);
                a = inner(low, high)[0];
                of_a = sum(a);
            } else {
                (low, a, of_a) = (a, b, of_b);
                b = inner(low, high)[1];
                of_b = sum(b);
            }
        }
        let share = if of_a <= of_b { a } else { b };
        // An end of the search is exact.
        let best = if sum(first) <= sum(share) { first } else { share };
        self.at(best)
    }

    /// Returns the line to a place of the side. Along the side, the time changes as the slowness adds up, which is exact
    /// for a front that runs along it.
    fn at(&self, share: f64) -> Crossing {
        let [own, first, last] = self.slowness;
        let there = first + share * (last - first);
        let mean = 0.5 * (first + last);
        let passed = if mean > 0.0 { 0.5 * share * (first + there) / mean } else { share };
        let [to_first, to_last] = self.ends;
        let square = to_first + share * (to_last - to_first - (1.0 - share) * self.square);
        let distance = square.max(0.0).sqrt() * 0.5 * (own + there);
        Crossing { share, time: self.times.time(passed), distance }
    }
}
