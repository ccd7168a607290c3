//! Determines on which side of a source curve each grid point lies.
//!
//! The computation propagates an angle along the wavefront's rays. The angle lies between the prolongation of
//! the curve at its end and the ray that leaves that end towards the point, positive to the left. It is a
//! quarter turn to the left or to the right beside the curve, and takes every value between these two around
//! an open end. Unlike a side, the angle changes smoothly where no wavefronts meet. So the line on which it
//! is zero stays on the prolongation and does not drift along the grid's directions. Between two points the
//! angle is interpolated with the times as weights, which is exact in the plane.
//!
//! All copies of a point of a glued surface have one angle. It comes from the copy at which the first ray arrives.

use std::collections::{HashMap, HashSet};

use glam::{DMat2, DVec2, Vec2};
use rayon::prelude::*;

use super::line::{Line, turned};
use crate::MapError;
use crate::copies::Copies;
use crate::neighbourhood::Neighbourhood;
use crate::order::by_arrival;
use geosweep_surface::{EdgeLengths, Real, Source, Sources, Surface, ring};

/// The angle at each point.
pub(crate) struct Sides<'a> {
    neighbourhood: Neighbourhood<'a>,
    copies: Copies,
    times: Vec<f32>,
    start: f64,
    /// The cosine and sine of each angle; NaN at points that have not been visited.
    angles: Vec<Vec2>,
    /// The first copies of the points whose angles have been measured: those beside curves and around their ends.
    beside: HashSet<usize>,
}

/// The first ray to arrive at a point: the ends of the base of the triangle that it crosses, and where it crosses that
/// base.
#[derive(Clone, Copy)]
struct Ray {
    base: [u32; 2],
    share: f32,
}

impl<'a> Sides<'a> {
    pub(crate) fn new(
        surface: &Surface,
        edges: &'a EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, MapError> {
        let (copies, times) = Copies::with_times(edges, distances)?;
        let order = by_arrival(&times);
        let angles = vec![Vec2::NAN; times.len()];
        let mut sides = Self {
            neighbourhood: Neighbourhood::new(edges),
            copies,
            times,
            start: sources.start(),
            angles,
            beside: HashSet::new(),
        };
        sides.measure(surface, sources)?;
        // The rays do not depend on the angles. Finding them takes the most time, so it runs in parallel.
        let ray = |point: usize| {
            let here = sides.rank(point);
            let is_before = |other: usize| sides.rank(other) < here;
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

    /// Measures the angles beside curves and around their ends.
    fn measure(&mut self, surface: &Surface, sources: &Sources) -> Result<(), MapError> {
        let mut seen = HashMap::new();
        for source in sources.iter() {
            let Source::Curve { vertices, initial } = source else { continue };
            let line = Line::new(surface, vertices);
            for ((row, col), is_seed) in line.beside(source)? {
                let point = self.neighbourhood.chart().bordered(row, col);
                let at = DVec2::new(row as f64, col as f64);
                let Some(nearest) = line.nearest(at, self.metric(surface, at, point)) else {
                    continue;
                };
                // If several curves are near, the curve whose wavefront reaches this point first is taken.
                let late = f64::from(self.times[point]) - initial - nearest.distance;
                // True if the map's wavefront came here from another curve or around an obstacle.
                let other =
                    !(-0.1..0.3).contains(&(late / nearest.distance.max(f64::MIN_POSITIVE)));
                if !is_seed && other {
                    continue;
                }
                let (late, first) = (late.abs(), self.copies.first(point));
                if seen.get(&first).is_none_or(|&other| late < other) {
                    seen.insert(first, late);
                    self.set(point, DVec2::from_angle(nearest.angle).as_vec2());
                }
            }
        }
        self.beside = seen.into_keys().collect();
        Ok(())
    }

    /// Returns the metric at a point, in the rows and columns at that point. It is the mean over all copies of the
    /// point at which the grid goes on over the seam.
    fn metric(&self, surface: &Surface, at: DVec2, point: usize) -> DMat2 {
        let chart = self.neighbourhood.chart();
        let of_copy = |copy: usize| {
            let (row, col) = chart.bordered_position(copy);
            let turn = match copy == point {
                true => DVec2::ONE,
                false => surface.turn_at_copy(at, DVec2::new(row as f64, col as f64))?,
            };
            Some(turned(self.neighbourhood.metric(copy), turn))
        };
        let all = self.copies.all(point).filter_map(of_copy);
        let (sum, count) =
            all.fold((DMat2::ZERO, 0.0), |(sum, count), metric| (sum + metric, count + 1.0));
        sum * (1.0 / count)
    }

    /// Sets the angle of a point and all its copies.
    fn set(&mut self, point: usize, angle: Vec2) {
        self.copies.all(point).for_each(|copy| self.angles[copy] = angle);
    }

    fn rank(&self, point: usize) -> u64 {
        self.copies.rank(&self.times, point)
    }

    fn is_known(&self, point: usize) -> bool {
        !self.angles[point].is_nan()
    }

    fn since(&self, point: usize) -> f64 {
        (f64::from(self.times[point]) - self.start).max(0.0)
    }

    /// Returns the first ray that arrives at a point, or at a copy of it, from those neighbours for which `counts` is
    /// true.
    fn ray(&self, point: usize, counts: impl Fn(usize) -> bool) -> Option<Ray> {
        let of_copy = |copy: usize| {
            let since = std::array::from_fn(|to| {
                let neighbour = self.neighbourhood.neighbour(copy, to);
                if counts(neighbour) { self.since(neighbour) } else { f64::FAR }
            });
            let (time, base, share) = self.neighbourhood.first_ray(copy, &since)?;
            let ends = [base, ring::next(base)];
            let base = ends.map(|to| self.neighbourhood.neighbour(copy, to) as u32);
            Some((time, Ray { base, share: share as f32 }))
        };
        let rays = self.copies.all(point).filter_map(of_copy);
        rays.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, ray)| ray)
    }

