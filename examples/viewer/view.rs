//! Data that all shaders of the viewer share: the twin of `View` in shaders/view.wgsl.

use bytemuck::{Pod, Zeroable};
use geosweep::glam::{Mat4, Vec2, Vec3};

use crate::camera::Camera;
use crate::surfaces::Look;

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct View {
    projection: [[f32; 4]; 4],
    pick: [[f32; 4]; 4],
    eye: [f32; 3],
    pixel: f32,
    half: [f32; 2],
    ground: f32,
    phase: f32,
    grid: [u32; 2],
    spacing: f32,
    softness: f32,
    decal: f32,
    pace: f32,
    /// Padding up to a multiple of 16 bytes. Each direction is padded too.
    unused: [f32; 2],
    light: [f32; 3],
    unused_too: f32,
    sky: [f32; 3],
    last_unused: f32,
}

/// Direction to the sun over the ground.
const SUN: Vec3 = Vec3::new(-0.52, 0.66, 0.40);
/// Directions to the sun and the sky of a surface that floats, in the camera's axes: rightwards, upwards and towards
/// the eye.
const OWN_SUN: Vec3 = Vec3::new(-0.35, 0.40, 1.00);
const OWN_SKY: Vec3 = Vec3::new(0.0, 0.6, 0.8);

/// Values that change from frame to frame, except for the camera.
pub struct Driven {
    /// Pointer in pixels from the upper left.
    pub pointer: Vec2,
    /// Time of the deformation, in seconds.
    pub phase: f32,
    /// Distance between lines; negative if lines are drawn as curves.
    pub spacing: f32,
    /// Radius of the decal.
    pub decal: f32,
    /// Length that agents walk in this frame.
    pub pace: f32,
}

impl View {
    pub fn new(camera: &Camera, look: &Look, size: Vec2, driven: &Driven) -> Self {
        let Driven { pointer, phase, spacing, decal, pace } = *driven;
        let projection = camera.projection(size);
        // A surface that can be seen from below has its light from beside the eye.
        let (light, sky) = match look.ground {
            Some(_) => (SUN, Vec3::Y),
            None => (camera.axes() * OWN_SUN, camera.axes() * OWN_SKY),
        };
        let (chart, ground) = (look.chart, look.ground.unwrap_or_default());
        Self {
            projection: projection.to_cols_array_2d(),
            pick: (pixel(pointer, size) * projection).to_cols_array_2d(),
            eye: camera.eye().to_array(),
            pixel: camera.pixel(size),
            half: ground.half.to_array(),
            ground: ground.height,
            phase,
            grid: [chart.cols as u32, chart.rows as u32],
            spacing,
            softness: ground.softness,
            decal,
            pace,
            unused: [0.0; 2],
            light: light.to_array(),
            unused_too: 0.0,
            sky: sky.to_array(),
            last_unused: 0.0,
        }
    }
}

/// Returns the transformation that enlarges one pixel to the whole picture.
fn pixel(at: Vec2, size: Vec2) -> Mat4 {
    let centre = Vec2::new(2.0, -2.0) * (at + 0.5) / size + Vec2::new(-1.0, 1.0);
    Mat4::from_scale(Vec3::new(size.x, size.y, 1.0)) * Mat4::from_translation(-centre.extend(0.0))
}
