//! Flat surfaces whose points are evenly spaced: floor plans.

use glam::{DMat2, DVec2, DVec3};

use super::Surface;

/// A grid whose positions are affine in row and column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EvenGrid {
    /// From a row to the next, and from a column to the next.
    steps: [DVec3; 2],
}

/// How far positions may lie from such a grid, of its extent: as far as single precision rounds them.
const NEAR: f64 = 1e-7;

impl EvenGrid {
    /// The grid of a surface that is one, by least squares; none if it has a slowness, or no positions, or
    /// if its points lie on a line.
    pub(crate) fn of(surface: &Surface) -> Option<Self> {
        if surface.slowness().is_some() {
            return None;
        }
        let chart = surface.chart();
        let points: Vec<(DVec2, DVec3)> = (0..chart.points())
            .map(|index| chart.position(index))
            .filter(|&(row, col)| surface.has(row, col))
            .map(|(row, col)| {
                Some((DVec2::new(row as f64, col as f64), surface.position(row, col)?))
            })
            .collect::<Option<_>>()?;
        let mean = points.iter().fold((DVec2::ZERO, DVec3::ZERO), |(at, place), next| {
            (at + next.0 / points.len() as f64, place + next.1 / points.len() as f64)
        });
        let around = || points.iter().map(|&(at, place)| (at - mean.0, place - mean.1));
        let mut squares = DMat2::ZERO;
        let mut products = [DVec3::ZERO; 2];
        for (at, place) in around() {
            squares += DMat2::from_cols(at * at.x, at * at.y);
            products = [products[0] + place * at.x, products[1] + place * at.y];
        }
        if squares.determinant() == 0.0 {
            return None;
        }
        let inverse = squares.inverse();
        let steps = [inverse.x_axis, inverse.y_axis]
            .map(|share| products[0] * share.x + products[1] * share.y);
        let even = |at: DVec2| steps[0] * at.x + steps[1] * at.y;
        let extent = around().map(|(at, _)| even(at).length()).fold(0.0, f64::max);
        let is_even = around().all(|(at, place)| place.distance(even(at)) <= NEAR * extent);
        (is_even && steps[0].cross(steps[1]) != DVec3::ZERO).then_some(Self { steps })
    }

    /// Length of a straight line over so many rows and columns.
    pub(crate) fn length(self, step: DVec2) -> f64 {
        (self.steps[0] * step.x + self.steps[1] * step.y).length()
    }

    /// Whether one of the triangles of neighbours has an obtuse angle.
    pub(crate) fn is_obtuse(self) -> bool {
        let [a, b] = self.steps;
        a.dot(b).abs() > a.length_squared().min(b.length_squared())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Spacing;
    use crate::surface::builtin::Builtin;

    #[test]
    fn planes_are_even_and_nothing_else_is() {
        for builtin in Builtin::ALL {
            let surface = builtin.surface(33, 49).unwrap();
            let is_flat =
                matches!(builtin, Builtin::Plane | Builtin::Maze | Builtin::ShearedPlane { .. });
            assert_eq!(EvenGrid::of(&surface).is_some(), is_flat, "{builtin}");
        }
        let plane = || Surface::from_heights(9, 9, vec![0.0; 81], Spacing::square(1.0)).unwrap();
        assert!(EvenGrid::of(&plane().with_slowness(vec![1.0; 81]).unwrap()).is_none());
        let row: Vec<_> = (0..81).map(|index| index < 9).collect();
        assert!(EvenGrid::of(&plane().with_mask(&row).unwrap()).is_none(), "points on a line");
        let mut bumpy = vec![0.0; 81];
        bumpy[40] = 1e-3;
        let bumpy = Surface::from_heights(9, 9, bumpy, Spacing::square(1.0)).unwrap();
        assert!(EvenGrid::of(&bumpy).is_none());
    }

    #[test]
    fn lengths_are_those_between_positions() {
        let surface = Builtin::ShearedPlane { degrees: 60.0 }.surface(20, 30).unwrap();
        let grid = EvenGrid::of(&surface).unwrap();
        let [a, b] = [(3, 4), (17, 22)].map(|(row, col)| surface.position(row, col).unwrap());
        approx::assert_relative_eq!(
            grid.length(DVec2::new(14.0, 18.0)),
            a.distance(b),
            max_relative = 1e-13
        );
    }
}
