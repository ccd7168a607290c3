//! On which side of a source curve each point lies.
//!
//! What is carried along the fronts' way is the angle between the prolongation of the curve at its
//! end and the ray that leaves that end towards the point, positive to the left: a quarter turn
//! beside the curve, and anything between around an open end. Unlike a side it changes smoothly
//! where no fronts meet, so that the prolongation does not drift along the grid's directions.
//! Between two points in whose times it is weighted it is exact in the plane.

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::FRAC_PI_2;

use glam::{DMat2, DVec2};

use crate::geometry::MapError;
use crate::geometry::order::{bordered, by_arrival};
use crate::geometry::spokes::Spokes;
use crate::surface::{Chart, EdgeLengths, Real, Source, Sources, Surface};

/// Angles by point.
pub(super) struct Sides<'a> {
    spokes: Spokes<'a>,
    times: Vec<f32>,
    start: f64,
    /// NaN at points that are not visited.
    angles: Vec<f32>,
}

/// Rows and columns around an open end in which angles are measured, not carried: the map's own
/// error where the front's bend jumps turns its rays nearby.
const AROUND_END: usize = 8;

impl<'a> Sides<'a> {
    pub(super) fn new(
        surface: &Surface,
        edges: &'a EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, MapError> {
        let times = bordered(edges.chart(), distances)?;
        let order = by_arrival(&times);
        let angles = vec![f32::NAN; times.len()];
        let mut sides = Self { spokes: Spokes::new(edges), times, start: sources.start(), angles };
        let mut seen = HashMap::new();
        for source in sources.iter() {
            let Source::Curve { vertices, initial } = source else { continue };
            for ((row, col), is_seed) in beside(surface, source)? {
                let point = sides.spokes.chart().bordered(row, col);
                let at = DVec2::new(row as f64, col as f64);
                let Some(nearest) = nearest(vertices, at, sides.spokes.metric(point)) else {
                    continue;
                };
                // Of several curves the one that the map's front came from.
                let late = f64::from(sides.times[point]) - initial - nearest.distance;
                // The map's front came from somewhere else, or around something.
                let other =
                    !(-0.1..0.3).contains(&(late / nearest.distance.max(f64::MIN_POSITIVE)));
                if !is_seed && other {
                    continue;
                }
                let late = late.abs();
                if seen.get(&point).is_none_or(|&other| late < other) {
                    seen.insert(point, late);
                    sides.angles[point] = nearest.angle as f32;
                }
            }
        }
        for point in order {
            sides.visit(point as usize);
        }
        Ok(sides)
    }

    /// Carries the angle to a point whose earlier neighbours have been visited.
    fn visit(&mut self, point: usize) {
        if !self.angles[point].is_nan() {
            return;
        }
        let angles: [f32; 8] =
            std::array::from_fn(|to| self.angles[self.spokes.neighbour(point, to)]);
        let known = || angles.iter().copied().filter(|angle| !angle.is_nan());
        if let Some(first) = known().next()
            && known().all(|angle| angle == first)
        {
            self.angles[point] = first;
            return;
        }
        let since = |to: usize| {
            let time = f64::from(self.times[self.spokes.neighbour(point, to)]) - self.start;
            if angles[to].is_nan() { f64::FAR } else { time.max(0.0) }
        };
        let since: [f64; 8] = std::array::from_fn(since);
        let Some((_, to, share)) = self.spokes.first_ray(point, &since) else { return };
        let ends = [to, (to + 1) % 8];
        let arm = |to: usize| since[to] * DVec2::from_angle(f64::from(angles[to]));
        self.angles[point] = match share {
            0.0 => angles[ends[0]],
            1.0 => angles[ends[1]],
            _ => arm(ends[0]).lerp(arm(ends[1]), share).to_angle() as f32,
        };
    }

