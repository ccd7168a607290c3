//! Interprets `.prj` files: well-known text, or ARC/INFO's lines of a keyword and a value.

use std::f64::consts::PI;

use crate::c_number::c_number;
use crate::ellipsoids::not_degrees;
use geosweep_surface::Ellipsoid;

/// The coordinates that a `.prj` file describes.
#[derive(Clone, Debug, PartialEq)]
pub enum Projection {
    /// Longitudes and latitudes, and their ellipsoid. The error is for angles in another unit than degrees.
    Degrees(Result<Option<Ellipsoid>, String>),
    /// Coordinates on a map, with the length of their unit in metres, if it is known.
    Map(Option<f64>),
}

/// The content of a `.prj` file.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectionFile {
    /// The coordinates.
    pub projection: Projection,
    /// The length of the unit of heights in metres, if the file names it.
    pub height_unit: Option<f64>,
}

/// Lengths of feet in metres.
const FOOT: f64 = 0.3048;
const US_FOOT: f64 = 1200.0 / 3937.0;
/// Relative difference by which a factor in a file may be rounded.
const ROUNDED: f64 = 1e-6;

impl ProjectionFile {
    /// Interprets the text of a file.
    pub fn parse(text: &str) -> Self {
        let upper = text.to_ascii_uppercase();
        match upper.contains('[') {
            true => of_wkt(&upper),
            false => of_lines(&upper),
        }
    }
}

/// Interprets well-known text in capitals.
fn of_wkt(text: &str) -> ProjectionFile {
    // The target of a transformation and the system of heights follow the system of the coordinates.
    let text = text.split("TARGETCRS[").next().unwrap_or_default();
    let vertical = ["VERT_CS[", "VERTCS[", "VERTCRS[", "VERTICALCRS["];
    let end = vertical.into_iter().filter_map(|key| text.find(key)).min().unwrap_or(text.len());
    let (across, up) = text.split_at(end);
    ProjectionFile { projection: of_system(across), height_unit: unit_of(up) }
}

/// Returns the factor of the unit of a system. The text may name several units. The last one is that of the coordinates.
fn unit_of(text: &str) -> Option<f64> {
    let (_, unit) = text.rsplit_once("UNIT[")?;
    unit.split(']').next()?.split(',').nth(1)?.trim().parse().ok()
}

/// Interprets the well-known text of one system in two dimensions.
fn of_system(text: &str) -> Projection {
    let factor = unit_of(text);
    // The last ones are systems of a site, which GDAL writes for rasters that name a unit alone, and of the whole Earth.
    let maps = ["PROJC", "PROJECTEDCRS", "LOCAL_CS[", "ENGCRS[", "ENGINEERINGCRS[", "GEOCCS["];
    if maps.into_iter().any(|key| text.contains(key)) {
        return Projection::Map(factor);
    }
    let figure = ["SPHEROID[", "ELLIPSOID["].into_iter().find_map(|key| text.split(key).nth(1));
    let mut numbers = figure.into_iter().flat_map(|figure| figure.split([',', ']', '[']).skip(1));
    let mut number = || numbers.next().and_then(|number| number.trim().parse::<f64>().ok());
    let ellipsoid =
        number().zip(number()).and_then(|(radius, inverse)| Ellipsoid::new(radius, inverse));
    Projection::Degrees(match factor {
        Some(factor) if (factor * 180.0 / PI - 1.0).abs() > 1e-3 => {
            Err(not_degrees(&format!("a unit of {factor} radians")))
        }
        _ => Ok(ellipsoid),
    })
}

/// Interprets lines of a keyword and a value, in capitals, as ARC/INFO writes them.
fn of_lines(text: &str) -> ProjectionFile {
    let value = |key: &str| {
        let lines = text.lines().map(|line| line.trim().split_once(char::is_whitespace));
        lines.flatten().find(|(found, _)| *found == key).map(|(_, value)| value.trim())
    };
    let length = |unit: &str| match unit {
        "METERS" | "METRES" | "METER" | "METRE" => Some(1.0),
        "FEET" | "FOOT" | "US_FEET" => Some(US_FOOT),
        "INT_FEET" | "INTERNATIONAL_FEET" => Some(FOOT),
        // Units are also given by their number in a metre.
        other => c_number(other).filter(|number| *number > 0.0).map(f64::recip),
    };
    let units = value("UNITS");
    let is_geographic = value("PROJECTION").is_none_or(|name| name.starts_with("GEOGRAPHIC"));
    let projection = match is_geographic {
        false => Projection::Map(units.and_then(length)),
        true => Projection::Degrees(match units {
            None | Some("DD" | "DECIMALDEGREES" | "DEGREES") => ellipsoid_of(value("SPHEROID")),
            Some(other) => Err(not_degrees(other)),
        }),
    };
    // NO means that values are no heights, or that their unit is not known.
    let height_unit = value("ZUNITS").filter(|unit| *unit != "NO").and_then(length);
    ProjectionFile { projection, height_unit }
}

