//! Stores the wavefronts known at each point, with their arrival times.

use crate::copies::Copies;
use geosweep_surface::Real;

/// The label of points in no region: holes, and points that no source reaches.
pub const NO_REGION: u32 = u32::MAX;

/// The end of a list of arrivals. [`KnownFronts::label`] returns it for a point that has not been visited.
pub(super) const NONE: u32 = NO_REGION;
/// The flag of a label that is the index of a list of arrivals.
const LIST: u32 = 1 << 31;

/// The arrival of a wavefront at a point near a border between regions.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    label: u32,
    time: f64,
    /// The index of the next arrival at the same point.
    next: u32,
}

/// The wavefronts at all points of a bordered array. Points up to a certain rank have been visited. Copies of a point
/// share one entry.
pub(super) struct KnownFronts {
    copies: Copies,
    /// The arrival times of the map.
    times: Vec<f32>,
    /// The label of each point. With [`LIST`] set, it is the index of the first of the point's arrivals.
    /// The labels of points that have not been visited are guesses.
    labels: Vec<u32>,
    arrivals: Vec<Arrival>,
    /// The rank of the last visited point.
    now: u64,
}

impl KnownFronts {
    /// Starts with guessed labels at all points of a map.
    pub(super) fn guessed(copies: Copies, times: Vec<f32>, labels: Vec<u32>) -> Self {
        Self { copies, times, labels, arrivals: Vec::new(), now: 0 }
    }

    /// Moves on to the point with the rank `rank`. All points up to it count as visited.
    pub(super) fn advance(&mut self, rank: u64) {
        self.now = rank;
    }

    pub(super) fn copies(&self) -> &Copies {
        &self.copies
    }

    /// Returns the rank of a point in the order of arrival.
    pub(super) fn rank(&self, point: usize) -> u64 {
        self.copies.rank(&self.times, point)
    }

    /// Returns whether the map reaches a point.
    pub(super) fn is_reached(&self, point: usize) -> bool {
        self.times[point] < f32::FAR
    }

    /// Returns whether a point has not been visited yet.
    pub(super) fn is_ahead(&self, point: usize) -> bool {
        self.rank(point) > self.now
    }

    /// Returns whether a wavefront is known at a point that the map reaches.
    pub(super) fn is_visited(&self, point: usize) -> bool {
        self.label(point) != NONE && self.is_reached(point)
    }

    /// Returns the known label of a point. For a point that has not been visited, a label is known only if a
    /// source seeds it.
    pub(super) fn label(&self, point: usize) -> u32 {
        let label = self.guess(point);
        if label & LIST != 0 || !self.is_ahead(point) { label } else { NONE }
    }

    /// Returns the label of a point, which may be a guess.
    pub(super) fn guess(&self, point: usize) -> u32 {
        self.labels[self.copies.first(point)]
    }

    /// Sets the label of a point. The label may be [`NONE`].
    pub(super) fn set_label(&mut self, point: usize, label: u32) {
        self.labels[self.copies.first(point)] = label;
    }

    /// Returns the arrival time of a wavefront at a point, or [`Real::FAR`] if it is not known.
    pub(super) fn time(&self, point: usize, label: u32) -> f64 {
        let here = self.at(point).find(|(other, _)| *other == label);
        here.map_or(f64::FAR, |(_, time)| time)
    }

    /// Returns the wavefronts known at a point: their labels and arrival times.
    pub(super) fn at(&self, point: usize) -> impl Iterator<Item = (u32, f64)> {
        self.of_label(point, self.label(point))
    }

    /// Returns the wavefronts known at a point whose known label is `here`.
    pub(super) fn of_label(&self, point: usize, here: u32) -> impl Iterator<Item = (u32, f64)> {
        let several = here != NONE && here & LIST != 0;
        let single = (here & LIST == 0).then(|| (here, f64::from(self.times[point])));
        let mut next = if several { here & !LIST } else { NONE };
        let listed = std::iter::from_fn(move || {
            let Arrival { label, time, next: following } = *self.arrivals.get(next as usize)?;
            next = following;
            Some((label, time))
        });
        single.into_iter().chain(listed)
    }

    /// Adds a wavefront at a point, or makes its arrival earlier.
    pub(super) fn insert(&mut self, point: usize, label: u32, time: f64) {
        let point = self.copies.first(point);
        let here = self.labels[point];
        if here != NONE && here & LIST == 0 {
            self.labels[point] = NONE;
            self.insert(point, here, f64::from(self.times[point]));
        }
        let first = self.labels[point];
        let mut next = if first == NONE { NONE } else { first & !LIST };
        while let Some(arrival) = self.arrivals.get_mut(next as usize) {
            if arrival.label == label {
                arrival.time = arrival.time.min(time);
                return;
            }
            next = arrival.next;
        }
        let next = if first == NONE { NONE } else { first & !LIST };
        self.labels[point] = LIST | self.arrivals.len() as u32;
        self.arrivals.push(Arrival { label, time, next });
    }

    /// Returns the first wavefront at a point. Of wavefronts with equal times, that of the first source is
    /// returned.
    pub(super) fn first(&self, point: usize) -> (u32, f64) {
        let earlier = |a: (u32, f64), b: (u32, f64)| {
            if (b.1, b.0) < (a.1, a.0) { b } else { a }
        };
        self.at(point).reduce(earlier).unwrap_or((NO_REGION, f64::FAR))
    }

    /// Returns the label of a point, which is that of the first wavefront.
    pub(super) fn first_label(&self, point: usize) -> u32 {
        let here = self.guess(point);
        if here != NONE && has_several(here) { self.first(point).0 } else { here }
    }
}

/// Returns whether a label stands for a list of wavefronts, or for none.
pub(super) fn has_several(label: u32) -> bool {
    label & LIST != 0
}
