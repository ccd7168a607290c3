//! Determines on which side of a source curve each grid point lies.
//!
//! The computation propagates an angle along the wavefront's rays. The angle lies between the prolongation of
//! the curve at its end and the ray that leaves that end towards the point, positive to the left. It is a
//! quarter turn beside the curve and takes every value in between around an open end. Unlike a side, the
//! angle changes smoothly where no wavefronts meet; so the prolongation does not drift along the grid's
//! directions. Between two points the angle is interpolated with the times as weights, which is exact in the
//! plane.

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::FRAC_PI_2;

use glam::{DMat2, DVec2, Vec2};
use rayon::prelude::*;

use crate::geometry::MapError;
use crate::geometry::neighbourhood::Neighbourhood;
use crate::geometry::order::{bordered, by_arrival, rank};
use crate::surface::{EdgeLengths, Real, Source, Sources, Surface, UNGLUED, ring};

/// The angle at each point.
pub(super) struct Sides<'a> {
    neighbourhood: Neighbourhood<'a>,
    times: Vec<f32>,
    start: f64,
    /// The cosine and sine of each angle; NaN at points that have not been visited.
    angles: Vec<Vec2>,
}

/// The first ray to arrive at a point: the base of the triangle that it crosses, and where it crosses that
/// base.
#[derive(Clone, Copy)]
struct Ray {
    base: u8,
    share: f32,
}

/// The number of rows and columns around an open end in which angles are measured instead of propagated. The
/// curvature of the wavefront jumps there, and the error of the map turns the rays nearby.
const AROUND_END: usize = 8;

impl<'a> Sides<'a> {
    pub(super) fn new(
        surface: &Surface,
        edges: &'a EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, MapError> {
        surface.check_open("the side of a curve", UNGLUED)?;
        let times = bordered(edges.chart(), distances)?;
        let order = by_arrival(&times);
        let angles = vec![Vec2::NAN; times.len()];
        let mut sides = Self {
            neighbourhood: Neighbourhood::new(edges),
            times,
            start: sources.start(),
            angles,
        };
        let mut seen = HashMap::new();
        for source in sources.iter() {
            let Source::Curve { vertices, initial } = source else { continue };
            for ((row, col), is_seed) in beside(surface, source)? {
                let point = sides.neighbourhood.chart().bordered(row, col);
                let at = DVec2::new(row as f64, col as f64);
                let Some(nearest) = nearest(vertices, at, sides.neighbourhood.metric(point)) else {
                    continue;
                };
                // If several curves are near, the curve whose wavefront reaches this point first is taken.
                let late = f64::from(sides.times[point]) - initial - nearest.distance;
                // Here the map's wavefront came from another curve or around an obstacle.
                let other =
                    !(-0.1..0.3).contains(&(late / nearest.distance.max(f64::MIN_POSITIVE)));
                if !is_seed && other {
                    continue;
                }
                let late = late.abs();
                if seen.get(&point).is_none_or(|&other| late < other) {
                    seen.insert(point, late);
                    sides.angles[point] = DVec2::from_angle(nearest.angle).as_vec2();
                }
            }
        }
        // The rays do not depend on the angles. Finding them takes the most time, so it runs in parallel.
        let ray = |point: usize| {
            let here = rank(sides.times[point], point);
            let is_before = |other: usize| rank(sides.times[other], other) < here;
            let is_wanted = sides.times[point] < f32::FAR && !sides.is_known(point);
            is_wanted
                .then(|| sides.ray(point, |other| is_before(other) || sides.is_known(other)))?
        };
        let points = (0..sides.times.len()).into_par_iter().with_min_len(4096);
        let rays: Vec<Option<Ray>> = points.map(ray).collect();
        for point in order {
            sides.visit(point as usize, rays[point as usize]);
        }
        Ok(sides)
    }

    fn is_known(&self, point: usize) -> bool {
        !self.angles[point].is_nan()
    }

    fn since(&self, point: usize) -> f64 {
        (f64::from(self.times[point]) - self.start).max(0.0)
    }

    /// Returns the first ray that arrives at a point from those neighbours for which `counts` is true.
    fn ray(&self, point: usize, counts: impl Fn(usize) -> bool) -> Option<Ray> {
        let since = std::array::from_fn(|to| {
            let neighbour = self.neighbourhood.neighbour(point, to);
            if counts(neighbour) { self.since(neighbour) } else { f64::FAR }
        });
        self.neighbourhood
            .first_ray(point, &since)
            .map(|(_, base, share)| Ray { base: base as u8, share: share as f32 })
    }

