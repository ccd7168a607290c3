//! Computes hill shading: how brightly each grid point is lit from the north-west.

use geosweep::Surface;
use geosweep::glam::DVec3;
use geosweep::surface::{Direction, Geometry};
use rayon::prelude::*;

use super::canvas::{Color, mix};

/// The brightness of each grid point, relative to level ground (1). It is empty if all points are as bright
/// as level ground.
pub struct Relief(Vec<f32>);

/// The slope that terrain is exaggerated to, as the root mean square of its slopes.
const WANTED_SLOPE: f64 = 0.5;
/// The largest exaggeration of heights. Terrain is never drawn flatter than it is.
const LARGEST_EXAGGERATION: f64 = 12.0;

impl Relief {
    /// Returns the relief of level ground.
    pub fn level() -> Self {
        Self(Vec::new())
    }

    pub fn of(shape: &Surface) -> Self {
        let tangents = Tangents { shape, exaggeration: exaggeration(shape) };
        if matches!(shape.geometry(), Geometry::Metric(_)) {
            return Self::level();
        }
        let light = Light::north_west(&tangents);
        let chart = shape.chart();
        let brightness = |index| {
            let (row, col) = chart.position(index);
            tangents.normal(row, col).map_or(1.0, |normal| light.on(normal))
        };
        Self((0..chart.points()).into_par_iter().map(brightness).collect())
    }

    pub fn brightness(&self, index: usize) -> f32 {
        self.0.get(index).copied().unwrap_or(1.0)
    }
}

/// Differences between neighbouring points, with exaggerated heights.
pub struct Tangents<'a> {
    pub shape: &'a Surface,
    pub exaggeration: f64,
}

impl Tangents<'_> {
    pub fn position(&self, row: usize, col: usize) -> Option<DVec3> {
        let position = self.shape.position(row, col)?;
        Some(position * DVec3::new(1.0, 1.0, self.exaggeration))
    }

    /// Returns half the vector between the two neighbours along a direction. If there is only one, returns
    /// the step to or from it.
    pub fn along(&self, row: usize, col: usize, to: Direction) -> Option<DVec3> {
        let here = self.position(row, col)?;
        let at = |to| {
            let (row, col) = self.shape.chart().neighbour(row, col, to)?;
            self.position(row, col)
        };
        match (at(to), at(to.opposite())) {
            (Some(ahead), Some(behind)) => Some(0.5 * (ahead - behind)),
            (Some(ahead), None) => Some(ahead - here),
            (None, Some(behind)) => Some(here - behind),
            (None, None) => None,
        }
    }

    pub fn normal(&self, row: usize, col: usize) -> Option<DVec3> {
        let east = self.along(row, col, Direction::East)?;
        let south = self.along(row, col, Direction::South)?;
        east.cross(south).try_normalize()
    }

    /// Returns the mean of a direction over a sample of the surface.
    pub fn mean(&self, direction: impl Fn(usize, usize) -> Option<DVec3>) -> DVec3 {
        let chart = self.shape.chart();
        let every = (chart.points() / 10_000).max(1);
        let directions = (0..chart.points()).step_by(every).filter_map(|index| {
            let (row, col) = chart.position(index);
            direction(row, col)?.try_normalize()
        });
        let (sum, count) =
            directions.fold((DVec3::ZERO, 0), |(sum, count), d| (sum + d, count + 1));
        sum / f64::from(count.max(1))
    }
}

/// Returns the factor by which the heights of terrain are exaggerated.
pub fn exaggeration(shape: &Surface) -> f64 {
    let Geometry::Heights { spacing, .. } = shape.geometry() else { return 1.0 };
    let plain = Tangents { shape, exaggeration: 1.0 };
    let chart = shape.chart();
    let (mut sum, mut count) = (0.0, 0u32);
    for index in (0..chart.points()).step_by((chart.points() / 100_000).max(1)) {
        let (row, col) = chart.position(index);
        let rise = |to| plain.along(row, col, to).map(|along| along.z);
        if let (Some(east), Some(south)) = (rise(Direction::East), rise(Direction::South)) {
            sum += (east / spacing.dx).powi(2) + (south / spacing.dy).powi(2);
            count += 1;
        }
    }
    let slope = (sum / f64::from(count.max(1))).sqrt();
    if slope > 0.0 { (WANTED_SLOPE / slope).clamp(1.0, LARGEST_EXAGGERATION) } else { 1.0 }
}

/// Directional light, in the surface's space.
struct Light {
    direction: DVec3,
    /// The fraction of ambient light.
    ambient: f64,
    level: f64,
}

impl Light {
    /// Returns light from the top left of the picture, 45 degrees above the surface's mean plane.
    fn north_west(tangents: &Tangents) -> Self {
        let up = tangents.mean(|row, col| tangents.normal(row, col));
        let east = tangents.mean(|row, col| tangents.along(row, col, Direction::East));
        // A closed surface has no mean plane. It is lit at 45 degrees to the z axis, and softly, since parts
        // of it face away from the light.
        let closed = up.length() < 0.3;
        let up = if closed { DVec3::Z } else { up.normalize() };
        let east = east.reject_from_normalized(up);
        let east =
            if east.length() < 1e-3 { up.any_orthonormal_vector() } else { east.normalize() };
        let south = up.cross(east);
        let direction = (-0.5 * (east + south) + up * 0.5f64.sqrt()).normalize();
        let ambient = if closed { 0.5 } else { 0.0 };
        let level = if closed { 0.75 } else { direction.dot(up) };
        Self { direction, ambient, level }
    }

    fn on(&self, normal: DVec3) -> f32 {
        let lambert = self.direction.dot(normal);
        let soft = self.ambient * 0.5 * (1.0 + lambert) + (1.0 - self.ambient) * lambert;
        (soft.max(0.0) / self.level) as f32
    }
}

/// Applies a brightness to a colour. In the shade the colour is darkened, but stays distinguishable. In the
/// light it is lightened towards white. On level ground it does not change.
pub fn shade(color: Color, brightness: f32) -> Color {
    const DARKENING: f32 = 0.4;
    const LIGHTENING: f32 = 0.7;
    if brightness <= 1.0 {
        color.map(|channel| channel * (1.0 - DARKENING * (1.0 - brightness)))
    } else {
        mix(color, [1.0; 3], LIGHTENING * (brightness - 1.0).min(1.0))
    }
}
