//! Tells how much a map lengthens distances on the ground.

use crate::{CoordinateSystem, Georeference};
use geosweep_surface::{Chart, Ellipsoid};

/// The scale of a conformal map over a grid: the length on the map of a unit length on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapScale {
    /// Name of the projection.
    pub projection: &'static str,
    /// Least and largest scale at the corners and in the middle of the grid.
    pub range: [f64; 2],
}

/// A conformal projection.
#[derive(Clone, Copy)]
enum Projection {
    Mercator,
    /// With the scale and the easting of the central meridian.
    TransverseMercator {
        scale: f64,
        easting: f64,
    },
    /// With the scale at the pole, and the easting and northing of the pole.
    PolarStereographic {
        scale: f64,
        pole: f64,
    },
}

/// Difference of a scale from 1 at which it matters to distances.
const FAR_FROM_ONE: f64 = 0.01;

impl Georeference {
    /// Returns the scale of the map over a grid, if it differs from 1 by more than a hundredth anywhere and the map's
    /// projection is known here: Mercator, UTM and polar stereographic maps of the EPSG register.
    pub fn map_scale(&self, Chart { rows, cols }: Chart) -> Option<MapScale> {
        let Some(CoordinateSystem::Projected(epsg)) = self.system else { return None };
        let projection = Projection::of(epsg)?;
        let ends = |count: usize| [0.0, 0.5 * (count - 1) as f64, (count - 1) as f64];
        let places = ends(rows).into_iter().flat_map(|row| ends(cols).map(|col| [row, col]));
        let scales = places.map(|place| projection.scale(self.coordinates(place)));
        let range = scales.fold([f64::INFINITY, 0.0], |[least, largest]: [f64; 2], scale| {
            [least.min(scale), largest.max(scale)]
        });
        let is_far = range.iter().any(|scale| (scale - 1.0).abs() > FAR_FROM_ONE);
        is_far.then(|| MapScale { projection: projection.name(), range })
    }
}

impl Projection {
    fn of(epsg: u16) -> Option<Self> {
        // The scale at the pole that is 1 at a latitude.
        let polar = |latitude: f64| Self::PolarStereographic {
            scale: 0.5 * (1.0 + latitude.to_radians().sin()),
            pole: 0.0,
        };
        Some(match epsg {
            3857 | 3785 | 3395 => Self::Mercator,
            32601..=32660 | 32701..=32760 | 25828..=25838 | 26901..=26923 => {
                Self::TransverseMercator { scale: 0.9996, easting: 5e5 }
            }
            3031 | 3995 => polar(71.0),
            3411..=3413 | 3976 => polar(70.0),
            32661 | 32761 | 5041 | 5042 => Self::PolarStereographic { scale: 0.994, pole: 2e6 },
            _ => return None,
        })
    }

    fn name(self) -> &'static str {
        match self {
            Self::Mercator => "Mercator",
            Self::TransverseMercator { .. } => "transverse Mercator",
            Self::PolarStereographic { .. } => "polar stereographic",
        }
    }

    /// Returns the scale at a place, as on a sphere. The flattening changes it by less than a hundredth.
    fn scale(self, [x, y]: [f64; 2]) -> f64 {
        let radius = Ellipsoid::WGS_84.equator;
        match self {
            Self::Mercator => (y / radius).cosh(),
            Self::TransverseMercator { scale, easting } => {
                scale * ((x - easting) / (scale * radius)).cosh()
            }
            Self::PolarStereographic { scale, pole } => {
                let tangent = (x - pole).hypot(y - pole) / (2.0 * scale * radius);
                scale * (1.0 + tangent * tangent)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_those_of_proj() {
        let at = |epsg, origin| {
            let system = Some(CoordinateSystem::Projected(epsg));
            let at = Georeference { origin, down: [0.0, -1.0], right: [1.0, 0.0], system };
            at.map_scale(Chart { rows: 3, cols: 3 }).map(|found| found.range[1])
        };
        // The expected scales along the parallel are those of pyproj's get_factors.
        for (epsg, origin, expected) in [
            (3857, [1e6, 8_399_737.9], Some(2.0)),
            (3857, [1e6, 0.0], None),
            (3395, [1e6, 8_362_698.5], Some(1.9950)),
            (32633, [500_000.0, 5e6], None),
            (32633, [2_000_000.0, 5e6], Some(1.0274)),
            (3031, [0.0, 3_000_000.0], Some(1.0293)),
            (3413, [0.0, -4_000_000.0], Some(1.0707)),
            (2056, [2_600_000.0, 1_200_000.0], None),
        ] {
            let found = at(epsg, origin);
            let agrees = match (found, expected) {
                (Some(found), Some(expected)) => (found / expected - 1.0f64).abs() < 0.01,
                (found, expected) => found == expected,
            };
            assert!(agrees, "EPSG:{epsg}: {found:?}, {expected:?}");
        }
    }
}
