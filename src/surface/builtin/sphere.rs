//! One face of the equiangular cube sphere.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

pub(super) fn position(uv: DVec2) -> DVec3 {
    let tan = |x: f64| (FRAC_PI_2 * (x - 0.5)).tan();
    DVec3::new(tan(uv.x), tan(uv.y), 1.0).normalize()
}

/// Along the great circle: good for near, orthogonal and opposite points alike.
pub(super) fn distance(a: DVec2, b: DVec2) -> f64 {
    let (a, b) = (position(a), position(b));
    a.cross(b).length().atan2(a.dot(b))
}
