//! Where fronts meet: the map's kinks, the cut locus of its sources.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::chains::ways;
use super::order::bordered;
use super::spokes::Spokes;
use super::{Curve, MapError};
use crate::surface::{Chart, Direction, Edge, EdgeLengths, Real, ring, triangles};

/// A line on which fronts from different directions meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Ridge {
    /// The line, from end to end or junction to junction; its direction means nothing.
    pub curve: Curve,
    /// The angle between the fronts' directions at each vertex, in degrees, up to 180, where they meet
    /// head-on. From `least_angle` on at free ends, in between also somewhat less.
    pub angles: Vec<f64>,
}

/// A kink on an edge of the grid.
#[derive(Clone, Copy, Debug)]
struct Kink {
    place: DVec2,
    angle: f64,
}

/// Where a line goes on with at least the least angle, it may have less by this factor: the grid lets
/// angles that are nearly constant along a ridge vary so that it would be in pieces. As in Canny's
/// detector of edges in images, which has two thresholds.
const WEAK: f64 = 0.6;
/// Lines that are shorter, in cells, and stand alone or branch off, are the grid's.
const SHORT: f64 = 4.0;

/// The lines on which a converged map has a kink since fronts meet there at an angle of at least
/// `least_angle` degrees: borders between sources as well as the cut locus of each, behind holes
/// and hills and between the parts of a curve. The `edges` are the surface's.
///
/// The criterion: at each grid point the direction is that of the ray that brings the first front,
/// over the base of one of its triangles, never across a kink. An edge has a kink if the directions
/// at its ends, in the metric between them, include at least the least angle and run towards one
/// another, or at least not apart, where the ridge runs along the edge; it lies where both fronts,
/// straight on from either end, arrive at once. Ridges run through triangles from edge to edge with a
/// kink; where all three edges have one they meet at the middle of the three places. Between places
/// with the least angle a ridge goes on where there is three fifths of it. Lines of less than four cells
/// are left out.
///
/// Rays are those of circular fronts: beside a curve, at some cells' distance from it, they are off
/// by up to half a cell over that distance.
///
/// Below some 20 degrees discretisation begins to look like kinks, near sources first. Fronts that
/// meet at a single point, as in the middle of a circle, leave a star of a few cells.
///
/// # Errors
/// If there is not a distance for each grid point.
///
/// ```
/// use geosweep::geometry::ridges;
/// use geosweep::surface::EdgeLengths;
/// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
///
/// // Behind a wall, fronts meet that have come around it on both sides.
/// let mask: Vec<bool> = (0..61 * 61usize).map(|i| i / 61 != 20 || (i % 61).abs_diff(30) > 15).collect();
/// let surface = Surface::from_heights(61, 61, vec![0.0; 61 * 61], Spacing::square(1.0))?;
/// let surface = surface.with_mask(&mask)?;
/// let map = distance_map(&surface, &Sources::point(5.0, 30.0), &Options::default())?;
/// let ridges = ridges(&EdgeLengths::new(&surface)?, &map.distances, 30.0)?;
/// assert_eq!(ridges.len(), 1);
/// assert!(ridges[0].curve.vertices.iter().all(|at| at[0] > 20.0 && (at[1] - 30.0).abs() < 0.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn ridges(
    edges: &EdgeLengths<f32>,
    distances: &[f32],
    least_angle: f64,
) -> Result<Vec<Ridge>, MapError> {
    let chart = edges.chart();
    let times = bordered(chart, distances)?;
    let rays = ArrivingRays::new(edges, times);
    let cosine = (WEAK * least_angle).to_radians().cos();
    let rows = chart.rows_of_cells().into_par_iter();
    let found: Vec<([u64; 2], [Kink; 2])> =
        rows.flat_map_iter(|row| rays.march(row, cosine)).collect();
    let mut kinks: BTreeMap<u64, Kink> = BTreeMap::new();
    for (node, kink) in found.iter().flat_map(|(nodes, ends)| nodes.iter().zip(ends)) {
        // A grid point has those of all its edges.
        let known = kinks.entry(*node).or_insert(*kink);
        known.angle = known.angle.max(kink.angle);
    }
    let segments = found.iter().map(|(nodes, _)| [nodes[0].min(nodes[1]), nodes[0].max(nodes[1])]);
    // Between two grid points there is a triangle on either side.
    let segments: BTreeSet<[u64; 2]> = segments.collect();

    let least = least_angle.to_radians();
    let segments = without_weak_ends(segments, |node| kinks[&node].angle >= least);
    let ways = without_short_ways(segments, |node| kinks[&node].place);
    let ridge = |way: Vec<u64>| {
        let closed = way.len() > 3 && way[0] == way[way.len() - 1];
        let way = if closed { &way[1..] } else { &way[..] };
        let (first, last) = (way[0], way[way.len() - 1]);
        // Where three ways would have met, and one has gone, the others go straight on.
        let is_vertex = |node: u64| node == first || node == last || !is_of_triangle(chart, node);
        let way = || way.iter().filter(|node| is_vertex(**node)).map(|node| kinks[node]);
        let vertices = way().map(|kink| kink.place.to_array()).collect();
        let angles = way().map(|kink| kink.angle.to_degrees()).collect();
        Ridge { curve: Curve { vertices, closed }, angles }
    };
    Ok(ways.into_iter().map(ridge).collect())
}

