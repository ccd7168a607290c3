//! Computes the lighting of a surface.

use geosweep::glam::Vec3;

use super::super::canvas::{Color, mix};

/// The direction of the light: from the viewer's side and the upper left.
const LIGHT: Vec3 = Vec3::new(-0.48, 0.60, 0.64);
/// The strength of ambient light. `SKY` is the additional strength from above.
const AMBIENT: f32 = 0.54;
const SKY: f32 = 0.06;
/// The strength of directional light, which wraps around the surface. Parts that face away keep their shape
/// too, and dark colours do not become black there.
const DIFFUSE: f32 = 0.44;
/// The strength of a soft highlight. `SHARPNESS` is its exponent.
const HIGHLIGHT: f32 = 0.22;
const SHARPNESS: f32 = 28.0;

/// Returns a colour under the light. `normal` is the normal of the visible side, as (rightwards, upwards,
/// towards the viewer). It need not have unit length.
pub fn lit(color: Color, normal: Vec3) -> Color {
    let normal = normal.normalize_or(Vec3::Z);
    let light = LIGHT.normalize();
    let brightness = AMBIENT + SKY * normal.y + DIFFUSE * 0.5 * (1.0 + normal.dot(light));
    let halfway = (light + Vec3::Z).normalize();
    let highlight = HIGHLIGHT * normal.dot(halfway).max(0.0).powf(SHARPNESS);
    mix(color.map(|channel| (channel * brightness).min(1.0)), [1.0; 3], highlight)
}
