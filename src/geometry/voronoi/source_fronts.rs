//! Which source's front reaches a point first, and when the next ones do.
//!
//! Labels that are handed from neighbour to neighbour drift along the grid's directions where a
//! border runs almost along the fronts' way, as behind a close pair of sources; and a converged map
//! itself mixes both fronts there, since updates at the border start from points on either side.
//! So near borders each source's front is followed by itself, across the border and beyond it
//! until it is late by two edges: enough for both ends of an edge that crosses the border to know
//! both fronts. Elsewhere a point's label is that of all its earlier neighbours, and its time is
//! the map's.
//!
//! Points are visited in the order in which they are reached; but those whose label is a guess
//! that nothing before them contradicts need no visit.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::NO_REGION;
use super::guess::Guess;
use crate::cpu::{Visited, settled};
use crate::geometry::MapError;
use crate::geometry::order::{bordered, rank};
use crate::geometry::spokes::Spokes;
use crate::surface::{Chart, EdgeLengths, Real, Source, Sources, Surface, max, min, ring};
use crate::update::{Triangle, Wavefront, planar, point_source};

/// No further front, and the label of a point that has not been visited.
const NONE: u32 = NO_REGION;
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

/// A front that may reach a point.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    label: u32,
    /// When it does, as far as is known.
    time: f64,
    /// Since its start, at the point's neighbours.
    since: [f64; 8],
    /// Which of those it has reached, and the last of these times.
    known: u8,
    last: f64,
}

/// A front at a point that its source seeds.
struct Start {
    point: usize,
    label: u32,
    time: f64,
}

/// How the front of a source is continued.
#[derive(Clone, Copy, Debug)]
struct Origin {
    wavefront: Wavefront,
    initial: f64,
}

