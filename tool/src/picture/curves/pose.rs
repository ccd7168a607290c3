//! Turns a surface towards the viewer.

use geosweep::Surface;
use geosweep::glam::DVec3;
use geosweep::io::Orientation;
use geosweep::surface::{Direction, Geometry};

use super::super::relief::{Tangents, exaggeration};

/// The transformation from the surface's space to the picture's space, and the camera there.
pub struct Pose {
    /// The factor of heights.
    pub exaggeration: f64,
    /// The normal of a mirror, if the picture would be reversed without one. This is so for heights, whose y
    /// axis points in the direction of increasing rows. It is also so for other open surfaces if their
    /// columns would run to the left in the default view.
    mirror: Option<DVec3>,
    pub toward: DVec3,
    pub up: DVec3,
}

/// The length of the mean normal below which a surface counts as closed.
const CLOSED: f64 = 0.3;
/// The length of the mean normal above which a surface counts as flat and is seen straight on.
const FLAT: f64 = 0.9999;

impl Pose {
    /// Chooses the view of a surface. Terrain is seen obliquely from the south. Other open surfaces are seen
    /// from the side to which they bulge, with rows downwards and columns to the right. Closed surfaces are
    /// seen obliquely from above, with the z axis upwards.
    ///
    /// The direction `toward` and the default view of terrain are those of a map on which the terrain has an
    /// orientation: x points to the east and y to the south.
    pub fn of(shape: &Surface, toward: Option<DVec3>, orientation: Orientation) -> Self {
        let on_grid = |DVec3 { x, y, z }: DVec3| {
            let [x, y] = orientation.on_grid([x, y]);
            DVec3 { x, y, z }
        };
        let toward = toward.map(on_grid);
        let heights = matches!(shape.geometry(), Geometry::Heights { .. });
        let exaggeration = exaggeration(shape);
        let tangents = Tangents { shape, exaggeration };
        let normal = tangents.mean(|row, col| tangents.normal(row, col));
        let east = tangents.mean(|row, col| tangents.along(row, col, Direction::East));
        let south = tangents.mean(|row, col| tangents.along(row, col, Direction::South));
        let closed = normal.length() < CLOSED;
        let (own, up) = match (heights, closed) {
            (true, _) => (on_grid(DVec3::new(0.22, 0.8, 0.75)), DVec3::Z),
            (_, true) => (DVec3::new(0.6, -1.0, 0.55), DVec3::Z),
            _ => {
                let tilt = if normal.length() > FLAT { 0.0 } else { 1.0 };
                let normal = normal.normalize() * bulge(shape, normal);
                let east = east.reject_from(normal).normalize_or_zero();
                let south = south.reject_from(normal).normalize_or_zero();
                (normal + tilt * (0.35 * east - 0.15 * south), -south)
            }
        };
        let right = up.cross(toward.unwrap_or(own)).try_normalize();
        let against = right.filter(|right| right.dot(east) < 0.0);
        let mirror = match (heights, toward) {
            // Columns, rows and heights are left-handed, unless the map has them the other way round.
            (true, _) => right.filter(|_| !orientation.is_mirrored()),
            (false, None) if !closed => against,
            _ => None,
        };
        Self { exaggeration, mirror, toward: toward.unwrap_or(own), up }
    }

    /// Transforms a position on the surface to the picture's space.
    pub fn place(&self, position: DVec3) -> DVec3 {
        let position = position * DVec3::new(1.0, 1.0, self.exaggeration);
        match self.mirror {
            Some(mirror) => position - 2.0 * position.dot(mirror) * mirror,
            None => position,
        }
    }
}

/// Returns 1 if the surface's middle lies in front of its border in the direction of the normal, and
/// otherwise -1.
fn bulge(shape: &Surface, normal: DVec3) -> f64 {
    let chart = shape.chart();
    let is_inner = |row, col| Direction::ALL.iter().all(|&to| shape.has_edge(row, col, to));
    let mut sums = [(DVec3::ZERO, 0.0); 2];
    for index in 0..chart.points() {
        let (row, col) = chart.position(index);
        if let Some(position) = shape.position(row, col) {
            let (sum, count) = &mut sums[usize::from(is_inner(row, col))];
            *sum += position;
            *count += 1.0;
        }
    }
    let [border, inner] = sums.map(|(sum, count)| sum / f64::max(count, 1.0));
    if (inner - border).dot(normal) < 0.0 { -1.0 } else { 1.0 }
}
