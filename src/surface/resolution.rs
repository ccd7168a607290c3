//! Whether the grid resolves the surface: how far its normals turn from point to point.

use glam::DVec3;

use super::Surface;
use crate::constants::{LOOKS, SHARP_COSINE, TURN_UNITS};

/// How well a grid resolves a surface, as far as some thousands of its points tell.
///
/// Where normals turn by tens of degrees from a point to the next, distances are those of some polyhedron: the
/// curvature of the surface, and of fronts on it, means little. Whoever forgets the spacing of a height field gets there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The share of the edges along rows and columns at whose ends the surface's normals differ by more than 30
    /// degrees.
    pub sharp_edges: f64,
    /// Mean square of the difference of unit normals a step apart, and two steps apart.
    turns: [f64; 2],
}

impl Resolution {
    /// From what is counted on a device, in `glsl/turns.glsl`; `None` if it has looked at nothing.
    pub(crate) fn counted(
        sharp: u32,
        compared: u32,
        continued: u32,
        turns: [u32; 2],
    ) -> Option<Self> {
        let units = f64::from(continued) * f64::from(TURN_UNITS);
        (continued > 0).then(|| Self {
            sharp_edges: f64::from(sharp) / f64::from(compared),
            turns: turns.map(|sum| f64::from(sum) / units),
        })
    }

    /// Whether the surface turns at random: by more than 12 degrees a step, and not much further in two steps
    /// than in one, as it would where it bends. Measured on white noise and on the same smoothed (30 x 30 points,
    /// against exact polyhedral distances): on noise with a relief of 0.3 times the spacing and more planar fronts
    /// err least, since what is early on rough ground and what they are late by cancel; on what is smooth,
    /// curved fronts do, however steep.
    pub fn is_rough(&self) -> bool {
        let [one, two] = self.turns;
        one > ROUGH_TURN * ROUGH_TURN && two < ROUGH_TURNS * one
    }
}

impl Surface {
    /// How well the grid resolves the surface; `None` if it has no positions, but a metric, or is too small to
    /// tell.
    pub fn resolution(&self) -> Option<Resolution> {
        let (rows, cols) = (self.rows(), self.cols());
        let (mut sharp, mut edges, mut turns, mut counted) = (0, 0, [0.0; 2], 0);
        let step = |points: usize| points.div_ceil(LOOKS as usize).max(1);
        for row in (1..rows.saturating_sub(1)).step_by(step(rows)) {
            for col in (1..cols.saturating_sub(1)).step_by(step(cols)) {
                let Some(here) = self.normal_at(row, col) else { continue };
                for (up, right) in [(0, 1), (1, 0)] {
                    let ahead = |steps: usize| {
                        self.normal_at(row.checked_sub(steps * up)?, col + steps * right)
                    };
                    let Some(next) = ahead(1) else { continue };
                    edges += 1;
                    sharp += usize::from(here.dot(next) < SHARP_COSINE);
                    let Some(after) = ahead(2) else { continue };
                    counted += 1;
                    turns[0] += here.distance_squared(next);
                    turns[1] += here.distance_squared(after);
                }
            }
        }
        (counted > 0).then(|| Resolution {
            sharp_edges: sharp as f64 / edges as f64,
            turns: turns.map(|sum| sum / counted as f64),
        })
    }

    /// The surface's unit normal at a point all four of whose neighbours are there.
    fn normal_at(&self, row: usize, col: usize) -> Option<DVec3> {
        let at = |row: usize, col: usize| {
            if row < self.rows() && col < self.cols() { self.position(row, col) } else { None }
        };
        let (up, left) = (row.checked_sub(1)?, col.checked_sub(1)?);
        let across = at(row, col + 1)? - at(row, left)?;
        let along = at(row + 1, col)? - at(up, col)?;
        at(row, col)?;
        across.cross(along).try_normalize()
    }
}

/// A surface that turns at random turns by more than so many radians a step; and the mean square in two steps is less than
/// so many times that in one. Where it bends evenly it is four times as much.
const ROUGH_TURN: f64 = 0.2;
const ROUGH_TURNS: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Spacing;
    use crate::surface::builtin::Builtin;

    fn heights(relief: f64, smoothed: usize) -> Surface {
        let (rows, cols) = (40, 50);
        let mut state = 1u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        let mut heights: Vec<f64> = (0..rows * cols).map(|_| noise()).collect();
        for _ in 0..smoothed {
            let before = heights.clone();
            let at = |row: usize, col: usize| before[row.min(rows - 1) * cols + col.min(cols - 1)];
            for (index, height) in heights.iter_mut().enumerate() {
                let (row, col) = (index / cols, index % cols);
                let around = at(row.saturating_sub(1), col)
                    + at(row + 1, col)
                    + at(row, col.saturating_sub(1))
                    + at(row, col + 1);
                *height = 0.5 * at(row, col) + 0.125 * around;
            }
        }
        let square = heights.iter().map(|height| height * height).sum::<f64>();
        let unit = (square / heights.len() as f64).sqrt();
        heights.iter_mut().for_each(|height| *height *= relief / unit);
        Surface::from_heights(rows, cols, heights, Spacing::square(1.0)).unwrap()
    }

    #[test]
    fn noise_is_rough_and_hills_are_not() {
        for relief in [0.3, 1.0, 3.0, 10.0] {
            assert!(heights(relief, 0).resolution().unwrap().is_rough(), "{relief}");
            assert!(!heights(relief, 8).resolution().unwrap().is_rough(), "{relief}");
        }
        assert!(!heights(0.05, 0).resolution().unwrap().is_rough());
    }

    #[test]
    fn built_in_surfaces_are_resolved() {
        for builtin in Builtin::ALL {
            let surface = builtin.surface(101, 90).unwrap();
            let resolution = surface.resolution().unwrap();
            assert!(!resolution.is_rough(), "{}", builtin.name());
            assert!(resolution.sharp_edges < 0.05, "{}: {resolution:?}", builtin.name());
        }
        // Steep hills are not rough, but not resolved either.
        assert!(heights(10.0, 8).resolution().unwrap().sharp_edges > 0.2);
        assert!(Builtin::Plane.surface(2, 9).unwrap().resolution().is_none());
    }
}
