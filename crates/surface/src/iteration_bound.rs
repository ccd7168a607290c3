//! Bounds the number of raster scan iterations that a surface can need, by Theorem 1 of the paper.

use glam::{DMat2, DVec3};

use super::{Chart, Direction, Surface};

impl Surface {
    /// Returns Theorem 1's bound on the number of raster scan iterations, from finite differences.
    ///
    /// The theorem (paper, section 4 and appendix A) bounds how far a geodesic can turn in the chart, and
    /// each quarter turn takes at most one more iteration of four scans. Two details of the published
    /// expression need an interpretation.
    ///
    /// - The eigenvalues of the Hessians are taken by magnitude, since the proof bounds a quadratic form with
    ///   them.
    /// - The published expression has a factor lambda_max, the largest eigenvalue of the metric, which
    ///   depends on the units. The curvature bound of the proof, |H| / lambda_min per unit of length on the
    ///   surface, does not change when the chart or the surface is scaled. It equals the published bound if
    ///   the chart is scaled so that lambda_max = 1.
    ///
    /// The largest |H| and the smallest lambda_min are each taken over all points of the surface, and need
    /// not be at the same point. The diameter is bounded by the longest row plus the longest column.
    ///
    /// Returns `None` where the theorem does not apply: for a metric without positions, with a slowness, with
    /// holes (a path around a wall turns as often as the wall does), and below 3 x 3 points. It also returns
    /// `None` if the bound is not finite, as where grid points coincide.
    pub fn iteration_bound(&self) -> Option<u64> {
        use Direction::{East, North, NorthEast, NorthWest, South, SouthEast, SouthWest, West};
        let chart = self.chart();
        let Chart { rows, cols } = chart;
        if self.is_weighted() || self.present().contains(&false) || rows < 3 || cols < 3 {
            return None;
        }
        self.position(0, 0)?;
        let at = |(row, col)| self.position(row, col).expect("the surface has no hole");
        let (mut smallest_eigenvalue, mut largest_hessian) = (f64::INFINITY, 0.0f64);
        let mut largest_coordinate = 0.0f64;
        for (row, col) in chart.interior().places() {
            let x = at((row, col));
            let beside = |to| at(chart.neighbour(row, col, to).expect("inner points have all"));
            let [north, south, west, east] = [North, South, West, East].map(beside);
            let (along_rows, along_cols) = (0.5 * (south - north), 0.5 * (east - west));
            let metric = symmetric(
                along_rows.length_squared(),
                along_rows.dot(along_cols),
                along_cols.length_squared(),
            );
            let (rr, cc) = (south - 2.0 * x + north, east - 2.0 * x + west);
            let rc = 0.25
                * (beside(SouthEast) - beside(SouthWest) - beside(NorthEast) + beside(NorthWest));
            smallest_eigenvalue = smallest_eigenvalue.min(eigenvalues(metric).0);
            largest_hessian = largest_hessian.max(hessian_norm(rr, rc, cc));
            largest_coordinate = largest_coordinate.max(x.abs().max_element());
        }
        let length = |from, to| {
            let ends = chart.walk(from, to).zip(chart.walk(from, to).skip(1));
            ends.map(|(a, b)| at(a).distance(at(b))).sum::<f64>()
        };
        let longest_row = (0..rows).map(|row| length((row, 0), East)).fold(0.0, f64::max);
        let longest_col = (0..cols).map(|col| length((0, col), South)).fold(0.0, f64::max);
        let diameter: f64 = longest_row + longest_col;
        // The second differences of a straight grid are rounding errors, not curvature.
        let rounding = 8.0 * f64::EPSILON * largest_coordinate;
        let curvature = (largest_hessian - rounding).max(0.0) / smallest_eigenvalue;
        let turns = 2.0 * diameter * curvature / std::f64::consts::PI;
        turns.is_finite().then_some(turns.ceil() as u64 + 1)
    }
}

/// Returns the square root of the sum, over x, y and z, of the square of each Hessian's eigenvalue of largest
/// magnitude.
fn hessian_norm(rr: DVec3, rc: DVec3, cc: DVec3) -> f64 {
    let largest = |axis: usize| {
        let (low, high) = eigenvalues(symmetric(rr[axis], rc[axis], cc[axis]));
        low.abs().max(high.abs())
    };
    DVec3::new(largest(0), largest(1), largest(2)).length()
}

fn symmetric(rr: f64, rc: f64, cc: f64) -> DMat2 {
    DMat2::from_cols_array(&[rr, rc, rc, cc])
}

/// Returns the eigenvalues of a symmetric matrix. The smaller one is first.
fn eigenvalues(m: DMat2) -> (f64, f64) {
    let mean = 0.5 * (m.x_axis.x + m.y_axis.y);
    let radius = (0.5 * (m.x_axis.x - m.y_axis.y)).hypot(m.x_axis.y);
    (mean - radius, mean + radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spacing;

    fn disc(points: usize) -> Surface {
        let position = |index: usize| {
            let (row, col) = (index / points, index % points);
            let radius = 0.5 + 0.5 * row as f64 / (points - 1) as f64;
            let angle = 1.5 * col as f64 / (points - 1) as f64;
            DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        };
        Surface::from_positions(points, points, (0..points * points).map(position).collect())
            .unwrap()
    }

    #[test]
    fn a_plane_needs_one_iteration() {
        let plane =
            Surface::from_heights(5, 7, vec![0.1; 35], Spacing { dx: 0.1, dy: 0.3 }).unwrap();
        assert_eq!(plane.iteration_bound(), Some(1));
        // A slanted and sheared grid also needs one iteration, even if it is fine and far from the origin.
        let points = 513;
        let position = |index: usize| {
            let (row, col) = ((index / points) as f64, (index % points) as f64);
            DVec3::new(5e5 + 0.1 * col + 0.3 * row, 4e6 + 0.1 * row, 0.7 * col)
        };
        let positions = (0..points * points).map(position).collect();
        let slanted = Surface::from_positions(points, points, positions).unwrap();
        assert_eq!(slanted.iteration_bound(), Some(1));
    }

    #[test]
    fn the_bound_does_not_depend_on_sampling_or_scale() {
        // The paper's example of an unfavourable chart: a disc in polar coordinates.
        let coarse = disc(65).iteration_bound().unwrap();
        let fine = disc(257).iteration_bound().unwrap();
        assert!(coarse > 1 && coarse.abs_diff(fine) <= 1, "{coarse} {fine}");
        let larger =
            (0..65 * 65).map(|i| 1e3 * disc(65).position(i / 65, i % 65).unwrap()).collect();
        assert_eq!(
            Surface::from_positions(65, 65, larger).unwrap().iteration_bound(),
            Some(coarse)
        );
    }
}
