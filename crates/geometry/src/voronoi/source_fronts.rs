//! Determines the source whose wavefront reaches a point first, and the arrival times of later wavefronts.
//!
//! Labels copied from neighbour to neighbour drift along the grid's directions where a border runs almost
//! parallel to the characteristics, as behind a close pair of sources. The converged map itself mixes both
//! wavefronts there, since updates at the border use points on either side. So near borders each source's
//! wavefront is propagated separately, across the border and beyond it, until it arrives later than the first
//! wavefront by the length of two edges. Both ends of an edge that crosses the border then know both
//! wavefronts. Elsewhere a point has the label of all its earlier neighbours, and the time of the map.
//!
//! Points are visited in the order of their arrival times. Points whose guessed label agrees with the labels
//! of all their earlier neighbours need no visit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::continuation::Continuation;
use super::guess::Guess;
use super::known::{KnownFronts, NONE, has_several};
use super::starts::{first_labels, starts};
use crate::MapError;
use crate::copies::Copies;
use crate::neighbourhood::Neighbourhood;
use geosweep_surface::{
    Chart, EdgeLengths, PartsAround, Real, Sources, SplitPart, Surface, max, min, ring,
};

/// A wavefront that may reach a point.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    label: u32,
    /// The arrival time at the point, or [`Real::FAR`] as long as it is not known.
    time: f64,
    /// The times since the wavefront's start, at the point's neighbours.
    since: [f64; 8],
    /// The set of neighbours that the wavefront has reached, one bit each. `last` is the latest of their
    /// times.
    known: u8,
    last: f64,
}

/// The wavefronts at all points of a bordered array, while they are propagated.
pub(super) struct SourceFronts<'a> {
    continuation: Continuation<'a>,
    known: KnownFronts,
    /// The ranks of points to visit that are known from the start, the earliest last. `queue` holds the ranks
    /// of points added later, and `is_queued` tells which points are in either.
    ahead: Vec<u64>,
    queue: BinaryHeap<Reverse<u64>>,
    is_queued: Vec<bool>,
    /// The point and label of arrivals that have not been passed on to the neighbours yet.
    news: Vec<(u32, u32)>,
    /// Reused memory for the candidates of a point.
    room: Vec<Candidate>,
}

impl<'a> SourceFronts<'a> {
    pub(super) fn new(
        surface: &Surface,
        edges: &'a EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, MapError> {
        let mut fronts = Self::before(surface, edges, sources, distances)?;
        fronts.follow();
        Ok(fronts)
    }

    /// Starts from guesses, and queues all points at which the guess is uncertain.
    fn before(
        surface: &Surface,
        edges: &'a EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, MapError> {
        let (copies, times) = Copies::with_times(edges, distances)?;
        let neighbourhood = Neighbourhood::new(edges);
        let starts = starts(edges.chart(), &copies, surface, sources)?;
        let parts = PartsAround::of(edges);
        let continuation = Continuation::new(neighbourhood, parts, sources);
        let guess = Guess::new(&continuation, &copies, &times, &first_labels(&starts));
        let mut known = KnownFronts::guessed(copies, times, guess.labels);
        starts.iter().for_each(|start| known.set_label(start.point, NONE));
        starts.iter().for_each(|start| known.insert(start.point, start.label, start.time));
        let ranks = guess.doubtful.par_iter().map(|&point| known.rank(point as usize));
        let mut ahead: Vec<u64> = ranks.collect();
        ahead.par_sort_unstable_by(|a, b| b.cmp(a));
        ahead.dedup();
        let mut is_queued = vec![false; edges.chart().bordered_points()];
        guess.doubtful.into_iter().for_each(|point| is_queued[point as usize] = true);
        Ok(Self {
            continuation,
            known,
            ahead,
            queue: BinaryHeap::new(),
            is_queued,
            news: Vec::new(),
            room: Vec::new(),
        })
    }

    /// Visits all queued points, including those queued by the visits.
    fn follow(&mut self) {
        while let Some(rank) = self.next() {
            self.known.advance(rank);
            let point = (rank & u64::from(u32::MAX)) as usize;
            let guess = self.known.guess(point);
            let is_seed = has_several(guess);
            if !is_seed {
                self.known.set_label(point, NONE);
            }
            self.visit(point);
            if is_seed || self.known.guess(point) != guess {
                self.enqueue_after(point);
            }
        }
        self.known.advance(u64::MAX);
        self.label_the_rest();
    }

