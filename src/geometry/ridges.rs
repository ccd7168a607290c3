//! Finds ridges: the lines where wavefronts meet, which are the kinks of the map and the cut locus of its
//! sources.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::chains::ways;
use super::neighbourhood::Neighbourhood;
use super::order::bordered;
use super::{Curve, MapError};
use crate::surface::{
    Chart, Direction, Edge, EdgeLengths, GluingError, Real, UNGLUED, ring, triangles,
};

/// A line on which wavefronts from different directions meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Ridge {
    /// The line, which runs between free ends and junctions. Its direction has no meaning.
    pub curve: Curve,
    /// The angle between the wavefronts' directions at each vertex, in degrees. It is at most 180, where they
    /// meet head-on. At free ends it is at least `least_angle`; in between it may be somewhat less.
    pub angles: Vec<f64>,
}

/// A kink on an edge of the grid.
#[derive(Clone, Copy, Debug)]
struct Kink {
    place: DVec2,
    angle: f64,
}

/// The factor by which the angle may be below the least angle where a ridge continues. On the grid, angles
/// that are nearly constant along a ridge vary, and the ridge would otherwise fall into pieces. Canny's edge
/// detector uses two thresholds in the same way.
const WEAK: f64 = 0.6;
/// The length, in cells, below which a line that stands alone or branches off is an artefact of the grid.
const SHORT: f64 = 4.0;

