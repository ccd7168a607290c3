//! Interpolates a distance map between its grid points, and extrapolates it beyond them.
//!
//! The interpolated quantity is the square of the time since the start. For a point source on a developable
//! surface this square is quadratic along any straight line, also through the source. Beside a source curve
//! it is quadratic across the curve. It is smooth wherever the map itself is smooth. Where two wavefronts
//! meet, the map and its square have a kink; there each side is extrapolated from its own points alone.

use geosweep_surface::DistanceMap;
use geosweep_surface::{Chart, Direction};

/// The squared times since the start, at grid points.
#[derive(Clone, Copy)]
pub(super) struct Arrivals<'a> {
    pub chart: Chart,
    distances: &'a [f32],
    start: f64,
}

impl<'a> Arrivals<'a> {
    /// Wraps a map. `start` is the smallest initial value of the sources.
    pub fn new(map: &'a DistanceMap, start: f64) -> Self {
        Self { chart: map.chart, distances: &map.distances, start }
    }

    pub fn is_reached(&self, index: usize) -> bool {
        self.distances[index].is_finite()
    }

    /// Returns the arrival time at the grid point `index`.
    pub fn time(&self, index: usize) -> f32 {
        self.distances[index]
    }

    /// Returns the square of the time since the start, for the arrival time `time`.
    pub fn squared(&self, time: f64) -> f64 {
        (time - self.start).powi(2)
    }

    pub fn squared_at(&self, index: usize) -> f64 {
        self.squared(f64::from(self.distances[index]))
    }

    /// Returns the squared time `steps` grid steps away from a point. Returns `None` if the grid has no such
    /// point or the map does not reach it.
    fn along(&self, from: (usize, usize), to: Direction, steps: isize) -> Option<f64> {
        let (row, col) = self.chart.along(from, to, steps)?;
        let index = self.chart.index(row, col);
        self.is_reached(index).then(|| self.squared_at(index))
    }

    /// Returns the position on the edge from a point (0) to its neighbour (1) at which the map has the value `time`,
    /// which lies between the values at the two ends.
    pub fn crossing(&self, from: (usize, usize), to: Direction, time: f64) -> f64 {
        let at = |steps| self.along(from, to, steps);
        let (Some(a), Some(b)) = (at(0), at(1)) else { return 0.5 };
        let target = self.squared(time);
        let bend = |before: Option<f64>, here: f64, after: Option<f64>| {
            Some(before? - 2.0 * here + after?)
        };
        let bends = [bend(at(-1), a, Some(b)), bend(Some(a), b, at(2))];
        match bends {
            // Two wavefronts meet on this edge. Each is extrapolated from its own side, and the earlier time
            // is used.
            [Some(p), Some(q)] if p < 0.0 && q < 0.0 => {
                let ahead = bend(at(-2), at(-1).unwrap_or(a), Some(a));
                let behind = bend(Some(b), at(2).unwrap_or(b), at(3));
                let (Some(p), Some(q)) = (ahead, behind) else {
                    return solve(target, |s| a + s * (b - a));
                };
                let before = at(-1).unwrap_or(a);
                let after = at(2).unwrap_or(b);
                let from_a = |s: f64| a + s * (a - before) + 0.5 * s * (s + 1.0) * p;
                let from_b = |s: f64| b + s * (b - after) + 0.5 * s * (s + 1.0) * q;
                if from_a(1.0) < b || from_b(1.0) < a {
                    return solve(target, |s| a + s * (b - a));
                }
                solve(target, |s| from_a(s).min(from_b(1.0 - s)))
            }
            [Some(p), Some(q)] => {
                // If there is a kink beyond one end, the second difference at the other end is more accurate.
                let smooth = (p - q).abs() <= 0.5 * (p.abs() + q.abs());
                let least = if p.abs() < q.abs() { p } else { q };
                let (p, q) = if smooth { (p, q) } else { (least, least) };
                solve(target, |s| {
                    let bend = ((2.0 - s) * p + (1.0 + s) * q) / 3.0;
                    a + s * (b - a) - 0.5 * s * (1.0 - s) * bend
                })
            }
            [p, q] => {
                let bend = p.or(q).unwrap_or(0.0);
                solve(target, |s| a + s * (b - a) - 0.5 * s * (1.0 - s) * bend)
            }
        }
    }
}

/// Returns the argument in [0, 1] at which a function equals `target`, which lies between its values at both ends. The
/// method is regula falsi in the Illinois variant.
pub(super) fn solve(target: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) = (0.0, 1.0);
    let (mut at_a, mut at_b) = (function(a) - target, function(b) - target);
    if at_a == 0.0 || at_b == 0.0 || (at_a < 0.0) == (at_b < 0.0) {
        return if at_a.abs() <= at_b.abs() { a } else { b };
    }
    for _ in 0..40 {
        let s = (a * at_b - b * at_a) / (at_b - at_a);
        let at_s = function(s) - target;
        if at_s == 0.0 || (b - a).abs() < 1e-10 {
            return s;
        }
        if (at_s < 0.0) == (at_b < 0.0) {
            at_a *= 0.5;
        } else {
            (a, at_a) = (b, at_b);
        }
        (b, at_b) = (s, at_s);
        if at_b.abs() <= 1e-13 * target.abs() {
            return b;
        }
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_functions_far_from_linear() {
        for target in [1e-6, 0.01, 0.3, 0.999] {
            approx::assert_abs_diff_eq!(
                solve(target, |s| s * s * s),
                f64::cbrt(target),
                epsilon = 1e-8
            );
        }
        assert_eq!(solve(2.0, |s| s), 1.0);
        assert_eq!(solve(0.0, |s| s), 0.0);
    }
}
