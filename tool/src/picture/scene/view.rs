//! Projects points in space to pixels.

use geosweep::glam::{DVec3, Vec3};

/// An orthographic camera. Parallel lines stay parallel, and lengths across the line of sight are true
/// everywhere.
#[derive(Clone, Copy)]
pub struct View {
    right: DVec3,
    up: DVec3,
    toward: DVec3,
    /// The point in the middle of the picture.
    center: DVec3,
    /// The pixels per unit of length.
    scale: f64,
    pub width: usize,
    pub height: usize,
}

/// The fraction of the picture that stays free on each side.
const MARGIN: f64 = 0.04;

impl View {
    /// Returns a view from the direction `toward`, with `up` upwards in the picture as far as possible. The
    /// scale is the largest at which all points fit.
    pub fn fit(
        toward: DVec3,
        up: DVec3,
        points: impl Iterator<Item = DVec3> + Clone,
        width: usize,
        height: usize,
    ) -> Self {
        let toward = toward.try_normalize().unwrap_or(DVec3::Z);
        let right = up.cross(toward);
        let right = right.try_normalize().unwrap_or_else(|| toward.any_orthonormal_vector());
        let up = toward.cross(right);
        let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            let seen = DVec3::new(p.dot(right), p.dot(up), p.dot(toward));
            (low.min(seen), high.max(seen))
        });
        let (low, high) = if low.is_finite() { (low, high) } else { (DVec3::ZERO, DVec3::ONE) };
        let extent = (high - low).max(DVec3::splat(f64::MIN_POSITIVE));
        let free = 1.0 - 2.0 * MARGIN;
        let scale = (free * width as f64 / extent.x).min(free * height as f64 / extent.y);
        let middle = 0.5 * (low + high);
        let center = middle.x * right + middle.y * up + middle.z * toward;
        Self { right, up, toward, center, scale, width, height }
    }

    /// Returns the pixel (x, y) of a point, and its distance in front of the middle, all in pixels.
    pub fn pixel(&self, point: DVec3) -> Vec3 {
        let middle = DVec3::new((self.width - 1) as f64, (self.height - 1) as f64, 0.0) / 2.0;
        let seen = self.turn(point - self.center) * self.scale;
        (middle + DVec3::new(seen.x, -seen.y, seen.z)).as_vec3()
    }

    /// Returns a direction as seen by the viewer: (rightwards, upwards, towards the viewer).
    pub fn turn(&self, direction: DVec3) -> DVec3 {
        DVec3::new(direction.dot(self.right), direction.dot(self.up), direction.dot(self.toward))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fitted_points_lie_inside_with_a_margin() {
        let corners = (0..8).map(|k| {
            DVec3::new(f64::from(k & 1), 3.0 * f64::from(k >> 1 & 1), 2.0 * f64::from(k >> 2))
        });
        let view = View::fit(DVec3::new(1.0, -2.0, 0.7), DVec3::Z, corners.clone(), 300, 200);
        let pixels: Vec<_> = corners.map(|corner| view.pixel(corner)).collect();
        let range = |along: fn(&Vec3) -> f32| {
            let values = pixels.iter().map(along);
            (values.clone().fold(f32::INFINITY, f32::min), values.fold(0.0, f32::max))
        };
        let ((left, right), (top, bottom)) = (range(|p| p.x), range(|p| p.y));
        assert!(left > 0.0 && right < 299.0 && top > 0.0 && bottom < 199.0);
        // The points reach one of the two pairs of sides, up to the margin.
        let free = ((right - left) / 300.0).max((bottom - top) / 200.0);
        approx::assert_abs_diff_eq!(free, 0.92, epsilon = 1e-4);
    }

    #[test]
    fn up_is_up_and_nearer_is_nearer() {
        let points = [DVec3::ZERO, DVec3::ONE].into_iter();
        let view = View::fit(DVec3::new(0.0, -1.0, 0.2), DVec3::Z, points, 100, 100);
        assert!(view.pixel(DVec3::Z).y < view.pixel(DVec3::ZERO).y);
        assert!(view.pixel(-DVec3::Y).z > view.pixel(DVec3::Y).z);
        assert!(view.pixel(DVec3::X).x > view.pixel(DVec3::ZERO).x);
    }
}
