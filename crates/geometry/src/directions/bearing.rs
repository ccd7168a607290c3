//! Converts directions to bearings.

use glam::DVec2;

use super::frame::Frame;
use geosweep_surface::Geometry;
use geosweep_surface::Surface;

/// The bearing at points that no source reaches, in degrees.
pub const NO_BEARING: f32 = -1.0;

/// Returns the components towards east and north of the direction of a step of rows and columns.
///
/// Over heights, these are the components in the map seen from above. Otherwise, east is the direction of
/// increasing columns on the surface, and north is at a right angle to it.
pub(super) fn east_and_north(surface: &Surface, frame: &Frame, step: DVec2) -> DVec2 {
    if let Geometry::Heights { spacing, .. } = surface.geometry() {
        return DVec2::new(step.y * spacing.dx, -step.x * spacing.dy);
    }
    match frame.basis() {
        Some([along, across]) => {
            let image = frame.metric * step;
            DVec2::new(along.dot(image), -across.dot(image))
        }
        // The place is on a single row or column, or at a pole.
        None => DVec2::new(step.y, -step.x),
    }
}

/// Returns the compass bearing in degrees: clockwise from north, above 0 and up to 360.
pub(super) fn compass(east_and_north: DVec2) -> f32 {
    turned(east_and_north.x.atan2(east_and_north.y))
}

/// Returns the angle in degrees counter-clockwise from east, above 0 and up to 360, as GRASS counts it.
pub(super) fn grass(east_and_north: DVec2) -> f32 {
    turned(east_and_north.y.atan2(east_and_north.x))
}

/// Returns an angle in degrees above 0 and up to 360. 0 stands for a source in both conventions.
fn turned(angle: f64) -> f32 {
    let degrees = angle.to_degrees();
    let degrees = if degrees <= 0.0 { degrees + 360.0 } else { degrees };
    let rounded = degrees as f32;
    if rounded == 0.0 { 360.0 } else { rounded }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_directions_of_both_conventions() {
        let of = |east, north| {
            let way = DVec2::new(east, north);
            [compass(way), grass(way)]
        };
        assert_eq!(of(1.0, 0.0), [90.0, 360.0]);
        assert_eq!(of(1.0, -0.0), [90.0, 360.0]);
        assert_eq!(of(1.0, -1.0), [135.0, 315.0]);
        assert_eq!(of(0.0, -1.0), [180.0, 270.0]);
        assert_eq!(of(-0.0, -1.0), [180.0, 270.0]);
        assert_eq!(of(-1.0, -1.0), [225.0, 225.0]);
        assert_eq!(of(-1.0, 0.0), [270.0, 180.0]);
        assert_eq!(of(-1.0, -0.0), [270.0, 180.0]);
        assert_eq!(of(-1.0, 1.0), [315.0, 135.0]);
        assert_eq!(of(0.0, 1.0), [360.0, 90.0]);
        assert_eq!(of(1e-60, 1.0), [360.0, 90.0]);
        assert_eq!(of(1.0, 1e-60), [90.0, 360.0]);
    }
}
