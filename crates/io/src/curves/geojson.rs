//! Writes curves on the Earth as GeoJSON.

use std::io::{self, Write};

use ::geojson::{
    Feature, FeatureCollection, Geometry, GeometryValue, JsonObject, JsonValue, Position,
};
use glam::DVec3;

use super::antimeridian::{Place, divided, is_same};
use super::drawing::{Attribute, Drawing, Polyline};
use crate::CoordinateSystem;

/// Number of digits after the decimal point of a number in degrees. The last one is a tenth of a millimetre.
const DEGREE_DIGITS: i32 = 9;
const METRE_DIGITS: i32 = 4;

/// Writes a LineString per curve, or a Point for a curve of one vertex, or a MultiLineString for a curve over the
/// antimeridian.
pub fn write(writer: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
    let georeference = drawing.georeference.as_ref();
    let georeference = georeference.ok_or_else(|| io::Error::other("there is no georeference"))?;
    let system = georeference.system;
    let system = system.ok_or_else(|| io::Error::other("the coordinate system has no name"))?;
    let feature = |line| {
        let place = |(vertex, at): ([f64; 2], DVec3)| {
            let [east, north] = georeference.coordinates(vertex);
            [east, north, if drawing.has_heights { at.z } else { f64::NAN }]
        };
        feature(line, line.around().map(place).collect(), system)
    };
    let collection = FeatureCollection {
        bbox: None,
        features: drawing.polylines.iter().map(feature).collect(),
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

fn feature(polyline: &Polyline, places: Vec<Place>, system: CoordinateSystem) -> Feature {
    let (digits, mut parts) = match system {
        CoordinateSystem::Geographic(_) => (DEGREE_DIGITS, divided(&places)),
        CoordinateSystem::Projected(_) => (METRE_DIGITS, vec![places]),
    };
    if polyline.curve.closed && parts.len() > 1 {
        // The ring's first vertex does not end a part, so the first part continues the last one.
        let first = parts.remove(0);
        let joins = |last: &&mut Vec<Place>| last.last().is_some_and(|end| is_same(end, &first[0]));
        match parts.last_mut().filter(joins) {
            Some(last) => last.extend_from_slice(&first[1..]),
            None => parts.insert(0, first),
        }
    }
    let position = |[east, north, height]: Place| {
        let [east, north] = [east, north].map(|degrees| rounded(degrees, digits));
        match height.is_nan() {
            true => Position::from([east, north]),
            false => Position::from([east, north, rounded(height, METRE_DIGITS)]),
        }
    };
    let line = |part: Vec<Place>| part.into_iter().map(position).collect::<Vec<_>>();
    let mut lines: Vec<_> = parts.into_iter().map(line).collect();
    let value = match &mut lines[..] {
        [line] if line.len() == 1 => GeometryValue::Point { coordinates: line.remove(0) },
        [line] => GeometryValue::LineString { coordinates: std::mem::take(line) },
        _ => GeometryValue::MultiLineString { coordinates: lines },
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
