//! Computes distances by shooting geodesics, for surfaces that have no closed form.
//!
//! This computation is independent of the solvers. Of the grid, it uses only the points whose distances are wanted.
//! Geodesics leave the source in all directions. They are solutions of their differential equation, whose coefficients
//! are exact derivatives of the parametrisation. Over an arc of directions and a step of length, (u, v) is a polynomial
//! in angle and length. Steps and arcs are halved until the polynomial is accurate. For each grid point Newton's method
//! finds the angle and the length at which geodesics arrive. The distance is the length of the shortest one.
//!
//! The result is the distance within the patch: geodesics that leave it do not count. Where the patch's border is bent
//! inwards, the shortest path may run along the border, which is not a geodesic. A geodesic that crosses the border
//! there is shorter than that path. So geodesics are followed a little beyond the border. Where the shortest geodesic
//! found has been outside the patch, the distance is not known.

mod arrivals;
mod bounds;
mod domain;
mod fan;
mod panel;
mod patch;
mod ray;

use std::f64::consts::TAU;

use glam::DVec2;
use rayon::prelude::*;

use arrivals::Arrivals;
use fan::{ARCS, Fan};
use panel::Panel;
use ray::Position;

/// Maximum number of halvings of an arc. Points that only a finer arc would reach remain unknown.
const MOST_HALVINGS: u32 = 24;
/// Largest estimated error of (u, v) on a ray. Both run from 0 to 1 over the patch.
const TOLERANCE: f64 = 1e-10;

/// Returns the distances from a place (u, v) to the points of a grid over the unit square, row-major, within
/// the surface with the given parametrisation. They are NaN where they are not known.
pub(super) fn distances<P: Position>(
    position: P,
    rows: usize,
    cols: usize,
    from: DVec2,
) -> Vec<f64> {
    Fan::new(position, from, TOLERANCE).distances(rows, cols)
}

impl<P: Position> Fan<P> {
    fn distances(&self, rows: usize, cols: usize) -> Vec<f64> {
        let arrivals = Arrivals::new(rows, cols);
        (0..rows * cols)
            .filter(|&point| arrivals.place(point) == self.from)
            .for_each(|point| arrivals.enter(point, 0.0, || true));
        let arcs = (0..ARCS).into_par_iter().map(|arc| arc as f64 * TAU / ARCS as f64);
        arcs.for_each(|first| self.fill([first, first + TAU / ARCS as f64], 0, &arrivals));
        arrivals.distances()
    }

