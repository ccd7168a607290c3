//! Computes the Gaussian curvature of a surface given by a metric, from the tensors around each point.
//!
//! The angles between edges cannot give this curvature. The length of an edge from the metric at its ends is
//! accurate to second order, and the remaining error turns angles by as much as the surface's curvature does.

use rayon::prelude::*;

use super::Surface;
use super::geometry::{Geometry, MetricTensor};
use super::jump::jump;
use super::real::Real;

impl Surface {
    /// Returns the Gaussian curvature at each point of the bordered array, or `None` if the surface has
    /// positions. The value is NaN unless the point and its eight neighbours are present. Curvature is left
    /// out where the metric jumps.
    pub(super) fn metric_curvature<R: Real>(&self) -> Option<Vec<R>> {
        let Geometry::Metric(metric) = self.geometry() else { return None };
        let chart = self.chart();
        let mut curvature = vec![R::nan(); chart.bordered_points()];
        let inner = |count: usize| 1..count.saturating_sub(1);
        let tensors = |row: usize| {
            let at = |col| self.has(row, col).then(|| self.shape(&metric[chart.index(row, col)]));
            RowOfTensors::new((0..chart.cols).map(at).collect())
        };
        chart.rows_mut(&mut curvature).enumerate().for_each(|(row, line)| {
            if !inner(chart.rows).contains(&row) {
                return;
            }
            let rows = [row - 1, row, row + 1].map(tensors);
            for col in inner(chart.cols) {
                if let Some(known) = smooth_curvature(&rows, col) {
                    line[col] = R::of(known);
                }
            }
        });
        Some(curvature)
    }
}

/// Steps along which the metric is compared between neighbours, in rows and columns.
const STEPS: [[f64; 2]; 4] = [[0.0, 1.0], [1.0, 0.0], [1.0, 1.0], [1.0, -1.0]];

/// The tensors of a row, and the lengths of `STEPS` by each of them.
struct RowOfTensors {
    tensors: Vec<Option<MetricTensor>>,
    lengths: Vec<[f64; STEPS.len()]>,
}

impl RowOfTensors {
    fn new(tensors: Vec<Option<MetricTensor>>) -> Self {
        let lengths = |tensor: &Option<MetricTensor>| {
            tensor.map_or([f64::NAN; 4], |tensor| STEPS.map(|step| tensor.length(step)))
        };
        Self { lengths: tensors.iter().map(lengths).collect(), tensors }
    }
}

impl Surface {
    /// Returns the tensor without the scale that the updates treat as a slowness. The curvature due to that
    /// scale is computed with the slowness.
    fn shape(&self, tensor: &MetricTensor) -> MetricTensor {
        if self.is_scaled() { tensor.shape() } else { *tensor }
    }
}

/// Returns the curvature from the tensors at a point and around it (Brioschi's formula), reduced where the
/// tensors do not change smoothly. `rows` are the point's row and those beside it. The result is `None` unless all nine
/// tensors are present.
fn smooth_curvature(rows: &[RowOfTensors; 3], col: usize) -> Option<f64> {
    let mut block = [[MetricTensor::default(); 3]; 3];
    for (tensors, row) in block.iter_mut().zip(rows) {
        for (tensor, known) in tensors.iter_mut().zip(&row.tensors[col - 1..]) {
            *tensor = (*known)?;
        }
    }
    let jumps = std::array::from_fn::<_, { STEPS.len() }, _>(|step| {
        let (mut least, mut most) = (f64::INFINITY, 0f64);
        for lengths in rows.iter().flat_map(|row| &row.lengths[col - 1..=col + 1]) {
            (least, most) = (least.min(lengths[step]), most.max(lengths[step]));
        }
        jump(most, least)
    });
    let smooth = 1.0 - jumps.into_iter().fold(0.0, f64::max);
    Some(if smooth > 0.0 { smooth * curvature(&block) } else { 0.0 })
}

fn curvature(block: &[[MetricTensor; 3]; 3]) -> f64 {
    // The coordinate u counts columns, and v counts rows.
    let [e, f, g]: [fn(&MetricTensor) -> f64; 3] = [|t| t.cc, |t| t.rc, |t| t.rr];
    let of = |entry: fn(&MetricTensor) -> f64| {
        let at = |row: usize, col: usize| entry(&block[row][col]);
        let here = at(1, 1);
        let by_u = 0.5 * (at(1, 2) - at(1, 0));
        let by_v = 0.5 * (at(2, 1) - at(0, 1));
        let by_uu = at(1, 2) - 2.0 * here + at(1, 0);
        let by_vv = at(2, 1) - 2.0 * here + at(0, 1);
        let by_uv = 0.25 * (at(2, 2) - at(2, 0) - at(0, 2) + at(0, 0));
        [here, by_u, by_v, by_uu, by_vv, by_uv]
    };
    let ([e, e_u, e_v, _, e_vv, _], [f, f_u, f_v, _, _, f_uv], [g, g_u, g_v, g_uu, _, _]) =
        (of(e), of(f), of(g));
    let determinant = |[a, b, c]: [[f64; 3]; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    let first = determinant([
        [-0.5 * e_vv + f_uv - 0.5 * g_uu, 0.5 * e_u, f_u - 0.5 * e_v],
        [f_v - 0.5 * g_u, e, f],
        [0.5 * g_v, f, g],
    ]);
    let second = determinant([[0.0, 0.5 * e_v, 0.5 * g_u], [0.5 * e_v, e, f], [0.5 * g_u, f, g]]);
    let area_squared = e * g - f * f;
    (first - second) / (area_squared * area_squared)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EdgeLengths;

    /// A sphere on a grid of latitudes and longitudes, and a plane on a grid of circles and rays.
    #[test]
    fn a_sphere_has_curvature_one_and_a_plane_none_in_any_coordinates() {
        let step = 0.02;
        let surface = |size: fn(f64) -> f64| {
            let metric = (0..15 * 15).map(|index| {
                let along = size(0.7 + step * (index / 15) as f64);
                MetricTensor { rr: step * step, rc: 0.0, cc: step * step * along * along }
            });
            Surface::from_metric(15, 15, metric.collect()).unwrap()
        };
        for (size, expected) in [(f64::sin as fn(f64) -> f64, 1.0), (|radius| radius, 0.0)] {
            let edges = EdgeLengths::<f64>::new(&surface(size)).unwrap();
            let found = edges.gaussian_curvature()[edges.chart().bordered(7, 6)];
            approx::assert_abs_diff_eq!(found, expected, epsilon = 2e-3);
        }
    }
}
