//! The unit square in which distances are computed, and the margin around it.

use glam::DVec2;

use super::ray::Ray;

/// Width of the margin beyond the unit square's border in which geodesics are followed.
pub(super) const MARGIN: f64 = 0.05;

/// Returns whether a place lies in the unit square, at least `from_border` from its border.
pub(super) fn is_inside(uv: DVec2, from_border: f64) -> bool {
    (uv - 0.5).abs().max_element() <= 0.5 - from_border
}

/// Returns whether a ray is inside the margin and has not been met by its neighbours.
pub(super) fn is_followed(ray: &Ray) -> bool {
    is_inside(ray.at, -MARGIN) && ray.spread >= 0.0
}
