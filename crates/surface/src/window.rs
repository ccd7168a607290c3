//! Cuts parts out of a surface.

use std::ops::Range;

use super::chart::{Block, Chart};
use super::{Known, Surface};

impl Surface {
    /// Returns the points of some rows and columns, with their slowness. The part may consist of holes only. The part
    /// is open even if the surface is glued.
    ///
    /// Edges and curvatures of a part are those of the whole surface, except at some points along its sides.
    /// An edge depends on points up to three rows and columns around it. The Gaussian curvature at a point
    /// depends on edges up to two rows and columns around it.
    ///
    /// # Panics
    /// If the grid does not have these rows and columns, or there are none.
    #[doc(hidden)]
    pub fn window(&self, rows: Range<usize>, cols: Range<usize>) -> Self {
        assert!(!rows.is_empty() && !cols.is_empty(), "no point of a surface");
        let chart = Chart { rows: rows.len(), cols: cols.len() };
        let index = |(row, col)| Some(self.chart.index(row, col));
        self.part(chart, Block { rows, cols }.places().map(index))
    }

    /// Returns an open surface on the grid `chart` with the given points. Points without an index are holes.
    pub(super) fn part(
        &self,
        chart: Chart,
        points: impl Iterator<Item = Option<usize>> + Clone,
    ) -> Self {
        let inputs = self.inputs.gathered(points);
        let (edge_rule, known) = (self.edge_rule, Known::default());
        Self { chart, inputs, edge_rule, known, glued: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin::Builtin;
    use crate::{Direction, EdgeLengths, MetricTensor, Spacing};

    /// Margin that covers all points on which a point's update depends.
    const MARGIN: usize = 5;

    /// Edges and curvatures agree up to rounding, since positions are taken relative to the middle of each surface.
    #[test]
    fn inside_a_part_edges_and_curvatures_are_those_of_the_whole() {
        let chart = Chart { rows: 20, cols: 24 };
        let (Chart { rows, cols }, points) = (chart, chart.points());
        let wavy = |k: usize| {
            let (row, col) = chart.position(k);
            (row as f64 * 0.7).sin() + (col as f64 * 0.4).cos()
        };
        let heights = (0..points).map(wavy).collect();
        let metric = |k| MetricTensor { rr: 2.0 + wavy(k), rc: 0.2, cc: 3.0 - wavy(k) };
        let slow = |surface: Surface| {
            surface.with_slowness((0..points).map(|k| 3.0 + wavy(k)).collect()).unwrap()
        };
        let mask: Vec<_> = (0..points).map(|k| k % 53 != 40).collect();
        for whole in [
            Builtin::Torus.surface(rows, cols).unwrap().with_mask(&mask).unwrap(),
            slow(Surface::from_heights(rows, cols, heights, Spacing { dx: 1.5, dy: 0.5 }).unwrap()),
            slow(Surface::from_metric(rows, cols, (0..points).map(metric).collect()).unwrap()),
        ] {
            let (first_row, first_col) = (3, 4);
            let part = whole.window(first_row..18, first_col..23);
            assert_eq!((part.rows(), part.cols()), (15, 19));
            let [of_whole, of_part] = [&whole, &part].map(|s| EdgeLengths::<f64>::new(s).unwrap());
            for row in MARGIN..part.rows() - MARGIN {
                for col in MARGIN..part.cols() - MARGIN {
                    let (r, c) = (first_row + row, first_col + col);
                    assert_eq!(part.has(row, col), whole.has(r, c));
                    for to in Direction::ALL {
                        let [a, b] = [of_part.length(row, col, to), of_whole.length(r, c, to)];
                        approx::assert_relative_eq!(a, b, max_relative = 1e-14);
                    }
                    let curvature = |edges: &EdgeLengths<f64>, row, col| {
                        edges.gaussian_curvature()[edges.chart().bordered(row, col)]
                    };
                    let [a, b] = [curvature(&of_part, row, col), curvature(&of_whole, r, c)];
                    approx::assert_abs_diff_eq!(a, b, epsilon = 1e-11);
                }
            }
        }
    }
}
