//! Interprets the fields of GeoTIFF (OGC 19-008r4) that give the distance between the points of a raster, and the unit
//! of its heights.

use super::geo_tags::{GeoTags, geo_key};
use crate::file_spacing::{FileSpacing, LinearUnit};
use geosweep_crs::{epsg_units, units};
use geosweep_surface::Spacing;

impl GeoTags {
    /// Returns the distance between pixels, if the file gives it in a unit of length. `unit_of_values` is the
    /// unit of the heights according to GDAL's metadata.
    pub(crate) fn spacing(&self, unit_of_values: Option<&str>) -> FileSpacing {
        let spacing = match self.lengths() {
            Ok(Some(spacing)) => spacing,
            Ok(None) => return FileSpacing::Unknown,
            Err(why) => return FileSpacing::Unusable(why),
        };
        match self.key(geo_key::MODEL_TYPE) {
            Some(geo_key::PROJECTED) => {}
            Some(geo_key::GEOGRAPHIC) => {
                return FileSpacing::Degrees("the file gives its pixel size in degrees");
            }
            _ => {
                return FileSpacing::Degrees(
                    "the file gives its pixel size in degrees, or does not say in what unit",
                );
            }
        }
        match self.unit(unit_of_values) {
            Ok(unit) => FileSpacing::Known(spacing, unit),
            Err(why) => FileSpacing::Unusable(why.into()),
        }
    }

    /// Returns the sides of a pixel, if the file gives them and they are at right angles.
    fn lengths(&self) -> Result<Option<Spacing>, String> {
        let Some((_, [down, right])) = self.linear() else {
            return match self.tie_points() {
                0 | 1 => Ok(None),
                points => Err(Self::control_points(points)),
            };
        };
        let [dx, dy] = [right, down].map(|[east, north]: [f64; 2]| east.hypot(north));
        let usable = |side: f64| side.is_finite() && side > 0.0;
        if !(usable(dx) && usable(dy)) {
            return Err("the file's pixels have no size".into());
        }
        // The rounding errors of a rotated grid stay below this bound.
        if (right[0] * down[0] + right[1] * down[1]).abs() > 1e-6 * dx * dy {
            return Err(
                "the file's rows and columns are not at right angles; gdalwarp makes a plain \
                        grid of it"
                    .into(),
            );
        }
        Ok(Some(Spacing { dx, dy }))
    }

    /// Returns the common unit of pixel sizes and heights, or an error if they differ.
    fn unit(&self, unit_of_values: Option<&str>) -> Result<LinearUnit, &'static str> {
        let across = self.key(geo_key::PROJECTED_LINEAR_UNITS);
        let across =
            across.or_else(|| self.code(geo_key::PROJECTED_SYSTEM).and_then(epsg_units::projected));
        match (across, self.unit_of_heights(unit_of_values)?) {
            (None, units::METRE) => Ok(LinearUnit { name: units::name(units::METRE), said: false }),
            (None, _) => {
                Err("the file gives its heights in a unit other than metres, and does not \
                              say in what unit its pixel size is (key ProjLinearUnits)")
            }
            (Some(across), up) if across == up && across <= geo_key::LARGEST_CODE => {
                Ok(LinearUnit { name: units::name(across), said: true })
            }
            (Some(units::METRE), _) => Err("the file gives its heights in a unit other than its \
                                              pixel size's, which is in metres"),
            _ => Err("the file gives its pixel size in a unit other than metres, and not its \
                      heights in the same"),
        }
    }

    /// Returns the unit of the heights, which are in metres unless the file states otherwise.
    fn unit_of_heights(&self, unit_of_values: Option<&str>) -> Result<u16, &'static str> {
        let unit = match unit_of_values.map(units::of_text) {
            Some(Some(code)) => Some(code),
            Some(None) => {
                return Err(
                    "the file gives its values in a unit (UNITTYPE of GDAL_METADATA) that is \
                            not known",
                );
            }
            None => self
                .key(geo_key::VERTICAL_UNITS)
                .or_else(|| self.code(geo_key::VERTICAL_SYSTEM).and_then(epsg_units::vertical)),
        };
        Ok(unit.unwrap_or(units::METRE))
    }

    /// Returns the length of the unit of the heights, in metres.
    pub(super) fn metres_per_height(&self, unit_of_values: Option<&str>) -> Result<f64, String> {
        let unit = self.unit_of_heights(unit_of_values)?;
        units::metres(unit).ok_or_else(|| {
            format!(
                "the file gives its heights in the unit EPSG:{unit}, which is neither metres nor feet; \
                 gdal_calc.py converts them"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::geo_tags::tests::{UTM, tags};
    use super::*;

    #[test]
    fn heights_are_in_metres_or_feet() {
        let metres = |code: u16| {
            let keys =
                [1, 1, 0, 2, geo_key::MODEL_TYPE, 0, 1, 2, geo_key::VERTICAL_UNITS, 0, 1, code];
            tags(&keys).metres_per_height(None)
        };
        assert_eq!(metres(units::METRE), Ok(1.0));
        assert_eq!(metres(9002), Ok(0.3048));
        assert!(metres(9036).unwrap_err().contains("EPSG:9036"));
        assert!(tags(&UTM).metres_per_height(Some("m")).is_ok());
        assert!(tags(&UTM).metres_per_height(Some("fathom")).is_err());
    }

    #[test]
    fn pixel_sizes_count_where_heights_are_in_the_same_unit() {
        let spacing = |units: &[[u16; 2]]| {
            let entries = units.iter().flat_map(|&[key, unit]| [key, 0, 1, unit]);
            tags(&UTM.into_iter().chain(entries).collect::<Vec<_>>()).spacing(None)
        };
        let known = |name, said| {
            FileSpacing::Known(Spacing { dx: 30.0, dy: 20.0 }, LinearUnit { name, said })
        };
        assert_eq!(spacing(&[]), known(Some("m"), false));
        assert_eq!(spacing(&[[4099, 9001]]), known(Some("m"), false));
        assert_eq!(spacing(&[[3076, 9001]]), known(Some("m"), true));
        assert_eq!(spacing(&[[3076, 9003], [4099, 9003]]), known(Some("US ft"), true));
        assert_eq!(spacing(&[[3076, 9036], [4099, 9036]]), known(None, true));
        for units in [
            &[[3076, 9001], [4099, 9002]][..],
            &[[3076, 9002]],
            &[[3076, 9002], [4099, 9003]],
            &[[4099, 9002]],
            &[[3076, 32767], [4099, 32767]],
        ] {
            let found = spacing(units);
            assert!(matches!(found, FileSpacing::Unusable(_)), "{units:?}: {found:?}");
        }
    }
}
