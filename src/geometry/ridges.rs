//! Where fronts meet: the map's kinks, the cut locus of its sources.

use std::collections::BTreeMap;

use glam::{DMat2, DVec2};
use rayon::prelude::*;

use super::chains::ways;
use super::order::bordered;
use super::spokes::Spokes;
use super::triangles::{Edge, corners, triangles};
use super::{Curve, MapError};
use crate::surface::{Chart, Direction, EdgeLengths, Real};

/// A line on which fronts from different directions meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Ridge {
    /// The line, from end to end or junction to junction; its direction means nothing.
    pub curve: Curve,
    /// The angle between the fronts' directions at each vertex, in degrees, from `least_angle` to
    /// 180, where they meet head-on.
    pub angles: Vec<f64>,
}

/// A kink on an edge of the grid.
#[derive(Clone, Copy, Debug)]
struct Kink {
    place: DVec2,
    angle: f64,
}

/// The lines on which a converged map has a kink since fronts meet there at an angle of at least
/// `least_angle` degrees: borders between sources as well as the cut locus of each, behind holes
/// and hills and between the parts of a curve. The `edges` are the surface's.
///
/// The criterion: at each grid point the direction is that of the ray that brings the first front,
/// over the base of one of its triangles, never across a kink. An edge has a kink if the directions
/// at its ends, in the metric between them, include at least the least angle and run towards one
/// another; it lies where both fronts, straight on from either end, arrive at once. Ridges run
/// through triangles from edge to edge with a kink; where all three edges have one they meet at
/// the middle of the three places.
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
    let field = Field::new(edges, times);
    let rows = (0..chart.rows.saturating_sub(1)).into_par_iter();
    let found: Vec<([u64; 2], [Kink; 2])> =
        rows.flat_map_iter(|row| field.march(row, least_angle)).collect();
    let mut kinks: BTreeMap<u64, Kink> = BTreeMap::new();
    for (nodes, ends) in &found {
        kinks.extend(nodes.iter().copied().zip(ends.iter().copied()));
    }
    let segments: Vec<[u64; 2]> = found.iter().map(|(nodes, _)| *nodes).collect();
    let ridge = |way: Vec<u64>| {
        let closed = way.len() > 3 && way[0] == way[way.len() - 1];
        let way = if closed { &way[1..] } else { &way[..] };
        let vertices = way.iter().map(|node| kinks[node].place.to_array()).collect();
        let angles = way.iter().map(|node| kinks[node].angle.to_degrees()).collect();
        Ridge { curve: Curve { vertices, closed }, angles }
    };
    Ok(ways(&segments).into_iter().map(ridge).collect())
}

/// A map, and the directions in which its fronts arrive.
struct Field<'a> {
    spokes: Spokes<'a>,
    times: Vec<f32>,
    start: f64,
    /// In steps of rows and columns, of length one on the surface; zero at sources and where no
    /// front arrives.
    directions: Vec<DVec2>,
}

impl<'a> Field<'a> {
    fn new(edges: &'a EdgeLengths<f32>, times: Vec<f32>) -> Self {
        let spokes = Spokes::new(edges);
        let start = f64::from(times.par_iter().copied().reduce(|| f32::FAR, f32::min));
        let mut field = Self { spokes, times, start, directions: Vec::new() };
        let points = 0..field.times.len();
        field.directions = points.into_par_iter().map(|point| field.direction(point)).collect();
        field
    }

    fn is_reached(&self, point: usize) -> bool {
        self.times[point] < f32::FAR
    }

    /// The direction in which the first front arrives at a point over bases that it has passed.
    fn direction(&self, point: usize) -> DVec2 {
        if !self.is_reached(point) {
            return DVec2::ZERO;
        }
        let since = |to: usize| {
            let time = self.times[self.spokes.neighbour(point, to)];
            if time < self.times[point] { f64::from(time) - self.start } else { f64::FAR }
        };
        let step = |to: usize| {
            let (down, right) = Direction::ALL[to % 8].step();
            DVec2::new(down as f64, right as f64)
        };
        let ray = |to: usize| {
            let (time, share) = self.spokes.ray(point, to, [since(to), since((to + 1) % 8)])?;
            Some((time, -step(to).lerp(step(to + 1), share)))
        };
        let first = (0..8).filter_map(ray).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, direction)) = first else { return DVec2::ZERO };
        let length = direction.dot(self.spokes.metric(point) * direction).sqrt();
        if length > 0.0 { direction / length } else { DVec2::ZERO }
    }

    /// The kink on the edge between two neighbours, if there is one.
    fn kink(&self, ends: [usize; 2], least_angle: f64) -> Option<Kink> {
        let chart = self.spokes.chart();
        let points = ends.map(|index| {
            let (row, col) = chart.position(index);
            chart.bordered(row, col)
        });
        let [a, b] = points.map(|point| self.directions[point]);
        if a == DVec2::ZERO || b == DVec2::ZERO {
            return None;
        }
        let metric: DMat2 = (self.spokes.metric(points[0]) + self.spokes.metric(points[1])) * 0.5;
        let (of_a, of_b) = (metric * a, metric * b);
        let cosine = a.dot(of_b) / (a.dot(of_a) * b.dot(of_b)).sqrt();
        let angle = cosine.clamp(-1.0, 1.0).acos();
        let [from, to] = ends.map(|index| place(chart, index));
        // By how much the fronts' times would change from end to end.
        let [rise_a, rise_b] = [of_a, of_b].map(|slope| slope.dot(to - from));
        if angle < least_angle.to_radians() || rise_a <= rise_b {
            return None;
        }
        let [time_a, time_b] = points.map(|point| f64::from(self.times[point]));
        let share = ((time_b - time_a - rise_b) / (rise_a - rise_b)).clamp(0.0, 1.0);
        Some(Kink { place: from.lerp(to, share), angle })
    }

    /// The pieces of ridges in a row of cells: nodes and what is there.
    fn march(&self, row: usize, least_angle: f64) -> Vec<([u64; 2], [Kink; 2])> {
        let chart = self.spokes.chart();
        let reached = |index: usize| {
            let (row, col) = chart.position(index);
            self.is_reached(chart.bordered(row, col))
        };
        let mut found = Vec::new();
        for col in 0..chart.cols.saturating_sub(1) {
            let corners = corners(chart, row, col);
            let triangles = triangles(corners.map(reached), true);
            for (number, triangle) in triangles.iter().enumerate() {
                let kink = |k: usize| {
                    let ends = [triangle[k], triangle[(k + 1) % 3]].map(|corner| corners[corner]);
                    let kink =
                        self.kink([ends[0].min(ends[1]), ends[0].max(ends[1])], least_angle)?;
                    Some((Edge::between(chart, ends[0], ends[1]).number(), kink))
                };
                let kinks: Vec<(u64, Kink)> = (0..3).filter_map(kink).collect();
                match kinks[..] {
                    [(a, at_a), (b, at_b)] => found.push(([a, b], [at_a, at_b])),
                    [(_, a), (_, b), (_, c)] => {
                        let middle = Kink {
                            place: (a.place + b.place + c.place) / 3.0,
                            angle: a.angle.max(b.angle).max(c.angle),
                        };
                        let node = Edge::end(chart) + 2 * corners[0] as u64 + number as u64;
                        let spoke = |(edge, kink)| ([edge, node], [kink, middle]);
                        found.extend(kinks.into_iter().map(spoke));
                    }
                    _ => {}
                }
            }
        }
        found
    }
}

fn place(chart: Chart, index: usize) -> DVec2 {
    let (row, col) = chart.position(index);
    DVec2::new(row as f64, col as f64)
}
