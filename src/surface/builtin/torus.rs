//! A quarter of a torus.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

/// Radius of the tube; its centre line has radius 1.
const TUBE: f64 = 0.4;

pub(super) fn position(uv: DVec2) -> DVec3 {
    let ((sin_a, cos_a), (sin_b, cos_b)) = ((PI * uv.x).sin_cos(), (PI * uv.y).sin_cos());
    let radius = 1.0 + TUBE * cos_b;
    DVec3::new(radius * cos_a, radius * sin_a, TUBE * sin_b)
}