/// The nodes at the other ends of the segments at each node.
type Neighbours = BTreeMap<u64, BTreeSet<u64>>;

fn neighbours(segments: &BTreeSet<[u64; 2]>) -> Neighbours {
    let mut neighbours = Neighbours::new();
    for &[a, b] in segments {
        neighbours.entry(a).or_default().insert(b);
        neighbours.entry(b).or_default().insert(a);
    }
    neighbours
}

/// Leaves out segments from free ends on until a node is strong, and what has no strong node.
fn without_weak_ends(
    mut segments: BTreeSet<[u64; 2]>,
    is_strong: impl Fn(u64) -> bool,
) -> BTreeSet<[u64; 2]> {
    let mut beside = neighbours(&segments);
    let is_weak_end = |beside: &Neighbours, node| beside[&node].len() == 1 && !is_strong(node);
    let mut ends: Vec<u64> =
        beside.keys().copied().filter(|&node| is_weak_end(&beside, node)).collect();
    while let Some(end) = ends.pop() {
        // Both ends of a segment may be weak, of which one was first.
        let Some(inward) = beside.get_mut(&end).and_then(BTreeSet::pop_first) else { continue };
        segments.remove(&[end.min(inward), end.max(inward)]);
        beside.get_mut(&inward).expect("segments have two ends").remove(&end);
        if is_weak_end(&beside, inward) {
            ends.push(inward);
        }
    }
    let mut reached: BTreeSet<u64> = BTreeSet::new();
    let mut open: Vec<u64> = beside.keys().copied().filter(|&node| is_strong(node)).collect();
    while let Some(node) = open.pop() {
        if reached.insert(node) {
            open.extend(&beside[&node]);
        }
    }
    segments.retain(|[node, _]| reached.contains(node));
    segments
}

/// The ways that segments make, without what is short: ways with a free end, loops, and of two ways
/// between the same nodes the longer one. What is left goes straight on.
fn without_short_ways(
    mut segments: BTreeSet<[u64; 2]>,
    place: impl Fn(u64) -> DVec2,
) -> Vec<Vec<u64>> {
    let length = |way: &[u64]| -> f64 {
        way.windows(2).map(|pair| place(pair[0]).distance(place(pair[1]))).sum()
    };
    loop {
        let beside = neighbours(&segments);
        let mut found: Vec<_> = ways(&segments.iter().copied().collect::<Vec<_>>())
            .into_iter()
            .map(|way| (length(&way), way))
            .collect();
        found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        // The nodes that short ways lead between, shortest first.
        let mut connected = BTreeSet::new();
        // One at a node and time, since two others may become one that is long.
        let mut changed = BTreeSet::new();
        let count = segments.len();
        for (length, way) in &found {
            let (first, last) = (way[0], way[way.len() - 1]);
            let is_free = [first, last].iter().any(|end| beside[end].len() == 1);
            let is_short = if first == last {
                *length < 2.0 * SHORT
            } else {
                *length < SHORT
                    && (is_free || !connected.insert([first.min(last), first.max(last)]))
            };
            if is_short && !changed.contains(&first) && !changed.contains(&last) {
                changed.extend([first, last]);
                for pair in way.windows(2) {
                    segments.remove(&[pair[0].min(pair[1]), pair[0].max(pair[1])]);
                }
            }
        }
        if segments.len() == count {
            return ways(&segments.into_iter().collect::<Vec<_>>());
        }
    }
}

