//! Defines the built-in surfaces that unroll into the plane: sheared plane, cylinder and cone.

use std::f64::consts::PI;

use glam::DVec2;

use super::jet::Smooth;

pub(super) fn shear<T: Smooth>(degrees: f64, [u, v]: [T; 2]) -> [T; 3] {
    [u + v * degrees.to_radians().tan(), v, T::from(0.0)]
}

pub(super) fn shear_distance(degrees: f64, a: DVec2, b: DVec2) -> f64 {
    let [across, along, _] = shear(degrees, (b - a).to_array());
    across.hypot(along)
}

/// The angle that cylinder and cone cover, in radians: three quarters of a turn.
const ANGLE: f64 = 1.5 * PI;
const HEIGHT: f64 = 3.0;

pub(super) fn cylinder<T: Smooth>([u, v]: [T; 2]) -> [T; 3] {
    let (sin, cos) = (u * ANGLE).sin_cos();
    [cos, sin, v * HEIGHT]
}

pub(super) fn cylinder_distance(a: DVec2, b: DVec2) -> f64 {
    let unrolled = |uv: DVec2| DVec2::new(ANGLE * uv.x, HEIGHT * uv.y);
    unrolled(a).distance(unrolled(b))
}

/// The cone's radius per slant height: the sine of its half-angle, 30 degrees.
const SLOPE: f64 = 0.5;
/// Slant height of the cone's inner border.
const INNER: f64 = 0.5;

pub(super) fn cone<T: Smooth>([u, v]: [T; 2]) -> [T; 3] {
    let slant = v + INNER;
    let (sin, cos) = (u * ANGLE).sin_cos();
    [slant * cos * SLOPE, slant * sin * SLOPE, slant * (1.0 - SLOPE * SLOPE).sqrt()]
}

pub(super) fn cone_distance(a: DVec2, b: DVec2) -> f64 {
    let angle = SLOPE * ANGLE * (a.x - b.x).abs();
    annulus_distance(INNER, INNER + a.y, INNER + b.y, angle)
}

/// Returns the distance, outside a circle of radius `inner` around the origin, between points at radii `r1` and `r2`
/// and an `angle` apart. Seen from the origin, the path turns by `angle` around the circle, so the result is also right
/// above 180 degrees.
fn annulus_distance(inner: f64, r1: f64, r2: f64, angle: f64) -> f64 {
    // The angle, seen from the origin, between a point at radius r and the point where a tangent from it touches the
    // circle.
    let to_tangent = |r: f64| (inner / r).min(1.0).acos();
    let arc = angle - to_tangent(r1) - to_tangent(r2);
    if arc > 0.0 {
        let tangent = |r: f64| ((r - inner) * (r + inner)).max(0.0).sqrt();
        tangent(r1) + tangent(r2) + inner * arc
    } else {
        // The law of cosines, in a form without cancellation at small angles.
        (r1 - r2).hypot(2.0 * (r1 * r2).sqrt() * (0.5 * angle).sin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn around_the_inner_circle_the_path_is_two_tangents_and_an_arc() {
        let diagonal = 2.0f64.sqrt();
        // Of the 180 degrees, the first tangent spans 45, the arc 90 and the second tangent 45.
        let distance = annulus_distance(1.0, diagonal, diagonal, PI);
        approx::assert_relative_eq!(distance, 2.0 + PI / 2.0, max_relative = 1e-15);
        approx::assert_relative_eq!(annulus_distance(1.0, 1.0, 1.0, 5.0), 5.0);
        // The path is straight as long as it does not meet the circle, and the distance is continuous where
        // it does.
        approx::assert_relative_eq!(annulus_distance(1.0, 3.0, 4.0, PI / 2.0), 5.0);
        let touching = annulus_distance(1.0, diagonal, diagonal, PI / 2.0);
        approx::assert_relative_eq!(touching, 2.0, max_relative = 1e-12);
        let just_bent = annulus_distance(1.0, diagonal, diagonal, PI / 2.0 + 1e-9);
        approx::assert_relative_eq!(just_bent, touching, max_relative = 1e-8);
    }
}