    /// Propagates the angle to a point whose earlier neighbours have been visited.
    fn visit(&mut self, point: usize, ray: Option<Ray>) {
        if self.is_known(point) {
            return;
        }
        let angle = ray.map(|ray| self.along(point, ray)).filter(|angle| !angle.is_nan());
        let angle = angle.or_else(|| {
            // A ray that comes from points without an angle does not count.
            let ray = self.ray(point, |other| self.is_known(other))?;
            Some(self.along(point, ray))
        });
        self.angles[point] = angle.unwrap_or(Vec2::NAN);
    }

    /// Returns the angle that a ray carries to a point.
    fn along(&self, point: usize, Ray { base, share }: Ray) -> Vec2 {
        let ends = [usize::from(base), ring::next(base.into())]
            .map(|to| self.neighbourhood.neighbour(point, to));
        let [a, b] = ends.map(|end| self.angles[end]);
        let arm = |end: usize| self.since(end) * self.angles[end].as_dvec2();
        match share {
            0.0 => a,
            1.0 => b,
            _ if a == b => a,
            _ => arm(ends[0]).lerp(arm(ends[1]), f64::from(share)).normalize().as_vec2(),
        }
    }

    /// Returns the side at a place on the edge between two grid points, as an angle.
    pub(super) fn on_edge(&self, ends: [(usize, usize); 2], share: f64) -> f64 {
        let points = ends.map(|(row, col)| self.neighbourhood.chart().bordered(row, col));
        let [a, b] = points.map(|point| self.angles[point].as_dvec2().to_angle());
        let [since_a, since_b] = points.map(|point| f64::from(self.times[point]) - self.start);
        let to = |to: &usize| self.neighbourhood.neighbour(points[0], *to) == points[1];
        let length = (0..8).find(to).map_or(0.0, |to| self.neighbourhood.length(points[0], to));
        // The curve itself lies between the two points. The map decreases towards it from the later point.
        if since_a + since_b <= 1.01 * length {
            return if since_a > since_b { a } else { b };
        }
        a + share * (b - a)
    }
}

/// Returns the grid points at which the angle is measured: the points that the curve seeds (true), and points
/// around its ends (false). The latter do not count if another source is nearer.
fn beside(surface: &Surface, source: &Source) -> Result<BTreeMap<(usize, usize), bool>, MapError> {
    let Source::Curve { vertices, .. } = source else { return Ok(BTreeMap::new()) };
    let mut points = BTreeMap::new();
    for end in [vertices.first(), vertices.last()].into_iter().flatten() {
        let all = surface.chart().around_place(*end, AROUND_END).places();
        points.extend(all.filter(|&(row, col)| surface.has(row, col)).map(|at| (at, false)));
    }
    let seeds = Sources::from_iter([source.clone()]).seeds(surface)?;
    points.extend(seeds.iter().map(|seed| ((seed.row, seed.col), true)));
    Ok(points)
}

/// The place on a curve nearest to a point, as the distance and the angle there.
struct Foot {
    distance: f64,
    angle: f64,
}

/// Returns the nearest place on a curve, as if the surface were flat around the point.
fn nearest(vertices: &[DVec2], at: DVec2, metric: DMat2) -> Option<Foot> {
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
    // Positive to the left of `along`, with rows downwards.
    let left = |along: DVec2, away: DVec2| along.x * away.y - along.y * away.x;
    let (last, here) = (vertices.len() - 2, direction(index));
    let closed = vertices[0] == vertices[vertices.len() - 1];
    let away = at - vertices[index].lerp(vertices[index + 1], share);
    let other = match share {
        0.0 if index > 0 => Some(direction(index - 1)),
        1.0 if index < last => Some(direction(index + 1)),
        0.0 if closed => Some(direction(last)),
        1.0 if closed => Some(direction(0)),
        // The nearest place is an open end of the curve.
        0.0 | 1.0 => None,
        _ => Some(here),
    };
    let angle = match other {
        _ if distance == 0.0 => 0.0,
        // At a corner of the curve, the two adjoining segments together decide the side.
        Some(other) => FRAC_PI_2.copysign(left(here + other, away)),
        None => {
            let outwards = if share == 0.0 { -here } else { here };
            let cosine = dot(outwards, away) / distance;
            cosine.clamp(0.0, 1.0).acos().copysign(left(here, away))
        }
    };
    Some(Foot { distance, angle })
}