/// Whether a node is the middle of a triangle, not on an edge or at a grid point.
fn is_of_triangle(chart: Chart, node: u64) -> bool {
    node.checked_sub(Edge::end(chart)).is_some_and(|number| number % 3 > 0)
}

/// How the first front arrives at a point.
#[derive(Clone, Copy, Debug, Default)]
struct Ray {
    /// In steps of rows and columns, of length one on the surface; zero at sources and where no
    /// front arrives.
    direction: Vec2,
    /// The metric in those steps, by row, mixed, by column.
    metric: Vec3,
}

/// A kink nearer than this to a grid point, in shares of the edge, lies at it.
const AT_POINT: f64 = 1e-4;
/// Directions that part by this much of what they could, over an edge of that length, may as well
/// meet: the ridge runs along the edge, and rounding decides on which side of it.
const ALONG: f64 = 0.1;

/// A map, and the directions in which its fronts arrive, in bordered arrays.
struct ArrivingRays<'a> {
    spokes: Spokes<'a>,
    times: Vec<f32>,
    start: f64,
    arrivals: Vec<Ray>,
}

/// A point by its index in a bordered array, and where it lies.
#[derive(Clone, Copy)]
struct Point {
    index: usize,
    place: DVec2,
}

impl Point {
    /// Its index in row-major order without a border.
    fn number(self, chart: Chart) -> usize {
        chart.index(self.place.x as usize, self.place.y as usize)
    }
}

impl<'a> ArrivingRays<'a> {
    fn new(edges: &'a EdgeLengths<f32>, times: Vec<f32>) -> Self {
        let spokes = Spokes::new(edges);
        let start = f64::from(times.par_iter().copied().reduce(|| f32::FAR, f32::min));
        let mut rays = Self { spokes, times, start, arrivals: Vec::new() };
        let points = (0..rays.times.len()).into_par_iter().with_min_len(4096);
        rays.arrivals = points.map(|point| rays.ray(point)).collect();
        rays
    }

    fn is_reached(&self, point: usize) -> bool {
        self.times[point] < f32::FAR
    }

    /// How the first front arrives at a point over bases that it has passed.
    fn ray(&self, point: usize) -> Ray {
        if !self.is_reached(point) {
            return Ray::default();
        }
        let since = std::array::from_fn(|to| {
            let time = self.times[self.spokes.neighbour(point, to)];
            if time < self.times[point] { f64::from(time) - self.start } else { f64::FAR }
        });
        let Some((_, to, share)) = self.spokes.first_ray(point, &since) else {
            return Ray::default();
        };
        let [step, next] = [to, ring::next(to)].map(|to| Direction::ALL[to].vector());
        let direction = -step.lerp(next, share);
        let metric = self.spokes.metric(point);
        let length = direction.dot(metric * direction).sqrt();
        let direction = if length > 0.0 { direction / length } else { DVec2::ZERO };
        let [rr, rc, _, cc] = metric.to_cols_array();
        Ray { direction: direction.as_vec2(), metric: DVec3::new(rr, rc, cc).as_vec3() }
    }