/// Returns a spheroid by ARC/INFO's name of it.
fn ellipsoid_of(name: Option<&str>) -> Result<Option<Ellipsoid>, String> {
    let Some(name) = name else { return Ok(None) };
    let (radius, inverse) = match name {
        "WGS84" => return Ok(Some(Ellipsoid::WGS_84)),
        "GRS80" | "GRS1980" => (6_378_137.0, 298.257_222_101),
        "CLARKE1866" => (6_378_206.4, 294.978_698_2),
        "INT1909" | "INTERNATIONAL" | "INTERNATIONAL1909" => (6_378_388.0, 297.0),
        "BESSEL" => (6_377_397.155, 299.152_812_8),
        "AIRY" => (6_377_563.396, 299.324_964_6),
        "KRASOVSKY" | "KRASOVSKI" => (6_378_245.0, 298.3),
        "WGS72" => (6_378_135.0, 298.26),
        other => {
            return Err(format!(
                "the .prj beside it names the spheroid {other}, which is not known here; gdalwarp -t_srs EPSG:4326 \
                 makes a grid on WGS 84"
            ));
        }
    };
    Ok(Ellipsoid::new(radius, inverse))
}

impl Projection {
    /// Returns whether the coordinates are on a map, in metres.
    pub fn is_in_metres(&self) -> bool {
        self.is_in(1.0)
    }

    /// Returns whether the coordinates are on a map, in a unit of `length` metres.
    pub fn is_in(&self, length: f64) -> bool {
        matches!(self, Self::Map(Some(unit)) if (unit / length - 1.0).abs() <= ROUNDED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_and_new_texts_are_read() {
        let old = |units: &str, more: &str| {
            format!(
                "Projection    UTM\nZone   33\nDatum  WGS84\nUnits   {units}\n{more}Parameters\n"
            )
        };
        let metres = ProjectionFile::parse(&old("METERS", "Zunits NO\r\n"));
        assert!(metres.projection.is_in_metres() && metres.height_unit.is_none());
        let feet = ProjectionFile::parse(&old("FEET", "Zunits METERS\n"));
        assert_eq!(feet.projection, Projection::Map(Some(US_FOOT)));
        assert_eq!(feet.height_unit, Some(1.0));
        assert_eq!(
            ProjectionFile::parse(&old("3.2808", "")).projection,
            Projection::Map(Some(1.0 / 3.2808))
        );

        let degrees =
            "Projection GEOGRAPHIC\nDatum NAD27\nSpheroid CLARKE1866\nUnits DD\nParameters\n";
        let Projection::Degrees(Ok(Some(clarke))) = ProjectionFile::parse(degrees).projection
        else {
            panic!("degrees")
        };
        assert_eq!(clarke.equator, 6_378_206.4);
        let odd = ProjectionFile::parse(&degrees.replace("CLARKE1866", "EVEREST")).projection;
        assert!(matches!(odd, Projection::Degrees(Err(why)) if why.contains("EVEREST")));

        let moon = r#"GEOGCS["Moon",DATUM["D",SPHEROID["Moon_2000",1737400.0,0.0]],UNIT["Degree",0.0174532925199433]]"#;
        let Projection::Degrees(Ok(Some(sphere))) = ProjectionFile::parse(moon).projection else {
            panic!("Moon")
        };
        assert_eq!([sphere.equator, sphere.flattening], [1_737_400.0, 0.0]);
        assert_eq!(ProjectionFile::parse(moon).height_unit, None);
        let wkt2 = r#"GEOGCRS["x",DATUM["d",ELLIPSOID["e",6378137,298.257223563,LENGTHUNIT["metre",1]]],ANGLEUNIT["grad",0.015707963]]"#;
        assert!(matches!(ProjectionFile::parse(wkt2).projection, Projection::Degrees(Err(_))));
    }

    #[test]
    fn units_of_heights_are_not_those_of_the_map() {
        const GEOGRAPHIC: &str = r#"GEOGCS["WGS 84",DATUM["D",SPHEROID["WGS 84",6378137,298.257223563]],UNIT["degree",0.0174532925199433]]"#;
        let feet = format!(r#"PROJCS["A",{GEOGRAPHIC},UNIT["US survey foot",0.304800609601219]]"#);
        let metres = r#"VERT_CS["EGM96",VERT_DATUM["E",2005],UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Up",UP]]"#;
        let up =
            r#"VERTCRS["H",VDATUM["V"],CS[vertical,1],AXIS["up",up],LENGTHUNIT["foot",0.3048]]"#;
        let map = Projection::Map(Some(0.304_800_609_601_219));
        for (text, projection, height_unit) in [
            (feet.clone(), map.clone(), None),
            (format!(r#"COMPD_CS["C",{feet},{metres}]"#), map.clone(), Some(1.0)),
            (format!("{feet},{}", metres.replace("VERT_CS", "VERTCS")), map.clone(), Some(1.0)),
            (format!(r#"COMPOUNDCRS["C",{feet},{up}]"#), map.clone(), Some(0.3048)),
            (
                format!(
                    r#"BOUNDCRS[SOURCECRS[{feet}],TARGETCRS[{GEOGRAPHIC}],PARAMETER["X",1,LENGTHUNIT["metre",1]]]"#
                ),
                map,
                None,
            ),
            (
                format!(r#"COMPD_CS["C",{GEOGRAPHIC},{metres}]"#),
                Projection::Degrees(Ok(Some(Ellipsoid::WGS_84))),
                Some(1.0),
            ),
            (r#"LOCAL_CS["site",UNIT["metre",1]]"#.into(), Projection::Map(Some(1.0)), None),
        ] {
            assert_eq!(
                ProjectionFile::parse(&text),
                ProjectionFile { projection, height_unit },
                "{text}"
            );
        }
    }
}