    /// Propagates the angle to a point whose earlier neighbours have been visited.
    fn visit(&mut self, point: usize, ray: Option<Ray>) {
        if self.is_known(point) {
            return;
        }
        let angle = ray.map(|ray| self.along(ray)).filter(|angle| !angle.is_nan());
        let angle = angle.or_else(|| {
            // A ray that comes from points without an angle does not count.
            let ray = self.ray(point, |other| self.is_known(other))?;
            Some(self.along(ray))
        });
        self.set(point, angle.unwrap_or(Vec2::NAN));
    }

    /// Returns the angle that a ray carries to a point.
    fn along(&self, Ray { base, share }: Ray) -> Vec2 {
        let ends = base.map(|end| end as usize);
        let [a, b] = ends.map(|end| self.angles[end]);
        let arm = |end: usize| self.since(end) * self.angles[end].as_dvec2();
        match share {
            0.0 => a,
            1.0 => b,
            _ if a == b => a,
            _ => arm(ends[0]).lerp(arm(ends[1]), f64::from(share)).normalize().as_vec2(),
        }
    }

    /// Returns whether each grid point, row-major, lies to the left of the nearest curve. Points that no curve reaches
    /// do not.
    pub(crate) fn are_left(&self) -> Vec<bool> {
        let chart = self.neighbourhood.chart();
        let at = |(row, col): (usize, usize)| self.is_left(chart.bordered(row, col)) == Some(true);
        chart.places().map(at).collect()
    }

    /// Returns a grid point beside which points on the left and on the right of curves are neighbours although no curve
    /// passes between them. There is none if the curves divide the surface.
    pub(crate) fn meeting(&self) -> Option<(usize, usize)> {
        let chart = self.neighbourhood.chart();
        chart.places().find(|&(row, col)| {
            let point = chart.bordered(row, col);
            self.is_left(point).is_some_and(|is_left| {
                // A curve passes only between points that it seeds.
                let is_beside = |point: usize| self.beside.contains(&self.copies.first(point));
                self.neighbourhood.neighbours(point).any(|other| {
                    let is_divided = is_beside(point) && is_beside(other);
                    self.is_left(other) == Some(!is_left) && !is_divided
                })
            })
        })
    }

    /// Returns whether a point lies to the left of the nearest curve, or `None` if it is not reached or lies on the
    /// curve.
    fn is_left(&self, point: usize) -> Option<bool> {
        let angle = self.angles[point];
        (!angle.is_nan() && angle.y != 0.0).then_some(angle.y > 0.0)
    }

    /// Returns the side at a place on the edge between two grid points, as an angle.
    pub(super) fn on_edge(&self, ends: [(usize, usize); 2], share: f64) -> f64 {
        let points = ends.map(|(row, col)| self.neighbourhood.chart().bordered(row, col));
        let [a, b] = points.map(|point| self.angles[point].as_dvec2().to_angle());
        let [since_a, since_b] = points.map(|point| f64::from(self.times[point]) - self.start);
        let length = self.neighbourhood.length_between(points[0], points[1]);
        // The curve passes between the two points. Times between those of the two points occur only on the later
        // point's side of the curve.
        if since_a + since_b <= 1.01 * length {
            return if since_a > since_b { a } else { b };
        }
        a + share * (b - a)
    }
}