    /// The kink on the edge between two neighbours, if there is one, and its node: the edge, or a
    /// grid point that the ridge passes through. `cosine` is that of the least angle.
    fn kink(&self, [from, to]: [Point; 2], cosine: f64) -> Option<(u64, Kink)> {
        let arrivals = [from, to].map(|end| self.arrivals[end.index]);
        let [a, b] = arrivals.map(|arrival| arrival.direction.as_dvec2());
        if a == DVec2::ZERO || b == DVec2::ZERO {
            return None;
        }
        let [rr, rc, cc] =
            (0.5 * (arrivals[0].metric.as_dvec3() + arrivals[1].metric.as_dvec3())).to_array();
        let metric = DMat2::from_cols_array(&[rr, rc, rc, cc]);
        let (of_a, of_b) = (metric * a, metric * b);
        let (dot, squares) = (a.dot(of_b), a.dot(of_a) * b.dot(of_b));
        // By how much the fronts' times would change from end to end.
        let step = to.place - from.place;
        let [rise_a, rise_b] = [of_a, of_b].map(|slope| slope.dot(step));
        let between = dot / squares.sqrt();
        let apart = (a - b).dot(of_a - of_b) * step.dot(metric * step);
        let nearing = rise_a - rise_b;
        if between > cosine || nearing < -ALONG * apart.sqrt() {
            return None;
        }
        let [time_a, time_b] = [from, to].map(|end| f64::from(self.times[end.index]));
        let share = if nearing > 0.0 { (time_b - time_a - rise_b) / nearing } else { 0.5 };
        let share = match share {
            share if share < AT_POINT => 0.0,
            share if share > 1.0 - AT_POINT => 1.0,
            share => share,
        };
        let chart = self.spokes.chart();
        let [first, last] = [from, to].map(|end| end.number(chart));
        let node = match share {
            0.0 => Edge::end(chart) + 3 * first as u64,
            1.0 => Edge::end(chart) + 3 * last as u64,
            _ => Edge::between(chart, first, last).number(),
        };
        let angle = between.clamp(-1.0, 1.0).acos();
        Some((node, Kink { place: from.place + share * step, angle }))
    }

    /// The pieces of ridges in a row of cells: nodes and what is there.
    fn march(&self, row: usize, cosine: f64) -> Vec<([u64; 2], [Kink; 2])> {
        let chart = self.spokes.chart();
        let mut found = Vec::new();
        for cell in chart.cells_of_row(row) {
            let points = cell.corners().map(|(row, col)| Point {
                index: chart.bordered(row, col),
                place: DVec2::new(row as f64, col as f64),
            });
            let triangles = triangles(points.map(|point| self.is_reached(point.index)), true);
            for (number, triangle) in triangles.iter().enumerate() {
                let kink = |k: usize| {
                    let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                    self.kink([points[a.min(b)], points[a.max(b)]], cosine)
                };
                let kinks: [Option<(u64, Kink)>; 3] = std::array::from_fn(kink);
                // Two edges have the same one where it lies at the point that they share.
                let same = |j: usize, k: usize| match (kinks[j], kinks[k]) {
                    (Some((a, _)), Some((b, _))) => a == b,
                    _ => false,
                };
                let distinct = [true, !same(0, 1), !same(0, 2) && !same(1, 2)];
                match [0, 1, 2].map(|k| kinks[k].filter(|_| distinct[k])) {
                    [Some(a), Some(b), Some(c)] => {
                        let middle = Kink {
                            place: (a.1.place + b.1.place + c.1.place) / 3.0,
                            angle: a.1.angle.max(b.1.angle).max(c.1.angle),
                        };
                        let of_triangle = 3 * points[0].number(chart) + 1 + number;
                        let node = Edge::end(chart) + of_triangle as u64;
                        let spoke = |(edge, kink)| ([edge, node], [kink, middle]);
                        found.extend([a, b, c].map(spoke));
                    }
                    [Some(a), Some(b), None]
                    | [Some(a), None, Some(b)]
                    | [None, Some(a), Some(b)] => found.push(([a.0, b.0], [a.1, b.1])),
                    _ => {}
                }
            }
        }
        found
    }
}