    /// Gives reached points that no wavefront has arrived at the label of their earliest neighbour. There are such points
    /// where a map has not converged, and where seeds are earlier than all points around them.
    fn label_the_rest(&mut self) {
        let is_left = |fronts: &Self, point: &usize| {
            fronts.known.is_reached(*point) && fronts.known.label(*point) == NONE
        };
        let points = 0..self.chart().bordered_points();
        let mut left: Vec<_> = points.filter(|point| is_left(self, point)).collect();
        while !left.is_empty() {
            let labelled = |&point: &usize| {
                let has_edge = |&to: &usize| self.neighbourhood().length(point, to) < f64::FAR;
                let around =
                    (0..8).filter(has_edge).map(|to| self.neighbourhood().neighbour(point, to));
                let around = around.filter(|&other| self.known.is_visited(other));
                let earliest = around.min_by_key(|&other| self.known.rank(other))?;
                Some((point, self.known.first_label(earliest)))
            };
            let found: Vec<_> = left.iter().filter_map(labelled).collect();
            if found.is_empty() {
                break;
            }
            found.into_iter().for_each(|(point, label)| self.known.set_label(point, label));
            left.retain(|point| is_left(self, point));
        }
    }

    /// Takes the earliest queued point.
    fn next(&mut self) -> Option<u64> {
        match (self.ahead.last(), self.queue.peek()) {
            (Some(known), Some(Reverse(other))) if known < other => self.ahead.pop(),
            (Some(_), None) => self.ahead.pop(),
            _ => self.queue.pop().map(|Reverse(rank)| rank),
        }
    }

