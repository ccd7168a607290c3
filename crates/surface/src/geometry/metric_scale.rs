//! Splits a metric that jumps in scale into a slowness and a shape. Such a metric jumps from point to point
//! as a slowness does: neighbouring tensors differ by a factor.
//!
//! Edge lengths cannot hold such a metric: beside a jump, the edges of an even cell make an uneven triangle.
//! Therefore each tensor is split into the square of a slowness times a tensor of determinant 1. The updates
//! take a triangle's shape from the latter.

use rayon::prelude::*;

use super::metric::MetricTensor;
use crate::chart::{Chart, Direction};
use crate::constants::EVEN_SLOWNESS;

impl MetricTensor {
    fn determinant(&self) -> f64 {
        self.rr * self.cc - self.rc * self.rc
    }

    /// Returns the slowness whose square times [`Self::shape`] is this tensor.
    pub(crate) fn scale(&self) -> f64 {
        self.determinant().sqrt().sqrt()
    }

    /// Returns the tensor of determinant 1 that is this one times a number.
    pub(crate) fn shape(&self) -> Self {
        let scale = self.scale();
        // Divided twice, since the square may underflow.
        let part = |entry: f64| entry / scale / scale;
        Self { rr: part(self.rr), rc: part(self.rc), cc: part(self.cc) }
    }
}

/// Returns whether a metric jumps in scale: whether the tensors of two neighbours along a row or a column
/// differ by a large factor but hardly in shape.
pub(super) fn jumps_in_scale(chart: Chart, metric: &[MetricTensor], present: &[bool]) -> bool {
    let jumps = |a: usize, b: usize| {
        let (a, b) = (&metric[a], &metric[b]);
        let (least, most) =
            (a.determinant().min(b.determinant()), a.determinant().max(b.determinant()));
        // Most pairs fail this first test, so that no root is computed.
        most > EVEN_SLOWNESS.powi(4) * least && is_alike(&a.shape(), &b.shape())
    };
    let row_jumps = |row: usize| {
        (0..chart.cols).filter(|&col| present[chart.index(row, col)]).any(|col| {
            let neighbours = [Direction::East, Direction::South].into_iter();
            let neighbours = neighbours.filter_map(|to| chart.neighbour(row, col, to));
            let mut there = neighbours.map(|(row, col)| chart.index(row, col));
            there.any(|other| present[other] && jumps(chart.index(row, col), other))
        })
    };
    (0..chart.rows).into_par_iter().any(row_jumps)
}

/// Returns whether two tensors of determinant 1 give lengths that differ by at most the factor
/// `EVEN_SLOWNESS` to a step in any direction.
fn is_alike(a: &MetricTensor, b: &MetricTensor) -> bool {
    // The eigenvalues of one tensor relative to the other are reciprocals of each other. This is their sum.
    let sum = a.rr * b.cc + a.cc * b.rr - 2.0 * a.rc * b.rc;
    let square = EVEN_SLOWNESS * EVEN_SLOWNESS;
    sum <= square + square.recip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EdgeLengths, Surface};

    const CHART: Chart = Chart { rows: 7, cols: 9 };

    fn metric(of: impl Fn(usize, usize) -> [f64; 3]) -> Surface {
        let tensor = |index: usize| {
            let (row, col) = CHART.position(index);
            let [rr, rc, cc] = of(row, col);
            MetricTensor { rr, rc, cc }
        };
        Surface::from_metric(CHART.rows, CHART.cols, (0..CHART.points()).map(tensor).collect())
            .unwrap()
    }

    fn has_slowness(surface: &Surface) -> bool {
        EdgeLengths::<f64>::new(surface).unwrap().slowness().is_some()
    }

    #[test]
    fn metrics_that_jump_by_a_factor_are_a_slowness_and_others_are_none() {
        let strip = |factor: f64| move |_, col| if col == 4 { factor } else { 1.0 };
        for factor in [0.01, 2.0, 1e4] {
            let at = strip(factor);
            assert!(has_slowness(&metric(|row, col| [3.0, 0.5, 1.0].map(|of| of * at(row, col)))));
        }
        let at = strip(1.2);
        assert!(!has_slowness(&metric(|row, col| [3.0 * at(row, col), 0.5, 1.0])));
        // Latitudes towards a pole, and a strip that is long in one direction.
        let narrow = |row: usize, _| [1.0, 0.0, (0.02 + 0.3 * row as f64).powi(2)];
        assert!(!has_slowness(&metric(narrow)));
        assert!(!has_slowness(&metric(|_, col| [if col == 4 { 1e4 } else { 1.0 }, 0.0, 1.0])));
    }

    /// A metric times a squared slowness makes the same edges as the metric with that slowness. The two
    /// stored slownesses differ by the constant scale of the metric.
    #[test]
    fn a_factor_makes_the_edges_and_shapes_that_a_slowness_makes() {
        let slowness = |row: usize, col: usize| if row * col % 5 == 2 { 40.0_f64 } else { 0.5 };
        let scaled = metric(|row, col| [1.0, 0.25, 1.5].map(|of| of * slowness(row, col).powi(2)));
        let weights = CHART.places().map(|(row, col)| slowness(row, col)).collect();
        let slowed = metric(|_, _| [1.0, 0.25, 1.5]).with_slowness(weights).unwrap();
        let scale = MetricTensor { rr: 1.0, rc: 0.25, cc: 1.5 }.scale();
        let [scaled, slowed] = [scaled, slowed].map(|surface| EdgeLengths::<f64>::new(&surface));
        let (scaled, slowed) = (scaled.unwrap(), slowed.unwrap());
        for (a, b) in scaled.planes().into_iter().zip(slowed.planes()) {
            a.iter().zip(b).for_each(|(a, b)| approx::assert_relative_eq!(a, b, epsilon = 1e-12));
        }
        let (of_scaled, of_slowed) = (scaled.slowness().unwrap(), slowed.slowness().unwrap());
        for place in CHART.places() {
            let at = CHART.bordered(place.0, place.1);
            approx::assert_relative_eq!(of_scaled[at], scale * of_slowed[at], epsilon = 1e-9);
        }
    }
}
