//! All geodesics from a place, represented by rays that are followed in steps of one length.

use std::f64::consts::TAU;

use glam::DVec2;
use rayon::prelude::*;

use super::bounds::Bounds;
use super::domain::is_followed;
use super::patch::{Knot, quintic};
use super::ray::{Frame, Position, Ray};
use crate::builtin::jet::Jet;

/// Number of arcs into which the fan is split at first.
pub(super) const ARCS: usize = 64;

/// All geodesics from a place.
pub(super) struct Fan<P> {
    pub(super) position: P,
    pub(super) from: DVec2,
    start: Frame,
    /// Accuracy of (u, v).
    pub(super) tolerance: f64,
    /// Length of a step along the rays.
    pub(super) step: f64,
    /// Upper bound of all distances.
    longest: f64,
    bounds: Bounds,
}

impl<P: Position> Fan<P> {
    pub(super) fn new(position: P, from: DVec2, tolerance: f64) -> Self {
        let start = Frame::new(position(Jet::variables(from)));
        let longest = longest(&position, from);
        let ray = |angle| Ray::start(from, &start, angle);
        let bounds = Bounds::new(&position, ray, longest);
        let step = longest / 32.0;
        let mut fan = Self { position, from, start, tolerance, step, longest, bounds };
        while fan.error_of_steps() > tolerance {
            fan.step *= 0.5;
        }
        fan
    }

    pub(super) fn ray(&self, angle: f64) -> Ray {
        Ray::start(self.from, &self.start, angle)
    }

    pub(super) fn most_steps(&self) -> usize {
        (self.longest / self.step).ceil() as usize
    }

    /// Returns whether no shortest path continues along a ray after `steps` steps.
    pub(super) fn ends(&self, ray: &Ray, steps: usize) -> bool {
        !is_followed(ray) || self.bounds.exclude(steps as f64 * self.step, ray.at)
    }

    /// Estimates the difference between rays and polynomials over a step, from polynomials over two steps.
    fn error_of_steps(&self) -> f64 {
        let angles = (0..ARCS).into_par_iter().map(|arc| TAU * arc as f64 / ARCS as f64);
        let errors = angles.map(|angle| {
            let mut ray = self.ray(angle);
            let mut knots = Vec::new();
            while knots.len() < 3
                || knots.len() <= self.most_steps() && !self.ends(&ray, knots.len())
            {
                let derivative = ray.derivative(&self.position);
                let double = 2.0 * self.step;
                knots.push(Knot {
                    value: ray.at,
                    first: double * ray.heading,
                    second: double * double * derivative.heading,
                });
                ray = ray.advance(derivative, self.step, &self.position);
            }
            let error = |three: &[Knot]| {
                let between = quintic(three[0], three[2]);
                let middle = between.iter().rev().fold(DVec2::ZERO, |sum, &c| 0.5 * sum + c);
                (middle - three[1].value).abs().max_element()
            };
            // The error is proportional to the sixth power of the step.
            knots.windows(3).map(error).fold(0.0, f64::max) / 64.0
        });
        errors.reduce(|| 0.0, f64::max)
    }
}

/// Returns a bound on all distances: the length of the longest path that is straight in the unit square. The
/// longest path ends at the square's border.
fn longest(position: &impl Position, from: DVec2) -> f64 {
    const SAMPLES: usize = 64;
    let fraction = |k: usize| k as f64 / SAMPLES as f64;
    let border = (0..=SAMPLES).map(fraction).flat_map(|x| {
        [DVec2::new(x, 0.0), DVec2::new(x, 1.0), DVec2::new(0.0, x), DVec2::new(1.0, x)]
    });
    let length = |to: DVec2| {
        let piece = |k: usize| {
            let at = from.lerp(to, fraction(k) + 0.5 / SAMPLES as f64);
            Frame::new(position(Jet::variables(at))).length(to - from) / SAMPLES as f64
        };
        (0..SAMPLES).map(piece).sum::<f64>()
    };
    // The factor covers the error of sums over samples.
    1.1 * border.map(length).fold(0.0, f64::max)
}