    /// Records the points that the rays of an arc reach. Halves the arc if polynomials across it cannot represent its
    /// rays.
    fn fill(&self, arc: [f64; 2], halvings: u32, arrivals: &Arrivals) {
        if let Some(panel) = Panel::shoot(self, arc) {
            panel.arrive(arrivals);
        } else if halvings < MOST_HALVINGS {
            let middle = 0.5 * (arc[0] + arc[1]);
            rayon::join(
                || self.fill([arc[0], middle], halvings + 1, arrivals),
                || self.fill([middle, arc[1]], halvings + 1, arrivals),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ray::{Frame, Ray};
    use super::*;
    use crate::builtin::Builtin;
    use crate::builtin::jet::Jet;

    const FROM: DVec2 = DVec2::new(0.40625, 0.3125);

    fn shot(builtin: Builtin, points: usize, tolerance: f64) -> Vec<f64> {
        let position = |uv: [Jet; 2]| builtin.position(uv);
        Fan::new(position, FROM, tolerance).distances(points, points)
    }

    fn exact(builtin: Builtin, points: usize) -> Vec<f64> {
        let from = [FROM.y, FROM.x].map(|fraction| fraction * (points - 1) as f64);
        builtin.exact_distances(points, points, from).unwrap()
    }

    /// Returns the largest relative difference. It is infinite where exactly one value is NaN.
    fn difference(a: &[f64], b: &[f64]) -> f64 {
        let of_pair = |(a, b): (&f64, &f64)| match (a.is_nan(), b.is_nan()) {
            (false, false) => (a - b).abs() / b.max(f64::MIN_POSITIVE),
            (true, true) => 0.0,
            _ => f64::INFINITY,
        };
        a.iter().zip(b).map(of_pair).fold(0.0, f64::max)
    }

    #[test]
    fn closed_forms_are_met() {
        // Measured: 8e-11 on the sphere, only rounding on the surfaces that unroll into a plane.
        let sheared = Builtin::ShearedPlane { degrees: 60.0 };
        for builtin in [Builtin::Plane, sheared, Builtin::Sphere, Builtin::Cylinder] {
            let difference = difference(&shot(builtin, 97, TOLERANCE), &exact(builtin, 97));
            println!("{builtin}: {difference:e}");
            assert!(difference < 1e-9, "{builtin}: {difference:e}");
        }
    }

    #[test]
    fn paths_along_a_border_are_not_known() {
        // The cone's inner border is bent inwards: in the unrolled cone, straight lines cross it.
        let points = 65;
        let fraction = |k: usize| k as f64 / (points - 1) as f64;
        let mut unknown = 0;
        let (shot, exact) = (shot(Builtin::Cone, points, TOLERANCE), exact(Builtin::Cone, points));
        for (index, (shot, exact)) in shot.into_iter().zip(exact).enumerate() {
            let (u, v) = (fraction(index % points), fraction(index / points));
            let angle = 0.75 * std::f64::consts::PI * (u - FROM.x).abs();
            let [r1, r2] = [0.5 + v, 0.5 + FROM.y];
            let straight = (r1 - r2).hypot(2.0 * (r1 * r2).sqrt() * (0.5 * angle).sin());
            if shot.is_nan() {
                unknown += 1;
                assert!(exact > straight, "{u} {v}");
            } else {
                approx::assert_relative_eq!(shot, exact, max_relative = 1e-9);
            }
        }
        assert_eq!(unknown, 31);
    }

    #[test]
    fn finer_steps_and_more_rays_change_nothing() {
        // Measured: 9e-11 and 6e-11. A hundredth of the tolerance halves the steps at least once.
        for builtin in [Builtin::Torus, Builtin::Peaks] {
            let [coarse, fine] = [1.0, 0.01].map(|f| shot(builtin, 65, f * TOLERANCE));
            let difference = difference(&coarse, &fine);
            println!("{builtin}: {difference:e}");
            assert!(difference < 1e-9, "{builtin}: {difference:e}");
            assert!(coarse.iter().all(|distance| distance.is_finite()), "{builtin}");
        }
    }

    #[test]
    fn no_arrival_is_missed() {
        // A point whose first arrival is missed has a later one, or none. The distance would then jump by
        // more than the path from its neighbour.
        let points = 129;
        for builtin in [Builtin::Torus, Builtin::Peaks] {
            let surface = builtin.surface(points, points).unwrap();
            let shot = shot(builtin, points, TOLERANCE);
            for (row, col) in (1..points).flat_map(|row| (1..points).map(move |col| (row, col))) {
                let here = surface.position(row, col).unwrap();
                for (r, c) in [(row - 1, col), (row, col - 1)] {
                    let jump = (shot[row * points + col] - shot[r * points + c]).abs();
                    let chord = here.distance(surface.position(r, c).unwrap());
                    // Arcs are longer than chords by less than this.
                    assert!(jump <= 1.01 * chord, "{builtin} {row},{col}: {jump} {chord}");
                }
            }
        }
    }

    #[test]
    fn rays_part_as_the_sphere_says() {
        let position = |uv: [Jet; 2]| Builtin::Sphere.position(uv);
        let start = Frame::new(position(Jet::variables(FROM)));
        approx::assert_relative_eq!(start.curvature(), 1.0, max_relative = 1e-12);
        let mut ray = Ray::start(FROM, &start, 1.0);
        for _ in 0..20 {
            ray = ray.advance(ray.derivative(&position), 0.02, &position);
        }
        // On the unit sphere J = sin s, and rays have unit speed. The error of both is of the sixth order in the step.
        approx::assert_relative_eq!(ray.spread, 0.4f64.sin(), max_relative = 1e-11);
        let there = Frame::new(position(Jet::variables(ray.at)));
        approx::assert_relative_eq!(there.length(ray.heading), 1.0, max_relative = 1e-10);
    }
}
