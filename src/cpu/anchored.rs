//! Fast marching over floor plans, exact by anchors.
//!
//! A shortest path over a flat grid with holes is a chain of straight lines that bends only beside holes.
//! Its last bend, or its source, is the *anchor* of what follows (the pseudosource of exact polyhedral
//! methods; Mitchell, Mount and Papadimitriou, "The discrete geodesic problem", 1987): a point's distance
//! is its anchor's and that of the straight line from there. So no front has to be assumed inside a
//! triangle. A point takes the nearest of the anchors of its neighbours, and of their own anchors, that it
//! can be reached from through the triangle; all that is asked of these is on which side of a line a grid
//! point lies, in whole numbers.
//!
//! What no neighbour knows of is missed: among holes of single points a corner often lights less than a
//! cell for long, and there distances can be too long.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;

use super::fast_marching::Arrival;
use super::state::Solution;
use crate::Sources;
use crate::surface::{
    Direction, EdgeLengths, EdgeSlot, EvenGrid, Real, Source, SourceError, Surface, is_corner,
};
use crate::update::Wavefront;

/// How many anchors back a point looks beside its neighbours' own: where several corners lie close
/// together, what is lit from between them may be narrower than a cell for long.
const GENERATIONS: usize = 4;

/// The grid of a floor plan, over which marching arcs go by anchors. Not if it has obtuse triangles: the
/// way to a point may lead between neighbours of which one is farther than the point itself.
pub(crate) fn floor_plan(surface: &Surface, wavefront: Wavefront) -> Option<EvenGrid> {
    let grid = (wavefront == Wavefront::Arcs).then(|| EvenGrid::of(surface)).flatten();
    grid.filter(|grid| !grid.is_obtuse())
}

/// Distances over the grid of a floor plan from point sources, whose initial values lie above `start`, less that.
///
/// # Errors
/// [`SourceError`], as from [`Sources::seeds`].
pub(crate) fn march_by_anchors<R: Real>(
    surface: &Surface,
    edges: &EdgeLengths<R>,
    grid: EvenGrid,
    sources: &Sources,
    start: f64,
) -> Result<Solution<R>, SourceError> {
    let chart = edges.chart();
    let points = chart.bordered_points();
    let mut march = March {
        surface,
        edges,
        grid,
        stride: chart.stride(),
        around: Direction::ALL.map(|to| (chart.offset(to), EdgeSlot::new(chart, 0, to))),
        sources: Vec::new(),
        times: vec![f64::FAR; points],
        anchors: vec![0; points],
        fixed: vec![false; points],
    };
    let mut heap = BinaryHeap::new();
    for source in sources.iter() {
        let (at, initial) = match source {
            Source::Point { at, initial } => (*at, *initial),
            Source::Curve { vertices, initial } => (vertices[0], *initial),
        };
        let anchor = march.add(at + DVec2::ONE, initial - start);
        for seed in Sources::point(at.x, at.y).seeds(surface)? {
            let point = chart.bordered(seed.row, seed.col);
            let way = march.way(point, anchor);
            heap.extend(march.take(point, way));
        }
    }
    while let Some(Reverse(Arrival { point, .. })) = heap.pop() {
        // A point stays in the heap under its earlier, larger times too.
        if std::mem::replace(&mut march.fixed[point], true) {
            continue;
        }
        let is_corner = march.is_corner(point);
        for to in 0..march.around.len() {
            let Some(x0) = march.neighbour(point, to).filter(|&x0| !march.fixed[x0]) else {
                continue;
            };
            if let Some(way) = march.reach(x0, point, (to + 4) % 8, is_corner) {
                heap.extend(march.take(x0, way));
            }
        }
    }
    let times = march.times[..points].iter().map(|&time| R::of(time)).collect();
    Ok(Solution::new(chart, times, 1, 0.0))
}

struct March<'a, R> {
    surface: &'a Surface,
    edges: &'a EdgeLengths<R>,
    grid: EvenGrid,
    stride: usize,
    /// Where the eight neighbours lie, and the edges to them.
    around: [(isize, EdgeSlot); 8],
    /// Rows and columns, counted from the border.
    sources: Vec<DVec2>,
    /// Of the points of a bordered array, and of the sources after them.
    times: Vec<f64>,
    /// Of those that are reached; a source is its own.
    anchors: Vec<usize>,
    /// Of the points alone.
    fixed: Vec<bool>,
}

/// A distance and the anchor that it is from.
type Way = (f64, usize);

