//! Shoots a panel of neighbouring rays, from the source to the end of the longest.

use glam::DVec2;

use super::arrivals::Arrivals;
use super::domain::is_inside;
use super::fan::Fan;
use super::patch::{self, Cosines, Knot, Patch, RAYS};
use super::ray::{Position, Ray};

/// The rays of an arc of directions, as one patch for each step.
pub(super) struct Panel {
    pub(super) patches: Vec<Patch>,
    /// Length of a step.
    step: f64,
}

/// Number of quadrangles across the rays into which a patch is divided for first guesses.
const ACROSS: usize = 4;
/// Distance beyond each triangle, relative to it, up to which guesses are made. The triangles are flat, the
/// patch is not.
const BEYOND: f64 = 0.25;
/// Distance from the border of the domain, relative to its width, beyond which paths need no closer check.
const FAR_FROM_BORDER: f64 = 0.01;

impl Panel {
    /// Shoots rays into an arc of directions. Returns `None` if they diverge too fast for a polynomial.
    pub(super) fn shoot(fan: &Fan<impl Position>, arc: [f64; 2]) -> Option<Self> {
        let Fan { step, position, .. } = fan;
        let cosines = Cosines::new();
        let angle = |index| {
            0.5 * (arc[0] + arc[1]) + 0.5 * (arc[1] - arc[0]) * patch::chebyshev_point(index)
        };
        let mut rays: [Ray; RAYS] = std::array::from_fn(|index| fan.ray(angle(index)));
        let mut derivatives = rays.map(|ray| ray.derivative(position));
        let mut ended = [false; RAYS];
        let mut knots = interpolate(&rays, &derivatives, *step, &cosines);
        let mut patches = Vec::new();
        while patches.len() < fan.most_steps() && ended.contains(&false) {
            for index in 0..RAYS {
                rays[index] = rays[index].advance(derivatives[index], *step, position);
                derivatives[index] = rays[index].derivative(position);
                ended[index] |= fan.ends(&rays[index], patches.len() + 1);
            }
            let next = interpolate(&rays, &derivatives, *step, &cosines);
            let tail = next[RAYS - 2].value.abs() + next[RAYS - 1].value.abs();
            // This is also false where a ray became infinite.
            let resolved = tail.max_element() < fan.tolerance;
            if !resolved {
                return None;
            }
            let powers = |k: usize| patch::quintic(knots[k], next[k]);
            patches.push(Patch { coefficients: std::array::from_fn(powers) });
            knots = next;
        }
        Some(Self { patches, step: *step })
    }

    /// Records the grid points that the rays pass.
    pub(super) fn arrive(&self, arrivals: &Arrivals) {
        let mut clear = true;
        for (index, patch) in self.patches.iter().enumerate() {
            let along = parts_along(patch, index == 0);
            let at = |[i, j]: [usize; 2]| {
                let fraction = |k: usize, parts: usize| k as f64 / parts as f64;
                DVec2::new(2.0 * fraction(i, ACROSS) - 1.0, fraction(j, along))
            };
            let corners: Vec<[DVec2; ACROSS + 1]> =
                (0..=along).map(|j| std::array::from_fn(|i| patch.value(at([i, j])))).collect();
            clear &= corners.as_flattened().iter().all(|&uv| is_inside(uv, FAR_FROM_BORDER));
            for (i, j) in (0..ACROSS).flat_map(|i| (0..along).map(move |j| (i, j))) {
                let [start, end] = [[i, j], [i + 1, j + 1]];
                for triangle in [[start, [i + 1, j], end], [start, end, [i, j + 1]]] {
                    let values = triangle.map(|[i, j]| corners[j][i]);
                    for (point, weights) in arrivals.points_near(values, BEYOND) {
                        let guess = (0..3).map(|k| weights[k] * at(triangle[k])).sum();
                        self.arrive_at(point, index, guess, clear, arrivals);
                    }
                }
            }
        }
    }

    /// Records a grid point if it lies near a guess.
    fn arrive_at(
        &self,
        point: usize,
        index: usize,
        guess: DVec2,
        clear: bool,
        arrivals: &Arrivals,
    ) {
        // A guess may be late by a step.
        if self.step * (index as f64 + guess.y - 1.0) > arrivals.shortest(point) {
            return;
        }
        if let Some((index, found)) = self.locate(arrivals.place(point), index, guess) {
            let length = self.step * (index as f64 + found.y);
            arrivals.enter(point, length, || clear || self.stays(index, found));
        }
    }

    /// Finds the patch that contains a point (u, v), and the position in the patch, starting from a guess.
    fn locate(&self, place: DVec2, index: usize, guess: DVec2) -> Option<(usize, DVec2)> {
        /// Maximum number of moves from a guess to the right patch. A guess can be wrong by a step or two, since
        /// triangles are flat and fronts are not.
        const MOST_MOVES: usize = 4;
        const ROUNDING: f64 = 1e-9;
        let (mut index, mut guess) = (index, guess);
        for _ in 0..MOST_MOVES {
            let found = self.patches.get(index)?.find(place, guess)?;
            if found.y < -ROUNDING {
                index = index.checked_sub(1)?;
                guess = found + DVec2::Y;
            } else if found.y > 1.0 + ROUNDING {
                index += 1;
                guess = found - DVec2::Y;
            } else {
                return Some((index, found));
            }
        }
        None
    }

    /// Returns whether the ray to a place in a patch stays in the domain.
    fn stays(&self, index: usize, end: DVec2) -> bool {
        const ROUNDING: f64 = 1e-9;
        /// Number of checks of a ray per step. A path along a border that is bent inwards may be outside only
        /// between two checks. It is then too short by the cube of this part of a step.
        const LOOKS: usize = 8;
        let steps = (0..).map(|look| look as f64 / LOOKS as f64);
        steps.take_while(|&steps| steps < index as f64 + end.y).all(|steps| {
            let along = DVec2::new(end.x, steps.fract());
            is_inside(self.patches[steps as usize].value(along), -ROUNDING)
        })
    }
}

/// Returns the number of quadrangles along the rays. It is large enough that the quadrangles' straight sides
/// deviate from the rays by only a small part of the distance between rays. With fewer, a guess would belong
/// to the wrong rays.
fn parts_along(patch: &Patch, from_source: bool) -> usize {
    const SMALL: f64 = 0.02;
    const MOST: f64 = 64.0;
    let [start, middle, end] = [0.0, 0.5, 1.0].map(|y| patch.value(DVec2::new(0.0, y)));
    let [first, last] = [-1.0, 1.0].map(|x| patch.value(DVec2::new(x, 0.5)));
    let off = 4.0 * middle.distance(0.5 * (start + end)) / first.distance(last);
    // The deviation falls with the square of the number of parts, but at the source the distance between rays
    // is proportional to the length of a part.
    let parts = if from_source { off / SMALL } else { (off / SMALL).sqrt() };
    parts.ceil().clamp(1.0, MOST) as usize
}

/// Returns position and derivatives along the rays, as Chebyshev series across them.
fn interpolate(
    rays: &[Ray; RAYS],
    derivatives: &[Ray; RAYS],
    step: f64,
    cosines: &Cosines,
) -> [Knot; RAYS] {
    let value = patch::coefficients(rays.map(|ray| ray.at), cosines);
    let first = patch::coefficients(rays.map(|ray| step * ray.heading), cosines);
    let second = derivatives.map(|derivative| step * step * derivative.heading);
    let second = patch::coefficients(second, cosines);
    std::array::from_fn(|k| Knot { value: value[k], first: first[k], second: second[k] })
}
