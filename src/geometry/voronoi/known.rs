//! Which fronts are known at each point, and when they arrive there.

use super::NO_REGION;
use crate::geometry::order::rank;
use crate::surface::Real;

/// No further front, and the label of a point that has not been visited.
pub(super) const NONE: u32 = NO_REGION;
/// Set in the label of a point that several fronts reach.
const SEVERAL: u32 = 1 << 31;

/// A front that reaches a point near a border.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    label: u32,
    time: f64,
    /// The next one at the same point.
    next: u32,
}

/// The fronts at all points of a bordered array, of which those up to some rank have been visited.
pub(super) struct KnownFronts {
    /// The map's.
    times: Vec<f32>,
    /// The label of each point, or with [`SEVERAL`] the first of its arrivals. Those of points that
    /// are yet to come are guesses.
    labels: Vec<u32>,
    arrivals: Vec<Arrival>,
    /// The rank of the last point that need not be visited any more.
    now: u64,
}

impl KnownFronts {
    /// Guesses alone, at these points of a map.
    pub(super) fn guessed(times: Vec<f32>, labels: Vec<u32>) -> Self {
        Self { times, labels, arrivals: Vec::new(), now: 0 }
    }

    /// Comes to the next point: those up to it have been visited.
    pub(super) fn advance(&mut self, rank: u64) {
        self.now = rank;
    }

    /// Where a point comes among all.
    pub(super) fn rank(&self, point: usize) -> u64 {
        rank(self.times[point], point)
    }

    /// Whether the map reaches a point.
    pub(super) fn is_reached(&self, point: usize) -> bool {
        self.times[point] < f32::FAR
    }

    /// Whether a point is yet to come.
    pub(super) fn is_ahead(&self, point: usize) -> bool {
        self.rank(point) > self.now
    }

    /// Whether a front is known at a point that the map reaches.
    pub(super) fn is_visited(&self, point: usize) -> bool {
        self.label(point) != NONE && self.is_reached(point)
    }

    /// What is known of a point's label: of those yet to come only that sources seed them.
    pub(super) fn label(&self, point: usize) -> u32 {
        let label = self.labels[point];
        if label & SEVERAL != 0 || !self.is_ahead(point) { label } else { NONE }
    }

    /// The same, guesses included.
    pub(super) fn guess(&self, point: usize) -> u32 {
        self.labels[point]
    }

    /// Gives a point a label, which may be [`NONE`].
    pub(super) fn set_label(&mut self, point: usize, label: u32) {
        self.labels[point] = label;
    }

    /// When a front arrives at a point, [`Real::FAR`] if that is not known.
    pub(super) fn time(&self, point: usize, label: u32) -> f64 {
        let here = self.at(point).find(|(other, _)| *other == label);
        here.map_or(f64::FAR, |(_, time)| time)
    }

    /// The fronts known at a point: their labels and arrival times.
    pub(super) fn at(&self, point: usize) -> impl Iterator<Item = (u32, f64)> {
        self.of_label(point, self.label(point))
    }

    /// The same, given what is known of the point's label.
    pub(super) fn of_label(&self, point: usize, here: u32) -> impl Iterator<Item = (u32, f64)> {
        let several = here != NONE && here & SEVERAL != 0;
        let single = (here & SEVERAL == 0).then(|| (here, f64::from(self.times[point])));
        let mut next = if several { here & !SEVERAL } else { NONE };
        let listed = std::iter::from_fn(move || {
            let Arrival { label, time, next: following } = *self.arrivals.get(next as usize)?;
            next = following;
            Some((label, time))
        });
        single.into_iter().chain(listed)
    }

    /// Adds a front to those at a point, or makes it earlier.
    pub(super) fn insert(&mut self, point: usize, label: u32, time: f64) {
        let here = self.labels[point];
        if here != NONE && here & SEVERAL == 0 {
            self.labels[point] = NONE;
            self.insert(point, here, f64::from(self.times[point]));
        }
        let first = self.labels[point];
        let mut next = if first == NONE { NONE } else { first & !SEVERAL };
        while let Some(arrival) = self.arrivals.get_mut(next as usize) {
            if arrival.label == label {
                arrival.time = arrival.time.min(time);
                return;
            }
            next = arrival.next;
        }
        let next = if first == NONE { NONE } else { first & !SEVERAL };
        self.labels[point] = SEVERAL | self.arrivals.len() as u32;
        self.arrivals.push(Arrival { label, time, next });
    }

    /// The first front at a point, of equally early ones that of the first source.
    pub(super) fn first(&self, point: usize) -> (u32, f64) {
        let earlier = |a: (u32, f64), b: (u32, f64)| {
            if (b.1, b.0) < (a.1, a.0) { b } else { a }
        };
        self.at(point).reduce(earlier).unwrap_or((NO_REGION, f64::FAR))
    }

    /// The label of a point, of several that of the first front.
    pub(super) fn first_label(&self, point: usize) -> u32 {
        let here = self.labels[point];
        if here != NONE && has_several(here) { self.first(point).0 } else { here }
    }
}

/// Whether a label stands for a list of fronts, or for none.
pub(super) fn has_several(label: u32) -> bool {
    label & SEVERAL != 0
}