    fn neighbourhood(&self) -> &Neighbourhood<'a> {
        self.continuation.neighbourhood()
    }

    fn enqueue(&mut self, point: usize) {
        if !self.is_queued[point] {
            self.is_queued[point] = true;
            self.queue.push(Reverse(self.known.rank(point)));
        }
    }

    /// Queues the later neighbours of a point whose guessed label was wrong.
    fn enqueue_after(&mut self, point: usize) {
        let mut copies = 0;
        while let Some(copy) = self.known.copies().nth(point, copies) {
            copies += 1;
            for to in 0..8 {
                let neighbour = self.neighbourhood().neighbour(copy, to);
                if self.known.is_ahead(neighbour) && self.known.is_reached(neighbour) {
                    self.enqueue(self.known.copies().first(neighbour));
                }
            }
            let seen: Vec<_> = self.continuation.parts_beside(copy).map(|(x0, _)| x0).collect();
            for x0 in seen {
                if self.known.is_ahead(x0) && self.known.is_reached(x0) {
                    self.enqueue(self.known.copies().first(x0));
                }
            }
        }
    }

    /// Labels a point whose earlier neighbours have all been visited.
    fn visit(&mut self, point: usize) {
        if self.known.copies().has(point) {
            return self.visit_copies(point);
        }
        let lengths = self.lengths(point);
        let (mut found, visited, is_alone) = self.candidates(point, &lengths);
        if let [single] = &found[..]
            && is_alone
        {
            self.known.set_label(point, single.label);
            self.room = found;
            return;
        }
        self.arrive(point, &mut found, &lengths);
        self.settle(point, &mut found);
        for front in &found {
            // Neighbours that the wavefront has reached before it arrives here need no notice of it.
            let since = self.continuation.since(front.label, front.time);
            if front.known != visited || since < front.last {
                self.news.push((point as u32, front.label));
            }
        }
        self.room = found;
        self.tell_all();
    }

    /// Labels a point of a seam. Fronts may arrive at any of its copies.
    fn visit_copies(&mut self, point: usize) {
        let (mut all, mut copies): (Vec<Candidate>, usize) = (Vec::new(), 0);
        while let Some(copy) = self.known.copies().nth(point, copies) {
            copies += 1;
            let lengths = self.lengths(copy);
            let (mut found, ..) = self.candidates(copy, &lengths);
            self.arrive(copy, &mut found, &lengths);
            for front in found.drain(..) {
                match all.iter_mut().find(|known| known.label == front.label) {
                    Some(known) => known.time = min(known.time, front.time),
                    None => all.push(front),
                }
            }
            self.room = found;
        }
        self.settle(point, &mut all);
        self.news.extend(all.iter().map(|front| (point as u32, front.label)));
        self.tell_all();
    }

    fn lengths(&self, point: usize) -> [f64; 8] {
        std::array::from_fn(|to| self.neighbourhood().length(point, to))
    }

    /// Returns the length of the longest edge of a point and its copies.
    fn longest(&self, point: usize) -> f64 {
        let longest = |copy| f64::from(self.neighbourhood().longest(copy));
        self.known.copies().all(point).map(longest).fold(0.0, max)
    }

    /// Computes the arrival times of candidates at a point.
    fn arrive(&self, point: usize, found: &mut [Candidate], lengths: &[f64; 8]) {
        for Candidate { label, since, time, .. } in found {
            *time = min(*time, self.continuation.arrival(point, *label, since, lengths));
            for part in self.continuation.parts_behind(point) {
                *time = min(*time, self.arrival_over(&part, *label));
            }
        }
    }

    /// Returns the arrival time of a wavefront through a part of an obtuse triangle.
    fn arrival_over(&self, part: &SplitPart<f32>, label: u32) -> f64 {
        let times = part.corners.map(|corner| self.known.time(corner, label));
        self.continuation.arrival_over(label, part, times)
    }

    /// Removes the candidates that arrive too late to count at a point, and stores the others.
    fn settle(&mut self, point: usize, found: &mut Vec<Candidate>) {
        if found.len() > 1 {
            let first = found.iter().map(|candidate| candidate.time).fold(f64::FAR, min);
            let latest = latest(first, self.longest(point));
            found.retain(|candidate| candidate.time <= latest);
        }
        found.retain(|candidate| candidate.time < f64::FAR);
        match &found[..] {
            [] => {}
            [single] => self.known.set_label(point, single.label),
            several => {
                self.known.set_label(point, NONE);
                let known = &mut self.known;
                several.iter().for_each(|front| known.insert(point, front.label, front.time));
            }
        }
    }

    /// Passes all new arrivals on to the neighbours.
    fn tell_all(&mut self) {
        while let Some((point, label)) = self.news.pop() {
            let (mut copies, point) = (0, point as usize);
            while let Some(copy) = self.known.copies().nth(point, copies) {
                copies += 1;
                self.tell(copy, label);
            }
        }
    }

    /// Returns all wavefronts that reach a point's neighbours or start beside it. Also returns the neighbours that have
    /// any, and whether each of them has a single wavefront and none starts at the point.
    fn candidates(&mut self, point: usize, lengths: &[f64; 8]) -> (Vec<Candidate>, u8, bool) {
        let mut found = std::mem::take(&mut self.room);
        found.clear();
        let fresh =
            |(label, time)| Candidate { label, time, since: [f64::FAR; 8], known: 0, last: 0.0 };
        found.extend(self.known.at(point).map(fresh));
        let (mut visited, mut is_alone) = (0, found.is_empty());
        for (to, &length) in lengths.iter().enumerate() {
            let neighbour = self.neighbourhood().neighbour(point, to);
            let label = self.known.label(neighbour);
            if label == NONE || length >= f64::FAR {
                continue;
            }
            visited |= 1 << to;
            is_alone &= !has_several(label);
            for (label, time) in self.known.of_label(neighbour, label) {
                let place = found.iter().position(|candidate| candidate.label == label);
                let place = place.unwrap_or_else(|| {
                    found.push(fresh((label, f64::FAR)));
                    found.len() - 1
                });
                let since = self.continuation.since(label, time);
                let candidate = &mut found[place];
                candidate.since[to] = since;
                candidate.known |= 1 << to;
                candidate.last = max(candidate.last, since);
            }
        }
        for corner in self.continuation.parts_behind(point).flat_map(|part| part.corners) {
            let label = self.known.label(corner);
            is_alone &= label == NONE || !has_several(label);
            for (label, _) in self.known.at(corner) {
                if found.iter().all(|candidate| candidate.label != label) {
                    found.push(fresh((label, f64::FAR)));
                }
            }
        }
        (found, visited, is_alone)
    }

    /// Passes a wavefront that has reached a point on to the neighbours.
    fn tell(&mut self, point: usize, label: u32) {
        let time = self.known.time(point, label);
        for to in 0..8 {
            let neighbour = self.neighbourhood().neighbour(point, to);
            if !self.known.is_visited(neighbour)
                || self.neighbourhood().length(point, to) >= f64::FAR
            {
                continue;
            }
            let before = self.known.time(neighbour, label);
            if time >= before {
                continue;
            }
            let (_, first) = self.known.first(neighbour);
            let latest = latest(first, self.longest(neighbour));
            if time >= latest {
                continue;
            }
            // The wavefront arrives through the two triangles on either side of the edge between the two
            // points.
            let back = ring::opposite(to);
            let mut since = [f64::FAR; 8];
            for to in [ring::previous(back), back, ring::next(back)] {
                let time = self.known.time(self.neighbourhood().neighbour(neighbour, to), label);
                since[to] = self.continuation.since(label, time);
            }
            let now = min(latest, before);
            let arrival = self.continuation.arrival_beside(neighbour, label, back, &since, now);
            self.hear(neighbour, label, arrival.unwrap_or(f64::FAR));
        }
        let beside: Vec<_> = self.continuation.parts_beside(point).collect();
        for (x0, part) in beside {
            if self.known.is_visited(x0) {
                self.hear(x0, label, self.arrival_over(&part, label));
            }
        }
    }

    /// Stores the later arrival of a wavefront at a visited point, if it counts there, and passes it on.
    fn hear(&mut self, point: usize, label: u32, arrival: f64) {
        let before = self.known.time(point, label);
        if arrival >= before * (1.0 - 1e-9) {
            return;
        }
        let (_, first) = self.known.first(point);
        if arrival <= latest(first, self.longest(point)) {
            self.known.insert(point, label, arrival);
            self.enqueue_after(point);
            self.news.push((point as u32, label));
        }
    }

    /// Returns the label of each grid point, row-major.
    pub(super) fn labels(&self) -> Vec<u32> {
        let chart = self.chart();
        let mut labels = vec![NONE; chart.points()];
        labels.par_chunks_mut(chart.cols).enumerate().for_each(|(row, labels)| {
            let first = chart.bordered(row, 0);
            labels
                .iter_mut()
                .zip(first..)
                .for_each(|(found, point)| *found = self.known.first_label(point));
        });
        labels
    }

    fn chart(&self) -> Chart {
        self.neighbourhood().chart()
    }

    /// Returns the time at which a wavefront arrives at a grid point, if the wavefront is known there.
    pub(super) fn time(&self, index: usize, label: u32) -> Option<f64> {
        let time = self.known.time(self.chart().bordered_point(index), label);
        (time < f64::FAR).then_some(time)
    }
}

