//! Measures whether the grid resolves the surface, by the turn of its normals from point to point.

use glam::DVec3;

use super::{Direction, Geometry, Surface, kept};
use crate::constants::{LOOKS, SHARP_COSINE, TURN_UNITS};

/// Measure of how well a grid resolves a surface, from some thousands of its points.
///
/// On a surface whose normals turn by tens of degrees from one point to the next, distances are those of some
/// polyhedron. The curvature of the surface and of fronts on it is then meaningless. A height field with a
/// forgotten spacing is a common case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The share of the edges along rows and columns at whose ends the surface normals differ by more than 30
    /// degrees.
    pub sharp_edges: f64,
    /// The mean squared difference of unit normals one step apart, and two steps apart.
    turns: [f64; 2],
}

impl Resolution {
    /// Computes the resolution from the counts of a device (`glsl/passes/turns.glsl`). Returns `None` if
    /// nothing was counted.
    #[doc(hidden)]
    pub fn counted(sharp: u32, compared: u32, continued: u32, turns: [u32; 2]) -> Option<Self> {
        let units = f64::from(continued) * f64::from(TURN_UNITS);
        (continued > 0).then(|| Self {
            sharp_edges: f64::from(sharp) / f64::from(compared),
            turns: turns.map(|sum| f64::from(sum) / units),
        })
    }

    /// Returns whether the surface turns at random: by more than 12 degrees a step, and not much further in
    /// two steps than in one. A surface that bends turns further in two steps.
    ///
    /// The thresholds were measured on white noise and on smoothed noise (30 x 30 points, against exact polyhedral
    /// distances). On noise with a relief of 0.3 times the spacing or more, planar fronts have the smallest error,
    /// since rough ground makes fronts early and planar fronts are late. On smooth surfaces curved fronts have the
    /// smallest error, however steep the surface is.
    pub fn is_rough(&self) -> bool {
        let [one, two] = self.turns;
        one > ROUGH_TURN * ROUGH_TURN && two < ROUGH_TURNS * one
    }
}

impl Surface {
    /// Returns how well the grid resolves the surface. The result is `None` over a metric, which has no
    /// positions, and for surfaces that are too small.
    pub fn resolution(&self) -> Option<Resolution> {
        *kept(&self.known.resolution, || self.measured_resolution())
    }

    fn measured_resolution(&self) -> Option<Resolution> {
        let (rows, cols) = (self.rows(), self.cols());
        let (mut sharp, mut edges, mut turns, mut counted) = (0, 0, [0.0; 2], 0);
        let step = |points: usize| points.div_ceil(LOOKS as usize).max(1);
        // Where all points are looked at, each normal is needed five times.
        let (looks_at_all, chart) = (step(rows) == 1 && step(cols) == 1, self.chart());
        let is_level = looks_at_all && self.is_level();
        let all = (looks_at_all && !is_level).then(|| {
            let normals = chart.places().map(|(row, col)| self.normal_at(row, col));
            normals.collect::<Vec<_>>()
        });
        let normal = |(row, col): (usize, usize)| match &all {
            Some(all) => all[chart.index(row, col)],
            None if is_level => {
                let beside =
                    |to| chart.neighbour(row, col, to).is_some_and(|(r, c)| self.has(r, c));
                (self.has(row, col) && AXES.into_iter().all(beside)).then_some(DVec3::Z)
            }
            None => self.normal_at(row, col),
        };
        for row in (1..rows.saturating_sub(1)).step_by(step(rows)) {
            for col in (1..cols.saturating_sub(1)).step_by(step(cols)) {
                let Some(here) = normal((row, col)) else { continue };
                for to in [Direction::East, Direction::North] {
                    let ahead = |steps: isize| normal(chart.along((row, col), to, steps)?);
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

    /// Returns whether the surface is a height field whose heights are all the same.
    fn is_level(&self) -> bool {
        let Geometry::Heights { heights, .. } = self.geometry() else { return false };
        heights.iter().all(|height| *height == heights[0])
    }

    /// Returns the surface's unit normal at a point, if the point and all four neighbours are present.
    fn normal_at(&self, row: usize, col: usize) -> Option<DVec3> {
        let beside = |to| {
            let (row, col) = self.chart().neighbour(row, col, to)?;
            self.position(row, col)
        };
        let across = beside(Direction::East)? - beside(Direction::West)?;
        let along = beside(Direction::South)? - beside(Direction::North)?;
        self.position(row, col)?;
        across.cross(along).try_normalize()
    }
}

/// Directions to the neighbours from which a normal follows.
const AXES: [Direction; 4] = [Direction::East, Direction::West, Direction::South, Direction::North];

/// Thresholds of a surface that turns at random. `ROUGH_TURN` is the least turn per step in radians.
/// `ROUGH_TURNS` is the upper limit for the mean square of the turn in two steps relative to the mean square
/// in one step; this ratio is 4 on evenly bent surfaces.
const ROUGH_TURN: f64 = 0.2;
const ROUGH_TURNS: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spacing;
    use crate::builtin::Builtin;

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
    fn level_ground_has_the_resolution_of_other_flat_ground() {
        let flat = |slope: f64, rows: usize| {
            let heights = (0..rows * 9).map(|k| 5.0 + slope * (k % 9) as f64).collect();
            let mask: Vec<_> = (0..rows * 9).map(|k| k % 31 != 7).collect();
            let surface = Surface::from_heights(rows, 9, heights, Spacing::square(1.0)).unwrap();
            surface.with_mask(&mask).unwrap().resolution()
        };
        for rows in [2, 3, 4, 5, 9, 40] {
            let (level, tilted) = (flat(0.0, rows), flat(0.5, rows));
            assert_eq!(level.is_some(), tilted.is_some(), "{rows} rows");
            let Some((level, tilted)) = level.zip(tilted) else { continue };
            assert_eq!((level.sharp_edges, level.turns), (0.0, [0.0; 2]));
            assert!(tilted.sharp_edges == 0.0 && tilted.turns[1] < 1e-30);
        }
    }

    #[test]
    fn built_in_surfaces_are_resolved() {
        for builtin in Builtin::ALL {
            let surface = builtin.surface(101, 90).unwrap();
            let resolution = surface.resolution().unwrap();
            assert!(!resolution.is_rough(), "{}", builtin.name());
            assert!(resolution.sharp_edges < 0.05, "{}: {resolution:?}", builtin.name());
        }
        // Steep hills are not rough, but the grid does not resolve them either.
        assert!(heights(10.0, 8).resolution().unwrap().sharp_edges > 0.2);
        assert!(Builtin::Plane.surface(2, 9).unwrap().resolution().is_none());
    }
}
