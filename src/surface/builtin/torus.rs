//! Defines a quarter of a torus.

use std::f64::consts::PI;

use super::jet::Smooth;

/// Radius of the tube; its centre line has radius 1.
const TUBE: f64 = 0.4;

pub(super) fn position<T: Smooth>([u, v]: [T; 2]) -> [T; 3] {
    let ((sin_a, cos_a), (sin_b, cos_b)) = ((u * PI).sin_cos(), (v * PI).sin_cos());
    let radius = cos_b * TUBE + 1.0;
    [radius * cos_a, radius * sin_a, sin_b * TUBE]
}
