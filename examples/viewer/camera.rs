//! A camera that orbits the origin.

use std::f32::consts::{FRAC_PI_2, TAU};

use geosweep::glam::camera::rh::{proj::directx, view};
use geosweep::glam::{Mat3, Mat4, Vec2, Vec3};

/// Half the angle between the upper and lower edge of the picture.
const HALF_ANGLE: f32 = 0.27;

#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Angle around the vertical, 0 looking north.
    pub turn: f32,
    /// Angle above the horizon.
    pub pitch: f32,
    pub distance: f32,
    /// Height of the point in the middle of the picture.
    pub height: f32,
    /// Lowest pitch.
    pub lowest: f32,
}

impl Camera {
    /// Returns a camera that shows all of a ball around the origin, level and from the south.
    pub fn around(radius: f32) -> Self {
        let distance = 1.1 * radius / HALF_ANGLE.sin();
        Self { turn: 0.0, pitch: 0.0, distance, height: 0.0, lowest: 0.0 }
    }

    /// Looks from a direction, given by its angle around the vertical and that above the horizon.
    pub fn look_from(&mut self, turn: f32, pitch: f32) {
        self.turn = turn % TAU;
        self.pitch = pitch.clamp(self.lowest, FRAC_PI_2 - 0.01);
    }

    /// Turns the camera by a movement of the pointer in pixels.
    pub fn orbit(&mut self, by: Vec2) {
        self.look_from(self.turn - 0.006 * by.x, self.pitch + 0.006 * by.y);
    }

    /// Zooms by a number of notches of the wheel.
    pub fn zoom(&mut self, by: f32, reach: f32) {
        self.distance = (self.distance * 0.88f32.powf(by)).clamp(0.2 * reach, 6.0 * reach);
    }

    fn target(&self) -> Vec3 {
        Vec3::new(0.0, self.height, 0.0)
    }

    /// Returns the directions rightwards, upwards and towards the eye.
    pub fn axes(&self) -> Mat3 {
        Mat3::from_rotation_y(self.turn) * Mat3::from_rotation_x(-self.pitch)
    }

    pub fn eye(&self) -> Vec3 {
        let (sin, cos) = self.turn.sin_cos();
        let away = Vec3::new(sin * self.pitch.cos(), self.pitch.sin(), cos * self.pitch.cos());
        self.target() + self.distance * away
    }

    /// Returns the transformation from the world to clip coordinates.
    pub fn projection(&self, size: Vec2) -> Mat4 {
        let (near, far) = (0.02 * self.distance, 20.0 * self.distance);
        // y is upwards, as in WGSL.
        let lens = directx::perspective(2.0 * HALF_ANGLE, size.x / size.y, near, far);
        lens * view::look_at_mat4(self.eye(), self.target(), Vec3::Y)
    }

    /// Returns the length of a pixel in the middle of the picture, in units of the world.
    pub fn pixel(&self, size: Vec2) -> f32 {
        2.0 * HALF_ANGLE.tan() * self.distance / size.y
    }
}
