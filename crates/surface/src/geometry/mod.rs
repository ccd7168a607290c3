//! Geometry at each grid point: positions, heights or a metric tensor.
//!
//! All code that differs between these kinds is in this folder, so that other code can query [`Geometry`] without
//! knowing the kind. This file validates values, computes positions in space, and cuts and coarsens grids. [`sample`]
//! computes lengths between any two places. [`space`] computes lengths between neighbours in lanes.

mod metric;
mod metric_scale;
mod sample;
mod space;
mod values;

pub use metric::MetricTensor;
#[doc(hidden)]
pub use sample::Sample;
pub(super) use space::{Heights, Metric, Point, Positions, Space};
pub use values::Values;

use glam::{DVec2, DVec3};

use super::{Chart, SurfaceError};
use metric_scale::jumps_in_scale;

/// Distance between neighbouring points of a height field, in the unit of the heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// Distance between columns.
    pub dx: f64,
    /// Distance between rows.
    pub dy: f64,
}

impl Spacing {
    /// Returns a spacing that is equal in both directions.
    pub fn square(spacing: f64) -> Self {
        Self { dx: spacing, dy: spacing }
    }

    /// Returns whether both distances are positive and finite.
    pub fn is_usable(self) -> bool {
        [self.dx, self.dy].iter().all(|d| d.is_finite() && *d > 0.0)
    }
}

/// The geometry at each grid point, row-major.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// 3D points.
    Positions(Values<DVec3>),
    /// Heights over a rectangular grid.
    Heights {
        /// Height of each point.
        heights: Values<f64>,
        /// Distance between points.
        spacing: Spacing,
    },
    /// The metric alone, without positions.
    Metric(Values<MetricTensor>),
}