/// Returns the time up to which wavefronts count at a point, from the first arrival and the length of the
/// longest edge.
///
/// The wavefronts of two regions must be known at both ends of an edge between the regions. At the end in the
/// other region, a wavefront arrives later than that region's own wavefront by at most twice the length of
/// the edge.
fn latest(first: f64, longest: f64) -> f64 {
    first + 2.0 * longest * (1.0 + 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_cpu::raster_scan;
    use geosweep_surface::Source;
    use geosweep_surface::Spacing;
    use geosweep_surface::Stop;
    use geosweep_surface::update::Wavefront;

    /// All fronts are the same, whether points are skipped or not.
    #[test]
    fn points_that_are_not_visited_are_guessed_right() {
        let (rows, cols) = (60, 75);
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for (roughness, beside) in [(0.0, 6.0), (0.0, 1.0), (0.3, 2.0), (2.0, 6.0)] {
            let heights = (0..rows * cols).map(|_| roughness * random()).collect();
            let mask: Vec<bool> = (0..rows * cols).map(|_| random() < 0.95).collect();
            let spacing = Spacing { dx: 1.0, dy: 1.3 };
            let surface = Surface::from_heights(rows, cols, heights, spacing).unwrap();
            let surface = surface.with_mask(&mask).unwrap();
            let there: Vec<usize> = (0..rows * cols).filter(|&index| mask[index]).collect();
            let edges = EdgeLengths::new(&surface).unwrap();
            for count in [1, 2, 9] {
                let mut place = || {
                    let index = there[(random() * there.len() as f64) as usize];
                    let (row, col) = surface.chart().position(index);
                    Source::Point { at: [row as f64, col as f64].into(), initial: -0.5 }
                };
                let mut sources: Vec<Source> = (0..count).map(|_| place()).collect();
                // A second source is close to another one, so that their fronts run side by side.
                if let Source::Point { at, initial } = sources[0].clone() {
                    let at = [at.x, (at.y - beside).max(0.0)];
                    if mask[surface.chart().index(at[0] as usize, at[1] as usize)] {
                        sources.push(Source::Point { at: at.into(), initial: initial + 0.1 });
                    }
                }
                let sources = Sources::from_iter(sources);
                let seeds = sources.seeds(&surface).unwrap();
                let stop = Stop::within(0.0).or_after(1000);
                let map = raster_scan(&edges, &seeds, Wavefront::Circular, stop).distances();
                let [few, all] = [false, true].map(|everywhere| {
                    let mut fronts =
                        SourceFronts::before(&surface, &edges, &sources, &map).unwrap();
                    if everywhere {
                        let reached = |&point: &usize| fronts.known.is_reached(point);
                        let points = 0..fronts.is_queued.len();
                        let all: Vec<usize> = points.filter(reached).collect();
                        all.into_iter().for_each(|point| fronts.enqueue(point));
                    }
                    fronts.follow();
                    fronts
                });
                let visits =
                    |fronts: &SourceFronts| fronts.is_queued.iter().filter(|&&q| q).count();
                // In the closest pairs, no source is late enough for any of its points to be skipped.
                assert!(visits(&few) < visits(&all) || roughness > 0.0 || beside == 1.0);
                for point in 0..few.is_queued.len() {
                    let mut found = [&few, &all].map(|f| f.known.at(point).collect::<Vec<_>>());
                    found.iter_mut().for_each(|found| found.sort_by_key(|(label, _)| *label));
                    assert_eq!(found[0], found[1], "{roughness} {count} {point}");
                }
            }
        }
    }
}
