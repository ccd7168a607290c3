//! Defines one face of the equiangular cube sphere.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use super::jet::Smooth;

pub(super) fn position<T: Smooth>(uv: [T; 2]) -> [T; 3] {
    let [x, y] = uv.map(|along| ((along - 0.5) * FRAC_PI_2).tan());
    let shrink = (x.squared() + y.squared() + 1.0).recip_sqrt();
    [x * shrink, y * shrink, shrink]
}

pub(super) fn distance(a: DVec2, b: DVec2) -> f64 {
    let [a, b] = [a, b].map(|uv| DVec3::from_array(position(uv.to_array())));
    great_circle(a, b)
}

/// Returns the distance along the great circle. The formula is accurate for near, orthogonal and opposite
/// points alike.
pub(super) fn great_circle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