impl Geometry {
    pub(crate) fn what(&self) -> &'static str {
        match self {
            Self::Positions(_) => "position",
            Self::Heights { .. } => "height",
            Self::Metric(_) => "metric",
        }
    }

    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Positions(positions) => positions.len(),
            Self::Heights { heights, .. } => heights.len(),
            Self::Metric(metric) => metric.len(),
        }
    }

    /// Returns for each point whether it is present, that is, not a hole.
    ///
    /// # Errors
    /// If a value is neither usable nor NaN. The error names the first such value.
    pub(crate) fn points_present(&self, chart: Chart) -> Result<Vec<bool>, SurfaceError> {
        (0..self.len())
            .map(|index| {
                let (nan, usable) = match self {
                    Self::Positions(positions) => {
                        (positions[index].is_nan(), positions[index].is_finite())
                    }
                    Self::Heights { heights, .. } => {
                        (heights[index].is_nan(), heights[index].is_finite())
                    }
                    Self::Metric(metric) => {
                        (metric[index].is_hole(), metric[index].is_positive_definite())
                    }
                };
                if nan || usable {
                    return Ok(!nan);
                }
                let (row, col) = chart.position(index);
                Err(match self {
                    Self::Metric(metric) => {
                        let MetricTensor { rr, rc, cc } = metric[index];
                        SurfaceError::Metric { row, col, rr, rc, cc }
                    }
                    _ => SurfaceError::Infinite { what: self.what(), row, col },
                })
            })
            .collect()
    }

    /// Returns whether this is a metric that jumps as a slowness does, at points that are `present`.
    pub(super) fn jumps_in_scale(&self, chart: Chart, present: &[bool]) -> bool {
        let Self::Metric(metric) = self else { return false };
        jumps_in_scale(chart, metric, present)
    }

    pub(crate) fn position(&self, chart: Chart, row: usize, col: usize) -> Option<DVec3> {
        let index = chart.index(row, col);
        match self {
            Self::Positions(positions) => Some(positions[index]),
            Self::Heights { heights, spacing } => {
                Some(DVec3::new(col as f64 * spacing.dx, row as f64 * spacing.dy, heights[index]))
            }
            Self::Metric(_) => None,
        }
    }

    /// Returns whether points have positions in space, and are not given by a metric alone.
    pub fn has_positions(&self) -> bool {
        !matches!(self, Self::Metric(_))
    }

    /// Returns whether all copies of a point of the surface have the same position. Copies on a height field
    /// do not.
    #[doc(hidden)]
    pub fn is_in_space(&self) -> bool {
        matches!(self, Self::Positions(_))
    }

    /// Returns the three numbers from which edges are measured, on the CPU and in the shaders: a position or,
    /// in the third place, a height, both relative to `origin`; or a metric (rr, rc, cc).
    #[inline(always)]
    pub(crate) fn numbers(&self, index: usize, origin: DVec3) -> [f64; 3] {
        match self {
            Self::Positions(positions) => (positions[index] - origin).to_array(),
            Self::Heights { heights, .. } => [0.0, 0.0, heights[index] - origin.z],
            Self::Metric(metric) => {
                let MetricTensor { rr, rc, cc } = metric[index];
                [rr, rc, cc]
            }
        }
    }

    /// Returns the least and the largest coordinates of the points of a row that are `present`.
    pub(crate) fn row_bounds(&self, chart: Chart, row: usize, present: &[bool]) -> (DVec3, DVec3) {
        let there = |index: &usize| present[*index];
        match self {
            // Positions are read in memory order for speed, since this function reads the whole surface once
            // more.
            Self::Positions(positions) => {
                let (positions, present) = (&positions[chart.row(row)], &present[chart.row(row)]);
                let positions = positions.iter().zip(present);
                bounds(positions.filter_map(|(&at, &is)| is.then_some(at)))
            }
            _ => bounds(chart.row(row).filter(there).filter_map(|index| {
                let (row, col) = chart.position(index);
                self.position(chart, row, col)
            })),
        }
    }

    /// Returns a coordinate or height of a point whose magnitude exceeds `limit`, if there is one.
    pub(crate) fn beyond(&self, index: usize, limit: f64) -> Option<f64> {
        let is_beyond = |value: &f64| value.abs() > limit;
        match self {
            Self::Positions(positions) => positions[index].to_array().into_iter().find(is_beyond),
            Self::Heights { heights, .. } => Some(heights[index]).filter(is_beyond),
            Self::Metric(_) => None,
        }
    }

    /// Returns the geometry of some points. The values of missing points are arbitrary.
    pub(crate) fn gathered(&self, points: impl Iterator<Item = Option<usize>>) -> Self {
        fn all<T: Copy + Default + Send + Sync + 'static>(
            values: &[T],
            points: impl Iterator<Item = Option<usize>>,
        ) -> Values<T> {
            let value = |point: Option<usize>| point.map_or(T::default(), |index| values[index]);
            points.map(value).collect::<Vec<T>>().into()
        }
        match self {
            Self::Positions(positions) => Self::Positions(all(positions, points)),
            Self::Heights { heights, spacing } => {
                Self::Heights { heights: all(heights, points), spacing: *spacing }
            }
            Self::Metric(metric) => Self::Metric(all(metric, points)),
        }
    }

    /// Returns the geometry of some rows and columns, given by the indices of their points. The steps between
    /// them may differ only if points have positions. A metric applies to single steps; a step of the
    /// coarsened grid is `dr` rows or `dc` columns.
    pub(crate) fn coarsened(&self, chart: Chart, kept: &[usize], [dr, dc]: [f64; 2]) -> Self {
        let position = |&index: &usize| {
            let (row, col) = chart.position(index);
            self.position(chart, row, col)
        };
        match self {
            Self::Metric(metric) => {
                let scaled = |&index: &usize| {
                    let MetricTensor { rr, rc, cc } = metric[index];
                    MetricTensor { rr: rr * dr * dr, rc: rc * dr * dc, cc: cc * dc * dc }
                };
                Self::Metric(kept.iter().map(scaled).collect::<Vec<_>>().into())
            }
            _ => Self::Positions(kept.iter().filter_map(position).collect::<Vec<_>>().into()),
        }
    }

    /// Returns the area of the triangle between three grid points. Between positions the triangle is flat.
    /// With a metric its area follows from the mean of the three tensors' unit areas.
    #[doc(hidden)]
    pub fn triangle_area(&self, chart: Chart, points: [usize; 3]) -> f64 {
        let places = points.map(|point| chart.position(point));
        if let Self::Metric(metric) = self {
            let unit = |point: usize| {
                let MetricTensor { rr, rc, cc } = metric[point];
                (rr * cc - rc * rc).sqrt()
            };
            let [a, b, c] = places.map(|(row, col)| DVec2::new(row as f64, col as f64));
            return points.map(unit).iter().sum::<f64>() / 6.0 * (b - a).perp_dot(c - a).abs();
        }
        let [a, b, c] = places.map(|(r, c)| self.position(chart, r, c).unwrap_or_default());
        0.5 * (b - a).cross(c - a).length()
    }

    /// Returns the position or metric at a grid point.
    pub(crate) fn sample(&self, chart: Chart, row: usize, col: usize) -> Sample {
        match (self, self.position(chart, row, col)) {
            (_, Some(position)) => Sample::Position(position),
            (Self::Metric(metric), _) => Sample::Metric {
                at: DVec2::new(row as f64, col as f64),
                tensor: metric[chart.index(row, col)].matrix(),
            },
            (_, None) => unreachable!("only a metric has no positions"),
        }
    }
}

/// Returns the least and the largest coordinates of some positions.
pub(super) fn bounds(positions: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    positions.into_iter().fold(none, |(low, high), at| (low.min(at), high.max(at)))
}
