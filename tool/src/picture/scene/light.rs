//! How a surface looks in the light.

use geosweep::glam::Vec3;

use super::super::canvas::{Color, mix};

/// Where the light comes from, beside the viewer: from the upper left.
const LIGHT: Vec3 = Vec3::new(-0.48, 0.60, 0.64);
/// Light from all around; more of it from above.
const AMBIENT: f32 = 0.54;
const SKY: f32 = 0.06;
/// Light from one side, which reaches around the surface: what turns away has its shape too, and colours
/// of a dark scale do not become black there.
const DIFFUSE: f32 = 0.44;
/// A soft highlight: its strength, and how sharp it is.
const HIGHLIGHT: f32 = 0.22;
const SHARPNESS: f32 = 28.0;

/// The colour under the light. The normal of the side that is seen points rightwards, upwards,
/// towards the viewer, and need not have length 1.
pub fn lit(color: Color, normal: Vec3) -> Color {
    let normal = normal.normalize_or(Vec3::Z);
    let light = LIGHT.normalize();
    let brightness = AMBIENT + SKY * normal.y + DIFFUSE * 0.5 * (1.0 + normal.dot(light));
    let halfway = (light + Vec3::Z).normalize();
    let highlight = HIGHLIGHT * normal.dot(halfway).max(0.0).powf(SHARPNESS);
    mix(color.map(|channel| (channel * brightness).min(1.0)), [1.0; 3], highlight)
}