impl<R: Real> March<'_, R> {
    fn neighbour(&self, point: usize, to: usize) -> Option<usize> {
        let (offset, edge) = self.around[to];
        (self.edges.at(point, edge) < R::FAR).then(|| point.wrapping_add_signed(offset))
    }

    fn is_corner(&self, point: usize) -> bool {
        // Most points have all their edges, which is found sooner.
        if (0..8).all(|to| self.neighbour(point, to).is_some()) {
            return false;
        }
        let (row, col) = (point / self.stride - 1, point % self.stride - 1);
        let there = |to| self.surface.chart().neighbour(row, col, to);
        is_corner(Direction::ALL.map(|to| there(to).is_some_and(|(r, c)| self.surface.has(r, c))))
    }

    /// Adds a source; returns its number as an anchor.
    fn add(&mut self, place: DVec2, time: f64) -> usize {
        let anchor = self.times.len();
        self.sources.push(place);
        self.times.push(time);
        self.anchors.push(anchor);
        anchor
    }

    /// Row and column, from the border: whole numbers, but for sources.
    fn place(&self, anchor: usize) -> DVec2 {
        match anchor.checked_sub(self.fixed.len()) {
            Some(source) => self.sources[source],
            None => DVec2::new((anchor / self.stride) as f64, (anchor % self.stride) as f64),
        }
    }

    fn step(&self, from: usize, to: usize) -> DVec2 {
        self.place(to) - self.place(from)
    }

    /// Takes a way to a point if it is shorter; returns what the heap is to know then.
    fn take(&mut self, point: usize, (time, anchor): Way) -> Option<Reverse<Arrival<f64>>> {
        if !is_shorter(time, self.times[point]) {
            return None;
        }
        (self.times[point], self.anchors[point]) = (time, anchor);
        Some(Reverse(Arrival { time, point }))
    }

    /// The shortest way to a point past its neighbour `end` in some direction, which has just been fixed.
    fn reach(&self, x0: usize, end: usize, to: usize, is_corner: bool) -> Option<Way> {
        let fixed = |to| self.neighbour(x0, to).filter(|&end| self.fixed[end]);
        let beside = [fixed((to + 1) % 8), fixed((to + 7) % 8)].into_iter().flatten();
        let through = beside.filter_map(|other| self.through(x0, [end, other]));
        through.chain(self.along(x0, end, is_corner)).reduce(|a, b| self.better(a, b))
    }

    /// The way along an edge: from its end, if that is a corner, or straight on.
    fn along(&self, x0: usize, end: usize, is_corner: bool) -> Option<Way> {
        if is_corner {
            return Some(self.way(x0, end));
        }
        let anchor = self.anchors[end];
        let (edge, ray) = (self.step(x0, end), self.step(x0, anchor));
        let goes_on = edge.perp_dot(ray) == 0.0 && edge.dot(ray) > 0.0;
        goes_on.then(|| self.way(x0, anchor))
    }

    /// The shortest straight way through a triangle, from an anchor of its ends or from these' own.
    fn through(&self, x0: usize, ends: [usize; 2]) -> Option<Way> {
        let [e1, e2] = ends.map(|end| self.step(x0, end));
        let turn = e1.perp_dot(e2);
        let comes_through = |&anchor: &usize| {
            let ray = self.step(x0, anchor);
            ray.perp_dot(e2) * turn >= 0.0 && e1.perp_dot(ray) * turn >= 0.0
        };
        ends.into_iter()
            .flat_map(|end| self.ancestors(end).take(1 + GENERATIONS))
            .filter(comes_through)
            .filter(|&anchor| ends.into_iter().all(|end| self.sees(x0, anchor, end)))
            .map(|anchor| self.way(x0, anchor))
            .reduce(|a, b| self.better(a, b))
    }

    /// A point's anchor, the anchor's, and so on to the source.
    fn ancestors(&self, point: usize) -> impl Iterator<Item = usize> {
        let next = |&point: &usize| Some(self.anchors[point]).filter(|&anchor| anchor != point);
        std::iter::successors(Some(self.anchors[point]), next)
    }

    /// The shorter of two ways; of two that are as long, on one line, that from the corner passed last.
    fn better(&self, a: Way, b: Way) -> Way {
        let as_long = !is_shorter(a.0, b.0) && !is_shorter(b.0, a.0);
        let second = if as_long { self.times[b.1] > self.times[a.1] } else { b.0 < a.0 };
        if second { b } else { a }
    }

    fn way(&self, x0: usize, anchor: usize) -> Way {
        let straight = self.grid.length(self.step(x0, anchor));
        (self.times[anchor] + straight, anchor)
    }

    /// Whether x0 is out of the shadow that an end of its base lies in, as seen from an anchor. It lies in
    /// one if the straight line would have been shorter. The shadow's border runs through the first corner
    /// on the way from that anchor to the end.
    fn sees(&self, x0: usize, anchor: usize, end: usize) -> bool {
        let of_end = self.anchors[end];
        if of_end == anchor || !is_shorter(self.way(end, anchor).0, self.times[end]) {
            return true;
        }
        let known = self.ancestors(end).take(2 + GENERATIONS);
        let first_corner = known.zip(self.ancestors(of_end)).find(|&(_, next)| next == anchor);
        let corner = first_corner.map_or(of_end, |(corner, _)| corner);
        let border = self.step(anchor, corner);
        let [of_x0, of_end] = [x0, end].map(|point| border.perp_dot(self.step(anchor, point)));
        // On the border the corner serves as well, and knows which corners come next.
        if first_corner.is_some_and(|(corner, _)| corner != self.anchors[end]) {
            of_x0 * of_end < 0.0
        } else {
            of_x0 * of_end <= 0.0
        }
    }
}

/// By more than rounding.
fn is_shorter(a: f64, b: f64) -> bool {
    a < b * (1.0 - 8.0 * f64::EPSILON)
}
