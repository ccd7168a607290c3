//! Positions, heights or a metric tensor per point, and the lengths they give.

use glam::{DMat2, DVec2, DVec3};

use super::{Chart, SurfaceError};

/// Distance between neighbouring points of a height field, in the unit of the heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// Between columns.
    pub dx: f64,
    /// Between rows.
    pub dy: f64,
}

impl Spacing {
    /// The same spacing in both directions.
    pub fn square(spacing: f64) -> Self {
        Self { dx: spacing, dy: spacing }
    }

    pub(crate) fn is_usable(self) -> bool {
        [self.dx, self.dy].iter().all(|d| d.is_finite() && *d > 0.0)
    }
}

/// The first fundamental form at a grid point in index coordinates: a small step of `dr` rows
/// and `dc` columns has squared length `rr dr^2 + 2 rc dr dc + cc dc^2` (paper, eq. 3, with
/// u^1 the row and u^2 the column).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetricTensor {
    /// Entry for rows.
    pub rr: f64,
    /// Mixed entry.
    pub rc: f64,
    /// Entry for columns.
    pub cc: f64,
}

impl MetricTensor {
    fn is_hole(self) -> bool {
        self.rr.is_nan() || self.rc.is_nan() || self.cc.is_nan()
    }

    fn is_positive_definite(self) -> bool {
        let finite = self.rr.is_finite() && self.rc.is_finite() && self.cc.is_finite();
        finite && self.rr > 0.0 && self.cc > 0.0 && self.rr * self.cc > self.rc * self.rc
    }

    fn matrix(self) -> DMat2 {
        DMat2::from_cols_array(&[self.rr, self.rc, self.rc, self.cc])
    }
}

/// What is known at each grid point, row-major.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// 3D points.
    Positions(Vec<DVec3>),
    /// Heights over a rectangular grid.
    Heights {
        /// One height per point.
        heights: Vec<f64>,
        /// Distance between points.
        spacing: Spacing,
    },
    /// The metric alone.
    Metric(Vec<MetricTensor>),
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

    /// Which points are no holes; an error at the first value that is neither usable nor NaN.
    pub(crate) fn points_present(&self, chart: Chart) -> Result<Vec<bool>, SurfaceError> {
        let place = |index| {
            let (row, col) = chart.position(index);
            (row, col, self.what())
        };
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
                let (row, col, what) = place(index);
                Err(match self {
                    Self::Metric(metric) => {
                        let MetricTensor { rr, rc, cc } = metric[index];
                        SurfaceError::Metric { row, col, rr, rc, cc }
                    }
                    _ => SurfaceError::Infinite { what, row, col },
                })
            })
            .collect()
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

    /// The point or metric at a grid point.
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

/// The geometry at one place, on the grid or between its points.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sample {
    Position(DVec3),
    Metric { at: DVec2, tensor: DMat2 },
}

impl Sample {
    /// Interpolates between samples of the same kind, given weights that add up to one.
    pub(crate) fn interpolate(samples: &[(f64, Self)]) -> Self {
        let mut sum = match samples[0].1 {
            Self::Position(_) => Self::Position(DVec3::ZERO),
            Self::Metric { .. } => Self::Metric { at: DVec2::ZERO, tensor: DMat2::ZERO },
        };
        for &(weight, sample) in samples {
            match (&mut sum, sample) {
                (Self::Position(sum), Self::Position(position)) => *sum += weight * position,
                (Self::Metric { at, tensor }, Self::Metric { at: a, tensor: t }) => {
                    *at += weight * a;
                    *tensor += t * weight;
                }
                _ => unreachable!("a surface has one kind of geometry"),
            }
        }
        sum
    }

    /// Length of the straight step between two places: the chord between positions, or the
    /// step measured by the metric at each end, averaged.
    pub(crate) fn length_to(self, other: Self) -> f64 {
        match (self, other) {
            (Self::Position(a), Self::Position(b)) => a.distance(b),
            (Self::Metric { at: a, tensor: g }, Self::Metric { at: b, tensor: h }) => {
                let m = b - a;
                0.5 * (m.dot(g * m).max(0.0).sqrt() + m.dot(h * m).max(0.0).sqrt())
            }
            _ => unreachable!("a surface has one kind of geometry"),
        }
    }

    /// Where on the straight line from `a` (0) to `b` (1) this place is nearest.
    pub(crate) fn foot_on(self, a: Self, b: Self) -> f64 {
        let (along, across) = match (self, a, b) {
            (Self::Position(x), Self::Position(a), Self::Position(b)) => {
                ((b - a).length_squared(), (x - a).dot(b - a))
            }
            (
                Self::Metric { at: x, tensor },
                Self::Metric { at: a, .. },
                Self::Metric { at: b, .. },
            ) => ((b - a).dot(tensor * (b - a)), (x - a).dot(tensor * (b - a))),
            _ => unreachable!("a surface has one kind of geometry"),
        };
        if along > 0.0 { (across / along).clamp(0.0, 1.0) } else { 0.0 }
    }
}
