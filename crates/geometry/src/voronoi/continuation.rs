//! Propagates the wavefronts of sources from point to point: computes the arrival time at a point from those at its
//! neighbours.

use crate::neighbourhood::Neighbourhood;
use geosweep_cpu::Visited;
use geosweep_cpu::lines::settled;
use geosweep_surface::update::{Triangle, Wavefront, circular, planar};
use geosweep_surface::{PartsAround, Real, Source, Sources, SplitPart, max, min, ring};

/// The kind and initial value of a source's wavefront.
#[derive(Clone, Copy, Debug)]
struct Origin {
    wavefront: Wavefront,
    initial: f64,
}

/// The updates of the sources' wavefronts, indexed by label.
pub(super) struct Continuation<'a> {
    neighbourhood: Neighbourhood<'a>,
    /// Parts of obtuse triangles, through which fronts arrive in place of these triangles.
    parts: Option<PartsAround<f32>>,
    origins: Vec<Origin>,
}

impl<'a> Continuation<'a> {
    pub(super) fn new(
        neighbourhood: Neighbourhood<'a>,
        parts: Option<PartsAround<f32>>,
        sources: &Sources,
    ) -> Self {
        Self { neighbourhood, parts, origins: sources.iter().map(Origin::of).collect() }
    }

    pub(super) fn parts(&self) -> Option<&PartsAround<f32>> {
        self.parts.as_ref()
    }

    /// Returns the parts of a point's obtuse triangles.
    pub(super) fn parts_behind(&self, point: usize) -> impl Iterator<Item = SplitPart<f32>> {
        self.parts.iter().flat_map(move |parts| parts.behind(point))
    }

    /// Returns the parts of other points' obtuse triangles that have a point as a corner, with these other points.
    pub(super) fn parts_beside(
        &self,
        point: usize,
    ) -> impl Iterator<Item = (usize, SplitPart<f32>)> {
        let beside = self.parts.iter().flat_map(move |parts| parts.beside(point));
        beside.map(|(x0, part, _)| (x0, part))
    }

    /// Returns the arrival time of a wavefront through a part, from its arrival times at the part's corners.
    pub(super) fn arrival_over(&self, label: u32, part: &SplitPart<f32>, times: [f64; 2]) -> f64 {
        let [t1, t2] = times.map(|time| self.since(label, time));
        let [l1, l2, c] = part.lengths.map(f64::from);
        self.origins[label as usize].initial + self.through(label, Triangle { t1, t2, l1, l2, c })
    }

    pub(super) fn neighbourhood(&self) -> &Neighbourhood<'a> {
        &self.neighbourhood
    }

    /// Returns the time between the start of a wavefront and its arrival at the time `time`.
    pub(super) fn since(&self, label: u32, time: f64) -> f64 {
        if time < f64::FAR {
            max(time - self.origins[label as usize].initial, 0.0)
        } else {
            f64::FAR
        }
    }

    /// Returns the arrival time of a wavefront at a point, from its neighbours. `since` holds the times since its start
    /// at the neighbours, and `lengths` the lengths of the edges to them.
    pub(super) fn arrival(
        &self,
        point: usize,
        label: u32,
        since: &[f64; 8],
        lengths: &[f64; 8],
    ) -> f64 {
        let (mut shortest, mut nearest) = (f64::FAR, 0);
        for (to, (since, length)) in since.iter().zip(lengths).enumerate() {
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
            let triangle = self.triangle(point, ends, since, ends.map(|to| lengths[to]));
            self.through(label, triangle)
        };
        // The wavefront nearly always comes through a triangle at the neighbour with the shortest path along
        // an edge, on the side where the next neighbour has the shorter path. The other triangles are tried
        // only if it does not.
        let [right, left] = [ring::previous(nearest), ring::next(nearest)];
        let [to_right, to_left] = [right, left].map(|to| since[to] + lengths[to]);
        let beside = if to_right < to_left { [right, nearest] } else { [nearest, right] };
        let found = beside.into_iter().map(through).find(|&time| time < shortest);
        let first = found.unwrap_or_else(|| (0..8).map(through).fold(shortest, min));
        self.origins[label as usize].initial + first
    }

    /// Returns the arrival time of a wavefront at a point through the two triangles on either side of one of its edges.
    /// Returns `None` if a cheap bound shows that it does not arrive before `now`.
    ///
    /// `since` holds the times since the wavefront's start at the neighbours. Only three of them are used: at
    /// the end of the edge and on either side of it.
    pub(super) fn arrival_beside(
        &self,
        point: usize,
        label: u32,
        edge: usize,
        since: &[f64; 8],
        now: f64,
    ) -> Option<f64> {
        let length = |to: usize| self.neighbourhood.length(point, to);
        let triangles = [ring::previous(edge), ring::next(edge)].map(|side| {
            let ends = [edge, side];
            self.triangle(point, ends, since, ends.map(length))
        });
        let Origin { wavefront, initial } = self.origins[label as usize];
        let now = now - initial;
        let settles = match wavefront {
            Wavefront::Circular => settled::from_circular,
            _ => settled::from_planar,
        };
        let visited = Visited { now, triangles };
        if visited.stays(triangles.map(|triangle| settles(triangle, now))) {
            return None;
        }
        let [left, right] = triangles.map(|triangle| self.through(label, triangle));
        Some(initial + min(left, right))
    }

    /// Returns the triangle of a point with two adjacent neighbours.
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
        let triangle = Triangle { t1, t2, l1, l2, c: self.neighbourhood.base(point, first) };
        if self.parts.is_some() { triangle.without_obtuse_face() } else { triangle }
    }

    /// Returns the arrival time of a wavefront through a triangle, counted from the wavefront's start.
    #[inline(always)]
    fn through(&self, label: u32, triangle: Triangle<f64>) -> f64 {
        let Triangle { t1, t2, l1, l2, .. } = triangle;
        if max(t1, t2) >= f64::FAR {
            return min(t1 + l1, t2 + l2);
        }
        match self.origins[label as usize].wavefront {
            Wavefront::Circular => circular(triangle, false),
            _ => planar(triangle),
        }
    }
}

impl Origin {
    fn of(source: &Source) -> Self {
        match source {
            Source::Point { initial, .. } => {
                Self { wavefront: Wavefront::Circular, initial: *initial }
            }
            Source::Curve { initial, .. } => {
                Self { wavefront: Wavefront::Planar, initial: *initial }
            }
        }
    }
}
