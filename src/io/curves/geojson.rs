//! Writes curves on the Earth as GeoJSON.

use std::io::{self, Write};

use ::geojson::{
    Feature, FeatureCollection, Geometry, GeometryValue, JsonObject, JsonValue, Position,
};
use glam::DVec3;

use super::drawing::{Attribute, Drawing, Polyline};
use crate::io::{CoordinateSystem, Georeference};

/// Number of digits after the decimal point: a tenth of a millimetre.
const DEGREE_DIGITS: i32 = 9;
const METRE_DIGITS: i32 = 4;

/// Writes a LineString per curve, or a Point for a curve of one vertex.
pub fn write(writer: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
    let georeference = drawing.georeference.as_ref();
    let georeference = georeference.ok_or_else(|| io::Error::other("there is no georeference"))?;
    let system = georeference.system;
    let system = system.ok_or_else(|| io::Error::other("the coordinate system has no name"))?;
    let collection = FeatureCollection {
        bbox: None,
        features: drawing.polylines.iter().map(|line| feature(line, georeference)).collect(),
        foreign_members: named(system),
    };
    writeln!(writer, "{collection}")
}

/// Returns the member of GeoJSON 2008 that names a coordinate system. RFC 7946 supports only WGS 84.
fn named(system: CoordinateSystem) -> Option<JsonObject> {
    let name = format!("urn:ogc:def:crs:EPSG::{}", system.epsg());
    let properties = object([("name", name.into())]);
    let crs = object([("type", "name".into()), ("properties", properties.into())]);
    (system != CoordinateSystem::WGS_84).then(|| object([("crs", crs.into())]))
}

fn object<const N: usize>(members: [(&str, JsonValue); N]) -> JsonObject {
    members.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn feature(polyline: &Polyline, georeference: &Georeference) -> Feature {
    let digits = match georeference.system {
        Some(CoordinateSystem::Geographic(_)) => DEGREE_DIGITS,
        _ => METRE_DIGITS,
    };
    let place = |(vertex, at): ([f64; 2], DVec3)| {
        let [east, north] = georeference.coordinates(vertex).map(|c| rounded(c, digits));
        match at.z.is_nan() {
            true => Position::from([east, north]),
            false => Position::from([east, north, rounded(at.z, METRE_DIGITS)]),
        }
    };
    let mut coordinates: Vec<_> = polyline.around().map(place).collect();
    let value = match coordinates.len() {
        1 => GeometryValue::Point { coordinates: coordinates.remove(0) },
        _ => GeometryValue::LineString { coordinates },
    };
    let kind = ("kind".to_owned(), polyline.kind.into());
    let attribute = |(name, value): &(&str, Attribute)| {
        let value = match *value {
            Attribute::Number(number) => number.into(),
            Attribute::Index(index) => index.into(),
            Attribute::Name(name) => name.into(),
        };
        ((*name).to_owned(), value)
    };
    Feature {
        bbox: None,
        geometry: Some(Geometry::new(value)),
        id: None,
        properties: Some(
            std::iter::once(kind).chain(polyline.attributes.iter().map(attribute)).collect(),
        ),
        foreign_members: None,
    }
}

fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10f64.powi(digits);
    (value * scale).round() / scale
}