/// Computes the lines on which a converged map has a kink, since wavefronts meet there at an angle of at
/// least `least_angle` degrees.
///
/// They are the borders between the regions of several sources and the cut locus of each source: behind holes
/// and hills, and between the parts of a curve. `edges` are the edge lengths of the surface.
///
/// The criterion is as follows. The direction at a grid point is that of the ray that arrives first across
/// the base of one of its triangles. Such a ray never crosses a kink. An edge has a kink if two conditions
/// hold for the directions at its ends, in the metric between them. They include at least the least angle,
/// and they converge. If the ridge runs along the edge, it suffices that they do not diverge. The kink lies
/// where both wavefronts, continued straight from either end, arrive at once.
///
/// Ridges run through triangles from one edge with a kink to another. If all three edges have a kink, the
/// ridges meet at the mean of the three places. Between places with the least angle, a ridge continues where
/// the angle is at least three fifths of it. Lines of less than four cells are left out.
///
/// Rays are those of circular wavefronts. At a distance of some cells beside a source curve, they are off by
/// up to half a cell over that distance.
///
/// Below some 20 degrees discretisation errors begin to look like kinks, near sources first. Wavefronts that
/// meet at a single point, as in the middle of a circle, leave a star of a few cells.
///
/// # Errors
/// If the surface is glued, or the number of distances differs from the number of grid points.
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
    if edges.copies().is_some() {
        let what = "the search for ridges";
        return Err(GluingError::Unsupported { what, instead: UNGLUED }.into());
    }
    let chart = edges.chart();
    let times = bordered(chart, distances)?;
    let rays = ArrivingRays::new(edges, times);
    let cosine = (WEAK * least_angle).to_radians().cos();
    let rows = chart.rows_of_cells().into_par_iter();
    let found: Vec<([u64; 2], [Kink; 2])> =
        rows.flat_map_iter(|row| rays.march(row, cosine)).collect();
    let mut kinks: BTreeMap<u64, Kink> = BTreeMap::new();
    for (node, kink) in found.iter().flat_map(|(nodes, ends)| nodes.iter().zip(ends)) {
        // A node at a grid point belongs to several edges. It has the largest of their angles.
        let known = kinks.entry(*node).or_insert(*kink);
        known.angle = known.angle.max(kink.angle);
    }
    let segments = found.iter().map(|(nodes, _)| [nodes[0].min(nodes[1]), nodes[0].max(nodes[1])]);
    // A segment between two grid points is found twice, since there is a triangle on either side.
    let segments: BTreeSet<[u64; 2]> = segments.collect();

    let least = least_angle.to_radians();
    let segments = without_weak_ends(segments, |node| kinks[&node].angle >= least);
    let ways = without_short_ways(segments, |node| kinks[&node].place);
    let ridge = |way: Vec<u64>| {
        let closed = way.len() > 3 && way[0] == way[way.len() - 1];
        let way = if closed { &way[1..] } else { &way[..] };
        let (first, last) = (way[0], way[way.len() - 1]);
        // If one of three ridges at the middle of a triangle has been removed, the other two are connected
        // directly.
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

/// Removes segments from free ends up to the first strong node, and components without a strong node.
fn without_weak_ends(
    mut segments: BTreeSet<[u64; 2]>,
    is_strong: impl Fn(u64) -> bool,
) -> BTreeSet<[u64; 2]> {
    let mut beside = neighbours(&segments);
    let is_weak_end = |beside: &Neighbours, node| beside[&node].len() == 1 && !is_strong(node);
    let mut ends: Vec<u64> =
        beside.keys().copied().filter(|&node| is_weak_end(&beside, node)).collect();
    while let Some(end) = ends.pop() {
        // If both ends of a segment are weak, the segment has been removed from its other end.
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

/// Joins segments into polylines and removes short ones. These are polylines with a free end, loops, and the
/// longer of two short polylines between the same nodes. The remaining polylines are joined.
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
        // The pairs of nodes that short polylines connect, visited in order of length.
        let mut connected = BTreeSet::new();
        // At each node only one polyline is removed per pass, since two others may then join into a long one.
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

/// Returns whether a node is the middle of a triangle, and not on an edge or at a grid point.
fn is_of_triangle(chart: Chart, node: u64) -> bool {
    node.checked_sub(Edge::end(chart)).is_some_and(|number| number % 3 > 0)
}

/// The arrival of the first wavefront at a point.
#[derive(Clone, Copy, Debug, Default)]
struct Ray {
    /// The direction in steps of rows and columns, with unit length on the surface. It is zero at sources and
    /// where no wavefront arrives.
    direction: Vec2,
    /// The metric in steps of rows and columns: its row, mixed and column coefficients.
    metric: Vec3,
}

/// The distance from a grid point, as a fraction of the edge, up to which a kink lies at the point.
const AT_POINT: f64 = 1e-4;
/// Largest divergence of directions that still count as meeting, as a fraction of the largest possible
/// divergence over the edge. There the ridge runs along the edge, and rounding decides on which side of it.
const ALONG: f64 = 0.1;

/// A map and the directions in which its wavefronts arrive, in bordered arrays.
struct ArrivingRays<'a> {
    neighbourhood: Neighbourhood<'a>,
    times: Vec<f32>,
    start: f64,
    arrivals: Vec<Ray>,
}

/// A point, as its index in a bordered array and its place.
#[derive(Clone, Copy)]
struct Point {
    index: usize,
    place: DVec2,
}

impl Point {
    /// Returns the row-major index without a border.
    fn number(self, chart: Chart) -> usize {
        chart.index(self.place.x as usize, self.place.y as usize)
    }
}

impl<'a> ArrivingRays<'a> {
    fn new(edges: &'a EdgeLengths<f32>, times: Vec<f32>) -> Self {
        let neighbourhood = Neighbourhood::new(edges);
        let start = f64::from(times.par_iter().copied().reduce(|| f32::FAR, f32::min));
        let mut rays = Self { neighbourhood, times, start, arrivals: Vec::new() };
        let points = (0..rays.times.len()).into_par_iter().with_min_len(4096);
        rays.arrivals = points.map(|point| rays.ray(point)).collect();
        rays
    }

    fn is_reached(&self, point: usize) -> bool {
        self.times[point] < f32::FAR
    }

    /// Returns how the first wavefront arrives at a point, across bases that it has already passed.
    fn ray(&self, point: usize) -> Ray {
        if !self.is_reached(point) {
            return Ray::default();
        }
        let since = std::array::from_fn(|to| {
            let time = self.times[self.neighbourhood.neighbour(point, to)];
            if time < self.times[point] { f64::from(time) - self.start } else { f64::FAR }
        });
        let Some((_, to, share)) = self.neighbourhood.first_ray(point, &since) else {
            return Ray::default();
        };
        let [step, next] = [to, ring::next(to)].map(|to| Direction::ALL[to].vector());
        let direction = -step.lerp(next, share);
        let metric = self.neighbourhood.metric(point);
        let length = direction.dot(metric * direction).sqrt();
        let direction = if length > 0.0 { direction / length } else { DVec2::ZERO };
        let [rr, rc, _, cc] = metric.to_cols_array();
        Ray { direction: direction.as_vec2(), metric: DVec3::new(rr, rc, cc).as_vec3() }
    }

    /// Returns the kink on the edge between two neighbours, if there is one, and its node. The node is the
    /// edge, or a grid point through which the ridge passes. `cosine` is the cosine of the least angle.
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
        // The changes of both wavefronts' times from one end to the other.
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
        let chart = self.neighbourhood.chart();
        let [first, last] = [from, to].map(|end| end.number(chart));
        let node = match share {
            0.0 => Edge::end(chart) + 3 * first as u64,
            1.0 => Edge::end(chart) + 3 * last as u64,
            _ => Edge::between(chart, first, last).number(),
        };
        let angle = between.clamp(-1.0, 1.0).acos();
        Some((node, Kink { place: from.place + share * step, angle }))
    }

    /// Returns the ridge segments in a row of cells: their nodes and the kinks there.
    fn march(&self, row: usize, cosine: f64) -> Vec<([u64; 2], [Kink; 2])> {
        let chart = self.neighbourhood.chart();
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
                // Two edges have the same kink if it lies at the point that they share.
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
                        let neighbour = |(edge, kink)| ([edge, node], [kink, middle]);
                        found.extend([a, b, c].map(neighbour));
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
