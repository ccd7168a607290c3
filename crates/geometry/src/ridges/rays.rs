//! Finds kinks of a map: edges at whose ends wavefronts arrive from different directions.

use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::fans::Fans;
use super::kink::{AtEnds, Kink, Segment};
use crate::MapError;
use crate::copies::Copies;
use crate::neighbourhood::Neighbourhood;
use geosweep_surface::{Chart, Direction, Edge, EdgeLengths, Real, ring, triangles};

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
/// divergence over the edge. With such a small divergence the ridge runs along the edge, and rounding decides
/// on which side of the edge it lies.
const ALONG: f64 = 0.1;

/// A map and the directions in which its wavefronts arrive, in bordered arrays.
pub(super) struct ArrivingRays<'a> {
    neighbourhood: Neighbourhood<'a>,
    copies: Copies,
    times: Vec<f32>,
    start: f64,
    arrivals: Arrivals,
}

/// The directions of first arrivals.
enum Arrivals {
    /// In the metric at each point of an open surface.
    InMetric(Vec<Ray>),
    /// In the triangles around each point of a glued surface.
    InFans(Fans),
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
    /// Finds the directions of first arrivals in a map.
    pub(super) fn new(edges: &'a EdgeLengths<f32>, distances: &[f32]) -> Result<Self, MapError> {
        let (copies, times) = Copies::with_times(edges, distances)?;
        let neighbourhood = Neighbourhood::new(edges);
        let start = f64::from(times.par_iter().copied().reduce(|| f32::FAR, f32::min));
        let arrivals = Arrivals::InMetric(Vec::new());
        let mut rays = Self { neighbourhood, copies, times, start, arrivals };
        rays.arrivals = if rays.copies.is_none() {
            let points = (0..rays.times.len()).into_par_iter().with_min_len(4096);
            Arrivals::InMetric(points.map(|point| rays.ray(point)).collect())
        } else {
            let first = |point| rays.first_ray(point);
            Arrivals::InFans(Fans::new(&rays.neighbourhood, &rays.copies, first))
        };
        Ok(rays)
    }

    fn is_reached(&self, point: usize) -> bool {
        self.times[point] < f32::FAR
    }

    /// Returns the first ray that arrives at a point from neighbours that are reached before the point: its time, its
    /// base, and where it crosses the base.
    fn first_ray(&self, point: usize) -> Option<(f64, usize, f64)> {
        if !self.is_reached(point) {
            return None;
        }
        let since = std::array::from_fn(|to| {
            let time = self.times[self.neighbourhood.neighbour(point, to)];
            if time < self.times[point] { f64::from(time) - self.start } else { f64::FAR }
        });
        self.neighbourhood.first_ray(point, &since)
    }

    /// Returns the first arrival at a point.
    fn ray(&self, point: usize) -> Ray {
        let Some((_, to, share)) = self.first_ray(point) else {
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

    /// Returns the directions of first arrivals at both ends of an edge. `third` is the third corner of a triangle with
    /// that edge. Returns `None` if one of the directions is not known.
    fn at_ends(&self, [from, to]: [Point; 2], third: Point) -> Option<AtEnds> {
        let rays = match &self.arrivals {
            Arrivals::InMetric(rays) => rays,
            Arrivals::InFans(fans) => {
                let [from, to, third] = [from, to, third].map(|point| point.index);
                let length = self.neighbourhood.length_between(from, to);
                return fans.at_ends(&self.copies, [from, to], third, length);
            }
        };
        let arrivals = [from, to].map(|end| rays[end.index]);
        let directions = arrivals.map(|arrival| arrival.direction.as_dvec2());
        let [rr, rc, cc] =
            (0.5 * (arrivals[0].metric.as_dvec3() + arrivals[1].metric.as_dvec3())).to_array();
        let metric = DMat2::from_cols_array(&[rr, rc, rc, cc]);
        let is_known = directions.iter().all(|direction| *direction != DVec2::ZERO);
        is_known.then_some(AtEnds { directions, metric, step: to.place - from.place })
    }

    /// Returns the kink on the edge between two neighbours, if there is one, and its node. The node is the
    /// edge, or a grid point through which the ridge passes. `third` is the third corner of a triangle with the edge.
    /// `cosine` is the cosine of the least angle.
    fn kink(&self, ends: [Point; 2], third: Point, cosine: f64) -> Option<(u64, Kink)> {
        let [from, to] = ends;
        let AtEnds { directions: [a, b], metric, step } = self.at_ends(ends, third)?;
        let (of_a, of_b) = (metric * a, metric * b);
        let (dot, squares) = (a.dot(of_b), a.dot(of_a) * b.dot(of_b));
        // The changes of both wavefronts' times from one end to the other.
        let [rise_a, rise_b] = [of_a, of_b].map(|slope| slope.dot(step));
        let between = dot / squares.sqrt();
        let apart = (a - b).dot(of_a - of_b) * step.dot(metric * step);
        let nearing = rise_a - rise_b;
        if between > cosine || nearing < -ALONG * apart.sqrt() {
            return None;
        }
        let [time_a, time_b] = ends.map(|end| f64::from(self.times[end.index]));
        let share = if nearing > 0.0 { (time_b - time_a - rise_b) / nearing } else { 0.5 };
        let share = match share {
            share if share < AT_POINT => 0.0,
            share if share > 1.0 - AT_POINT => 1.0,
            share => share,
        };
        let angle = between.clamp(-1.0, 1.0).acos();
        let place = from.place + share * (to.place - from.place);
        Some((self.node(ends, share), Kink { place, angle }))
    }

    /// Returns the node at a share of an edge, which is the same for all copies of the edge.
    fn node(&self, ends: [Point; 2], share: f64) -> u64 {
        let chart = self.neighbourhood.chart();
        let at_point = |point: Point| {
            Edge::end(chart) + 3 * chart.index_of(self.copies.first(point.index)) as u64
        };
        match share {
            0.0 => at_point(ends[0]),
            1.0 => at_point(ends[1]),
            _ => self.first_edge(ends.map(|end| end.index)),
        }
    }

    /// Returns the number of the first of all copies of an edge, which is given by its ends.
    fn first_edge(&self, [from, to]: [usize; 2]) -> u64 {
        let chart = self.neighbourhood.chart();
        let places = |point| self.copies.all(point).map(|copy| chart.bordered_position(copy));
        let pairs = places(from).flat_map(|from| places(to).map(move |to| (from, to)));
        let is_edge = |&(from, to): &((usize, usize), (usize, usize))| {
            from != to && from.0.abs_diff(to.0) <= 1 && from.1.abs_diff(to.1) <= 1
        };
        let number = |(from, to): ((usize, usize), (usize, usize))| {
            let [from, to] = [from, to].map(|(row, col)| chart.index(row, col));
            Edge::between(chart, from, to).number()
        };
        pairs.filter(is_edge).map(number).min().expect("the edge itself is one of its copies")
    }

    /// Returns an edge's ends in an order that is the same for all copies of the edge.
    fn in_order(&self, [a, b]: [Point; 2]) -> [Point; 2] {
        let is_turned = self.copies.first(a.index) > self.copies.first(b.index);
        if is_turned { [b, a] } else { [a, b] }
    }

    /// Returns the ridge segments in a row of cells: their nodes and the kinks there.
    pub(super) fn march(&self, row: usize, cosine: f64) -> Vec<Segment> {
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
                    let [a, b, third] = [k, k + 1, k + 2].map(|corner| triangle[corner % 3]);
                    let ends = self.in_order([points[a.min(b)], points[a.max(b)]]);
                    self.kink(ends, points[third], cosine)
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
