//! Tells the units of a coordinate reference system.

use crate::ellipsoids;
use crate::projection_file::{Projection, ProjectionFile};
use crate::{epsg_units, units};

/// The units of a coordinate reference system, as far as its description tells them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SystemUnits {
    /// Whether the coordinates are angles: longitudes and latitudes.
    pub are_angles: bool,
    /// The unit of map coordinates in metres.
    pub length: Option<f64>,
    /// The unit of heights in metres.
    pub height: Option<f64>,
}

impl SystemUnits {
    /// Interprets well-known text, a number of the EPSG register (`EPSG:32633`) or the name of a geographic system
    /// (`OGC:CRS84`, `+proj=longlat`). Returns `None` for other texts.
    ///
    /// ```
    /// use geosweep_crs::SystemUnits;
    ///
    /// assert!(SystemUnits::parse("EPSG:4326").is_some_and(|units| units.are_angles));
    /// assert_eq!(SystemUnits::parse("EPSG:2263").and_then(|units| units.length), Some(1200.0 / 3937.0));
    /// ```
    pub fn parse(text: &str) -> Option<Self> {
        let angles = Self { are_angles: true, length: None, height: None };
        if text.contains('[') {
            let ProjectionFile { projection, height_unit } = ProjectionFile::parse(text);
            return Some(match projection {
                Projection::Degrees(_) => Self { height: height_unit, ..angles },
                Projection::Map(length) => Self { are_angles: false, length, height: height_unit },
            });
        }
        let upper = text.trim().to_ascii_uppercase();
        let is_named =
            ["CRS84", "CRS:84", "CRS83", "CRS27"].iter().any(|name| upper.ends_with(name));
        if is_named || upper.contains("PROJ=LONGLAT") || upper.contains("PROJ=LATLONG") {
            return Some(angles);
        }
        // Also of the form urn:ogc:def:crs:EPSG::4326.
        let (before, code) = upper.rsplit_once(':')?;
        let code = code.parse().ok().filter(|_| before.contains("EPSG"))?;
        match ellipsoids::of_system(code) {
            Ok(None) => Some(Self {
                are_angles: false,
                length: epsg_units::projected(code).map_or(Some(1.0), units::metres),
                height: None,
            }),
            Ok(Some(_)) | Err(_) => Some(angles),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_named_in_many_ways() {
        for text in [
            "EPSG:4326",
            "epsg:4258",
            "urn:ogc:def:crs:EPSG::4326",
            "urn:ogc:def:crs:OGC:1.3:CRS84",
            "EPSG:4807",
            "+proj=longlat +datum=WGS84 +no_defs",
            "+init=epsg:4326",
        ] {
            assert!(SystemUnits::parse(text).is_some_and(|units| units.are_angles), "{text}");
        }
        let length = |text| SystemUnits::parse(text).map(|units| (units.are_angles, units.length));
        assert_eq!(length("EPSG:32633"), Some((false, Some(1.0))));
        assert_eq!(length("EPSG:2263"), Some((false, Some(1200.0 / 3937.0))));
        let wkt =
            r#"PROJCS["A",GEOGCS["B",UNIT["degree",0.0174532925199433]],UNIT["foot",0.3048]]"#;
        assert_eq!(length(wkt), Some((false, Some(0.3048))));
        for text in ["", "x", "32633", "+proj=utm +zone=33", "EPSG:x"] {
            assert_eq!(length(text), None, "{text}");
        }
    }
}