/// The fronts at all points of a bordered array.
pub(super) struct SourceFronts<'a> {
    spokes: Spokes<'a>,
    origins: Vec<Origin>,
    start: f64,
    /// The map's.
    times: Vec<f32>,
    /// The label of each point, or with [`SEVERAL`] the first of its arrivals. Those of points that
    /// are yet to come are guesses.
    labels: Vec<u32>,
    /// The rank of the last point that need not be visited any more.
    now: u64,
    /// The ranks of points to be visited: of those known to be from the first, the earliest last, and
    /// of others; and which they are.
    ahead: Vec<u64>,
    queue: BinaryHeap<Reverse<u64>>,
    is_queued: Vec<bool>,
    arrivals: Vec<Arrival>,
    /// SourceFronts whose arrival at a point its neighbours have yet to hear of.
    news: Vec<(u32, u32)>,
    /// Where the candidates of a point are gathered.
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

    /// With guesses alone, and all points to visit that they leave in doubt.
    fn before(
        surface: &Surface,
        edges: &'a EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, MapError> {
        let times = bordered(edges.chart(), distances)?;
        let spokes = Spokes::new(edges);
        let starts = starts(edges.chart(), surface, sources)?;
        let guess = Guess::new(&spokes, &times, &first_labels(&starts));
        let mut fronts = Self {
            spokes,
            origins: sources.iter().map(Origin::of).collect(),
            start: sources.start(),
            labels: guess.labels,
            now: 0,
            ahead: Vec::new(),
            queue: BinaryHeap::new(),
            is_queued: vec![false; times.len()],
            times,
            arrivals: Vec::new(),
            news: Vec::new(),
            room: Vec::new(),
        };
        starts.iter().for_each(|start| fronts.labels[start.point] = NONE);
        starts.iter().for_each(|start| fronts.insert(start.point, start.label, start.time));
        fronts.ahead =
            guess.doubtful.par_iter().map(|&point| fronts.rank(point as usize)).collect();
        fronts.ahead.par_sort_unstable_by(|a, b| b.cmp(a));
        fronts.ahead.dedup();
        guess.doubtful.into_iter().for_each(|point| fronts.is_queued[point as usize] = true);
        Ok(fronts)
    }

    /// Visits what is in the queue, and what that adds to it.
    fn follow(&mut self) {
        while let Some(rank) = self.next() {
            self.now = rank;
            let point = (rank & u64::from(u32::MAX)) as usize;
            let guess = self.labels[point];
            let is_seed = guess & SEVERAL != 0;
            if !is_seed {
                self.labels[point] = NONE;
            }
            self.visit(point);
            if is_seed || self.labels[point] != guess {
                self.enqueue_after(point);
            }
        }
        self.now = u64::MAX;
    }

    /// Takes the first point that is to be visited.
    fn next(&mut self) -> Option<u64> {
        match (self.ahead.last(), self.queue.peek()) {
            (Some(known), Some(Reverse(other))) if known < other => self.ahead.pop(),
            (Some(_), None) => self.ahead.pop(),
            _ => self.queue.pop().map(|Reverse(rank)| rank),
        }
    }

    fn rank(&self, point: usize) -> u64 {
        rank(self.times[point], point)
    }

    fn enqueue(&mut self, point: usize) {
        if !self.is_queued[point] {
            self.is_queued[point] = true;
            self.queue.push(Reverse(self.rank(point)));
        }
    }

    /// The neighbours that are yet to come of a point whose label was guessed wrong.
    fn enqueue_after(&mut self, point: usize) {
        for to in 0..8 {
            let neighbour = self.spokes.neighbour(point, to);
            if self.rank(neighbour) > self.now && self.times[neighbour] < f32::FAR {
                self.enqueue(neighbour);
            }
        }
    }

    /// What is known of a point's label: of those yet to come only that sources seed them.
    fn label(&self, point: usize) -> u32 {
        let label = self.labels[point];
        if label & SEVERAL != 0 || self.rank(point) <= self.now { label } else { NONE }
    }

    /// Labels a point whose earlier neighbours have all been visited.
    fn visit(&mut self, point: usize) {
        let lengths = std::array::from_fn(|to| self.spokes.length(point, to));
        let (mut found, visited, is_alone) = self.candidates(point, &lengths);
        if let [single] = &found[..]
            && is_alone
        {
            self.labels[point] = single.label;
            self.room = found;
            return;
        }
        for candidate in &mut found {
            let arrival = self.arrival(point, candidate, &lengths);
            candidate.time = min(candidate.time, arrival);
        }
        if found.len() > 1 {
            let first = found.iter().map(|candidate| candidate.time).fold(f64::FAR, min);
            let there = lengths.iter().copied().filter(|&length| length < f64::FAR);
            let latest = latest(first, there.fold(0.0, max));
            found.retain(|candidate| candidate.time <= latest);
        }
        found.retain(|candidate| candidate.time < f64::FAR);
        match &found[..] {
            [] => {}
            [single] => self.labels[point] = single.label,
            several => {
                self.labels[point] = NONE;
                several.iter().for_each(|front| self.insert(point, front.label, front.time));
            }
        }
        for front in &found {
            // Nobody has to be told who knows of a front before it comes here.
            if front.known != visited || self.since(front.label, front.time) < front.last {
                self.news.push((point as u32, front.label));
            }
        }
        self.room = found;
        while let Some((point, label)) = self.news.pop() {
            self.tell(point as usize, label);
        }
    }

    /// All fronts that a point's neighbours have, and those of sources beside it; which neighbours
    /// have any; and whether all have one alone.
    fn candidates(&mut self, point: usize, lengths: &[f64; 8]) -> (Vec<Candidate>, u8, bool) {
        let mut found = std::mem::take(&mut self.room);
        found.clear();
        let fresh =
            |(label, time)| Candidate { label, time, since: [f64::FAR; 8], known: 0, last: 0.0 };
        found.extend(self.arrivals_at(point).map(fresh));
        let (mut visited, mut is_alone) = (0, found.is_empty());
        for (to, &length) in lengths.iter().enumerate() {
            let neighbour = self.spokes.neighbour(point, to);
            let label = self.label(neighbour);
            if label == NONE || length >= f64::FAR {
                continue;
            }
            visited |= 1 << to;
            is_alone &= label & SEVERAL == 0;
            for (label, time) in self.arrivals_of(neighbour, label) {
                let place = found.iter().position(|candidate| candidate.label == label);
                let place = place.unwrap_or_else(|| {
                    found.push(fresh((label, f64::FAR)));
                    found.len() - 1
                });
                let since = self.since(label, time);
                let candidate = &mut found[place];
                candidate.since[to] = since;
                candidate.known |= 1 << to;
                candidate.last = max(candidate.last, since);
            }
        }
        (found, visited, is_alone)
    }

    /// From the start of a front to its arrival somewhere.
    fn since(&self, label: u32, time: f64) -> f64 {
        if time < f64::FAR {
            max(time - self.origins[label as usize].initial, 0.0)
        } else {
            f64::FAR
        }
    }

    /// Tells a point's neighbours of a front that has reached it.
    fn tell(&mut self, point: usize, label: u32) {
        let time = self.time(point, label);
        for to in 0..8 {
            let neighbour = self.spokes.neighbour(point, to);
            if !self.is_visited(neighbour) || self.spokes.length(point, to) >= f64::FAR {
                continue;
            }
            let before = self.time(neighbour, label);
            if time >= before {
                continue;
            }
            let (_, first) = self.first(neighbour);
            let latest = latest(first, f64::from(self.spokes.longest(neighbour)));
            if time >= latest {
                continue;
            }
            // Through the two triangles on either side of the edge between them.
            let back = ring::opposite(to);
            let [right, left] = [ring::previous(back), ring::next(back)];
            let mut since = [f64::FAR; 8];
            for to in [right, back, left] {
                let time = self.time(self.spokes.neighbour(neighbour, to), label);
                since[to] = self.since(label, time);
            }
            let length = |to: usize| self.spokes.length(neighbour, to);
            let triangles = [right, left].map(|side| {
                let ends = [back, side];
                self.triangle(neighbour, ends, &since, ends.map(length))
            });
            let Origin { wavefront, initial } = self.origins[label as usize];
            let now = min(latest, before) - initial;
            let settles = match wavefront {
                Wavefront::PointSource => settled::from_point_source,
                _ => settled::from_planar,
            };
            let visited = Visited { now, triangles };
            if visited.stays(triangles.map(|triangle| settles(triangle, now))) {
                continue;
            }
            let [left, right] = triangles.map(|triangle| self.through(label, triangle));
            let arrival = initial + min(left, right);
            if arrival <= latest && arrival < before * (1.0 - 1e-9) {
                self.insert(neighbour, label, arrival);
                self.enqueue_after(neighbour);
                self.news.push((neighbour as u32, label));
            }
        }
    }

    fn is_visited(&self, point: usize) -> bool {
        self.label(point) != NONE && self.times[point] < f32::FAR
    }

    /// When a front arrives at a point from its neighbours.
    fn arrival(&self, point: usize, front: &Candidate, lengths: &[f64; 8]) -> f64 {
        let (mut shortest, mut nearest) = (f64::FAR, 0);
        for (to, (since, length)) in front.since.iter().zip(lengths).enumerate() {
            let along = since + length;
            if along < shortest {
                (shortest, nearest) = (along, to);
            }
        }
        if shortest >= f64::FAR {
            return f64::FAR;
        }
        let through = |to: usize| {
            let ends = [to, ring::next(to)];
            let triangle = self.triangle(point, ends, &front.since, ends.map(|to| lengths[to]));
            self.through(front.label, triangle)
        };
        // Nearly always beside the neighbour over which the way along an edge is shortest, and on
        // the side where the next one is shorter.
        let [right, left] = [ring::previous(nearest), ring::next(nearest)];
        let [to_right, to_left] = [right, left].map(|to| front.since[to] + lengths[to]);
        let beside = if to_right < to_left { [right, nearest] } else { [nearest, right] };
        let found = beside.into_iter().map(through).find(|&time| time < shortest);
        let first = found.unwrap_or_else(|| (0..8).map(through).fold(shortest, min));
        self.origins[front.label as usize].initial + first
    }

    /// The triangle of a point with two neighbours, one beside the other.
    #[inline(always)]
    fn triangle(
        &self,
        point: usize,
        ends: [usize; 2],
        since: &[f64; 8],
        [l1, l2]: [f64; 2],
    ) -> Triangle<f64> {
        let [t1, t2] = ends.map(|to| since[to]);
        let first = if ring::next(ends[0]) == ends[1] { ends[0] } else { ends[1] };
        Triangle { t1, t2, l1, l2, c: self.spokes.base(point, first) }
    }

    /// The time since a front's start at which it arrives through a triangle.
    #[inline(always)]
    fn through(&self, label: u32, triangle: Triangle<f64>) -> f64 {
        let Triangle { t1, t2, l1, l2, .. } = triangle;
        if max(t1, t2) >= f64::FAR {
            return min(t1 + l1, t2 + l2);
        }
        match self.origins[label as usize].wavefront {
            Wavefront::PointSource => point_source(triangle),
            _ => planar(triangle),
        }
    }

    /// When a front arrives at a point, [`Real::FAR`] if that is not known.
    fn time(&self, point: usize, label: u32) -> f64 {
        let here = self.arrivals_at(point).find(|(other, _)| *other == label);
        here.map_or(f64::FAR, |(_, time)| time)
    }

    /// The fronts known at a point.
    fn arrivals_at(&self, point: usize) -> impl Iterator<Item = (u32, f64)> {
        self.arrivals_of(point, self.label(point))
    }

    /// The fronts known at a point, given what is known of its label.
    fn arrivals_of(&self, point: usize, here: u32) -> impl Iterator<Item = (u32, f64)> {
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
    fn insert(&mut self, point: usize, label: u32, time: f64) {
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
    fn first(&self, point: usize) -> (u32, f64) {
        let earlier = |a: (u32, f64), b: (u32, f64)| {
            if (b.1, b.0) < (a.1, a.0) { b } else { a }
        };
        self.arrivals_at(point).reduce(earlier).unwrap_or((NO_REGION, f64::FAR))
    }

    /// The label of each grid point, row-major.
    pub(super) fn labels(&self) -> Vec<u32> {
        let chart = self.chart();
        let label = |point: usize| {
            let several = self.labels[point] != NONE && self.labels[point] & SEVERAL != 0;
            if several { self.first(point).0 } else { self.labels[point] }
        };
        let mut labels = vec![NONE; chart.points()];
        labels.par_chunks_mut(chart.cols).enumerate().for_each(|(row, labels)| {
            let first = chart.bordered(row, 0);
            labels.iter_mut().zip(first..).for_each(|(found, point)| *found = label(point));
        });
        labels
    }

    pub(super) fn chart(&self) -> Chart {
        self.spokes.chart()
    }

    /// The square of the time at which a front arrives at a point of the grid, since the first
    /// start, if it is known there. Differences of squares are linear in the plane.
    pub(super) fn squared(&self, index: usize, label: u32) -> Option<f64> {
        let (row, col) = self.chart().position(index);
        let time = self.time(self.chart().bordered(row, col), label);
        (time < f64::FAR).then(|| self.square(time))
    }

    /// Where on the edge between two points of different regions both fronts arrive at once: from
    /// the first (0) to the second (1).
    pub(super) fn meeting(&self, points: [usize; 2], labels: [u32; 2]) -> f64 {
        match points.map(|point| self.lead(point, labels)) {
            [Some(here), Some(there)] if here > there => (here / (here - there)).clamp(0.0, 1.0),
            _ => 0.5,
        }
    }

    /// By how much the squared time of the second front is later than that of the first, if both
    /// are known at a point of the grid.
    fn lead(&self, index: usize, labels: [u32; 2]) -> Option<f64> {
        let (row, col) = self.chart().position(index);
        let mut times = [f64::FAR; 2];
        for (label, time) in self.arrivals_at(self.chart().bordered(row, col)) {
            let known = labels.iter().zip(&mut times).filter(|(known, _)| **known == label);
            known.for_each(|(_, known)| *known = time);
        }
        let [first, second] = times.map(|time| (time < f64::FAR).then(|| self.square(time)));
        Some(second? - first?)
    }

    fn square(&self, time: f64) -> f64 {
        (time - self.start).powi(2)
    }
}

/// Up to when fronts count at a point, given when the first arrives and its longest edge. Over an
/// edge from one region to another each front comes by the length of that edge after the other
/// one's, at most, and is known there that much later.
fn latest(first: f64, longest: f64) -> f64 {
    first + 2.0 * longest * (1.0 + 1e-6)
}

/// The fronts at the points that sources seed. Of two sources that are the same the second has
/// none.
fn starts(chart: Chart, surface: &Surface, sources: &Sources) -> Result<Vec<Start>, MapError> {
    let all: Vec<&Source> = sources.iter().collect();
    let mut starts = Vec::new();
    for (label, source) in all.iter().enumerate() {
        let seeds = Sources::from_iter([(*source).clone()]).seeds(surface)?;
        if !all[..label].contains(source) {
            starts.extend(seeds.into_iter().map(|seed| Start {
                point: chart.bordered(seed.row, seed.col),
                label: label as u32,
                time: seed.time,
            }));
        }
    }
    Ok(starts)
}

/// The points that sources seed, each with the label of the first front there.
fn first_labels(starts: &[Start]) -> Vec<(usize, u32)> {
    let mut order: Vec<&Start> = starts.iter().collect();
    order.sort_by(|a, b| {
        a.point.cmp(&b.point).then(a.time.total_cmp(&b.time)).then(a.label.cmp(&b.label))
    });
    order.dedup_by_key(|start| start.point);
    order.into_iter().map(|start| (start.point, start.label)).collect()
}

impl Origin {
    fn of(source: &Source) -> Self {
        match source {
            Source::Point { initial, .. } => {
                Self { wavefront: Wavefront::PointSource, initial: *initial }
            }
            Source::Curve { initial, .. } => {
                Self { wavefront: Wavefront::Planar, initial: *initial }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spacing;
    use crate::Stop;
    use crate::cpu::raster_scan;
    use crate::update::Wavefront;

    /// Whether points are left out or not, all fronts are the same.
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
                // One close to another, where fronts run side by side.
                if let Source::Point { at, initial } = sources[0].clone() {
                    let at = [at.x, (at.y - beside).max(0.0)];
                    if mask[surface.chart().index(at[0] as usize, at[1] as usize)] {
                        sources.push(Source::Point { at: at.into(), initial: initial + 0.1 });
                    }
                }
                let sources = Sources::from_iter(sources);
                let seeds = sources.seeds(&surface).unwrap();
                let stop = Stop { tolerance: 0.0, iterations: 1000 };
                let map = raster_scan(&edges, &seeds, Wavefront::PointSource, stop).distances();
                let [few, all] = [false, true].map(|everywhere| {
                    let mut fronts =
                        SourceFronts::before(&surface, &edges, &sources, &map).unwrap();
                    if everywhere {
                        let reached = |&point: &usize| fronts.times[point] < f32::FAR;
                        let all: Vec<usize> = (0..fronts.times.len()).filter(reached).collect();
                        all.into_iter().for_each(|point| fronts.enqueue(point));
                    }
                    fronts.follow();
                    fronts
                });
                let visits =
                    |fronts: &SourceFronts| fronts.is_queued.iter().filter(|&&q| q).count();
                // The closest of pairs are never late enough by far for one of them to be left behind.
                assert!(visits(&few) < visits(&all) || roughness > 0.0 || beside == 1.0);
                for point in 0..few.times.len() {
                    let mut found = [&few, &all].map(|f| f.arrivals_at(point).collect::<Vec<_>>());
                    found.iter_mut().for_each(|found| found.sort_by_key(|(label, _)| *label));
                    assert_eq!(found[0], found[1], "{roughness} {count} {point}");
                }
            }
        }
    }
}