    /// The side at a place on the edge between two grid points, as an angle.
    pub(super) fn on_edge(&self, ends: [(usize, usize); 2], share: f64) -> f64 {
        let points = ends.map(|(row, col)| self.spokes.chart().bordered(row, col));
        let [a, b] = points.map(|point| f64::from(self.angles[point]));
        let [since_a, since_b] = points.map(|point| f64::from(self.times[point]) - self.start);
        let to = |to: &usize| self.spokes.neighbour(points[0], *to) == points[1];
        let length = (0..8).find(to).map_or(0.0, |to| self.spokes.length(points[0], to));
        // The curve itself lies between them; the map falls towards it from the later end.
        if since_a + since_b <= 1.01 * length {
            return if since_a > since_b { a } else { b };
        }
        a + share * (b - a)
    }
}

/// The grid points at which the angle is measured: those that the curve seeds (true), and those
/// around its ends, unless something else is nearer.
fn beside(surface: &Surface, source: &Source) -> Result<BTreeMap<(usize, usize), bool>, MapError> {
    let Source::Curve { vertices, .. } = source else { return Ok(BTreeMap::new()) };
    let Chart { rows, cols } = surface.chart();
    let mut points = BTreeMap::new();
    for end in [vertices.first(), vertices.last()].into_iter().flatten() {
        let around = |x: f64, count: usize| {
            let low = (x.floor().max(0.0) as usize).saturating_sub(AROUND_END);
            low..(x.ceil().max(0.0) as usize + AROUND_END + 1).min(count)
        };
        let all =
            around(end.x, rows).flat_map(|row| around(end.y, cols).map(move |col| (row, col)));
        points.extend(all.filter(|&(row, col)| surface.has(row, col)).map(|at| (at, false)));
    }
    let seeds = Sources::from_iter([source.clone()]).seeds(surface)?;
    points.extend(seeds.iter().map(|seed| ((seed.row, seed.col), true)));
    Ok(points)
}

/// The place of a curve that is nearest to a point.
struct Nearest {
    distance: f64,
    angle: f64,
}

/// As if the surface were flat around the point.
fn nearest(vertices: &[DVec2], at: DVec2, metric: DMat2) -> Option<Nearest> {
    let dot = |a: DVec2, b: DVec2| a.dot(metric * b);
    let near = |a: &DVec2, b: &DVec2| {
        const REACH: f64 = 2.0 + AROUND_END as f64;
        let (low, high) = (a.min(*b) - REACH, a.max(*b) + REACH);
        at.cmpge(low).all() && at.cmple(high).all()
    };
    let foot = |(index, ends): (usize, &[DVec2])| {
        let (along, from) = (ends[1] - ends[0], at - ends[0]);
        if dot(along, along) <= 0.0 || !near(&ends[0], &ends[1]) {
            return None;
        }
        let share = (dot(from, along) / dot(along, along)).clamp(0.0, 1.0);
        let away = from - share * along;
        Some((dot(away, away), index, share))
    };
    let feet = vertices.windows(2).enumerate().filter_map(foot);
    let (square, index, share) = feet.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let distance = square.max(0.0).sqrt();
    let direction = |index: usize| {
        let along = vertices[index + 1] - vertices[index];
        let length = dot(along, along).sqrt();
        if length > 0.0 { along / length } else { DVec2::ZERO }
    };
    // Positive to the left of a direction, with rows downwards.
    let left = |along: DVec2, away: DVec2| along.x * away.y - along.y * away.x;
    let (last, here) = (vertices.len() - 2, direction(index));
    let closed = vertices[0] == vertices[vertices.len() - 1];
    let away = at - vertices[index].lerp(vertices[index + 1], share);
    let other = match share {
        0.0 if index > 0 => Some(direction(index - 1)),
        1.0 if index < last => Some(direction(index + 1)),
        0.0 if closed => Some(direction(last)),
        1.0 if closed => Some(direction(0)),
        // An open end.
        0.0 | 1.0 => None,
        _ => Some(here),
    };
    let angle = match other {
        _ if distance == 0.0 => 0.0,
        // At a corner the side is that of both pieces together.
        Some(other) => FRAC_PI_2.copysign(left(here + other, away)),
        None => {
            let outwards = if share == 0.0 { -here } else { here };
            let cosine = dot(outwards, away) / distance;
            cosine.clamp(0.0, 1.0).acos().copysign(left(here, away))
        }
    };
    Some(Nearest { distance, angle })
}
