//! Inputs at each grid point: a geometry, whether the point is present, and a slowness.

use super::geometry::Geometry;

/// The inputs at each grid point, row-major.
#[derive(Clone, Debug)]
pub(super) struct Inputs {
    pub geometry: Geometry,
    pub slowness: Option<Vec<f64>>,
    pub present: Vec<bool>,
    /// Whether the geometry is a metric that jumps. The updates then treat the metric's scale as a slowness
    /// (`geometry/metric_scale.rs`).
    pub is_scaled: bool,
}

impl Inputs {
    /// Returns the inputs at some points. Points without an index are holes.
    pub(super) fn gathered(&self, points: impl Iterator<Item = Option<usize>> + Clone) -> Self {
        let slowness = |slowness: &Vec<f64>| {
            points.clone().map(|point| point.map_or(1.0, |index| slowness[index])).collect()
        };
        Self {
            geometry: self.geometry.gathered(points.clone()),
            slowness: self.slowness.as_ref().map(slowness),
            present: points.map(|point| point.is_some_and(|at| self.present[at])).collect(),
            is_scaled: self.is_scaled,
        }
    }
}
