//! Reads points, lines and polygons from GeoJSON.

use ::geojson::{Feature, GeoJson, Geometry, GeometryValue, JsonObject, JsonValue, Position};

use super::columns::{Named, check_unused, finite, is_start};
use super::content::{Coordinates, CurveKind, FileCurve, FileCurves, Vertex};
use super::frame::MapCoordinates;
use geosweep_surface::shown::excerpt;

/// The unit by which vertices are numbered.
pub(super) const FEATURE: &str = "feature";

/// Reads GeoJSON (RFC 7946), or its version of 2008 with a member `crs`. Heights are not read, since the
/// surface has its own.
pub(super) fn read(text: &str) -> Result<FileCurves, String> {
    let object = text.parse::<GeoJson>().map_err(|error| {
        let error = error.to_string();
        format!("is no GeoJSON that can be read: {}", excerpt(&error))
    })?;
    let mut reader = Reader::default();
    match object {
        GeoJson::Geometry(geometry) => reader.geometry(&geometry, 0.0, 1, DEPTH)?,
        GeoJson::Feature(feature) => reader.feature(&feature, 1)?,
        GeoJson::FeatureCollection(collection) => {
            reader.system(collection.foreign_members.as_ref())?;
            for (index, feature) in collection.features.iter().enumerate() {
                let number = index + 1;
                let named = |reason| format!("{FEATURE} {number}: {reason}");
                reader.feature(feature, number).map_err(named)?;
            }
        }
    }
    let system = reader.system.map_or(MapCoordinates::Unnamed, MapCoordinates::Epsg);
    Ok(FileCurves {
        curves: reader.curves,
        coordinates: Coordinates::Map(system),
        unused: reader.unused,
        has_starts: reader.has_starts,
        numbered: FEATURE,
        empty: reader.empty,
    })
}

/// Returns the reason why a text is not JSON.
pub(super) fn not_json(text: &str) -> String {
    format!(
        "is no GeoJSON, which begins with `{{`; this begins with `{}`",
        excerpt(text.trim_start())
    )
}

/// Maximum depth of nested geometry collections.
const DEPTH: usize = 16;

#[derive(Default)]
struct Reader {
    curves: Vec<FileCurve>,
    unused: Vec<String>,
    has_starts: bool,
    empty: usize,
    /// EPSG number of the coordinate system.
    system: Option<u32>,
}

impl Reader {
    fn feature(&mut self, feature: &Feature, number: usize) -> Result<(), String> {
        self.system(feature.foreign_members.as_ref())?;
        let start = self.start(feature.properties.as_ref())?;
        match &feature.geometry {
            Some(geometry) => self.geometry(geometry, start, number, DEPTH),
            None => {
                self.empty += 1;
                Ok(())
            }
        }
    }

    /// Returns the start value among a feature's properties.
    fn start(&mut self, properties: Option<&JsonObject>) -> Result<f64, String> {
        let mut start = None;
        for (name, value) in properties.into_iter().flatten() {
            if !is_start(name) {
                if !self.unused.contains(name) {
                    check_unused(name, "property")?;
                    self.unused.push(name.clone());
                }
                continue;
            }
            let (text, property) = (value.to_string(), Named("property", name));
            let number = match value {
                JsonValue::Number(number) => number.as_f64(),
                JsonValue::String(text) => text.trim().parse().ok(),
                _ => None,
            };
            let number =
                number.ok_or_else(|| format!("`{}` {property} is not a number", excerpt(&text)))?;
            let number = finite(number, &text, &property)?;
            if start.replace(number).is_some() {
                return Err(format!(
                    "the property {} is a second start value; leave one of them out",
                    excerpt(name)
                ));
            }
        }
        self.has_starts |= start.is_some();
        Ok(start.unwrap_or(0.0))
    }

    fn geometry(
        &mut self,
        geometry: &Geometry,
        start: f64,
        number: usize,
        depth: usize,
    ) -> Result<(), String> {
        self.system(geometry.foreign_members.as_ref())?;
        let mut add = |positions: &[Position], kind: CurveKind| {
            let vertex = |position: &Position| match position.as_slice() {
                &[x, y, ..] => Ok(Vertex { place: [x, y], start, number, value: None }),
                _ => Err("a position needs two numbers".to_string()),
            };
            let mut vertices: Vec<_> = positions.iter().map(vertex).collect::<Result<_, _>>()?;
            if kind.is_ring() && vertices.len() > 1 && vertices[0] == vertices[vertices.len() - 1] {
                vertices.pop();
            }
            if !vertices.is_empty() {
                self.curves.push(FileCurve { vertices, kind });
            }
            Ok::<_, String>(())
        };
        match &geometry.value {
            GeometryValue::Point { coordinates } => {
                add(std::slice::from_ref(coordinates), CurveKind::Points)
            }
            GeometryValue::MultiPoint { coordinates } => add(coordinates, CurveKind::Points),
            GeometryValue::LineString { coordinates } => add(coordinates, CurveKind::Line),
            GeometryValue::MultiLineString { coordinates } => {
                coordinates.iter().try_for_each(|line| add(line, CurveKind::Line))
            }
            GeometryValue::Polygon { coordinates } => {
                rings(coordinates).try_for_each(|(ring, kind)| add(ring, kind))
            }
            GeometryValue::MultiPolygon { coordinates } => coordinates
                .iter()
                .flat_map(|polygon| rings(polygon))
                .try_for_each(|(ring, kind)| add(ring, kind)),
            GeometryValue::GeometryCollection { geometries } => {
                let depth =
                    depth.checked_sub(1).ok_or("geometry collections are nested too deeply")?;
                geometries
                    .iter()
                    .try_for_each(|geometry| self.geometry(geometry, start, number, depth))
            }
        }
    }

    /// Reads the coordinate system of a member `crs`, which must be the same in the whole file.
    fn system(&mut self, members: Option<&JsonObject>) -> Result<(), String> {
        let Some(crs) = members.and_then(|members| members.get("crs")) else { return Ok(()) };
        if crs.is_null() {
            return Ok(());
        }
        let epsg = epsg(crs).ok_or_else(|| {
            let text = crs.to_string();
            format!("its member crs names no EPSG code: `{}`", excerpt(&text))
        })?;
        match self.system.replace(epsg) {
            Some(other) if other != epsg => {
                Err(format!("it names two coordinate systems, EPSG:{other} and EPSG:{epsg}"))
            }
            _ => Ok(()),
        }
    }
}

/// Returns the rings of a polygon. The first is the outer one.
fn rings<T>(polygon: &[T]) -> impl Iterator<Item = (&T, CurveKind)> {
    let kinds = std::iter::once(CurveKind::Ring).chain(std::iter::repeat(CurveKind::Hole));
    polygon.iter().zip(kinds)
}

/// Returns the EPSG number of a member `crs`, which OGC writes in several ways.
fn epsg(crs: &JsonValue) -> Option<u32> {
    let name = crs.get("properties")?.get("name")?.as_str()?;
    let upper = name.trim().to_ascii_uppercase();
    let mut parts = upper.rsplit([':', '/', '#']);
    let code = parts.next()?;
    match code {
        // Longitude and latitude on WGS 84, in the order that GeoJSON uses anyway.
        "CRS84" => Some(4326),
        _ if parts.any(|part| part == "EPSG" || part == "EPSG.XML") => code.parse().ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn geometry(kind: &str, coordinates: &str) -> String {
        format!(r#"{{"type":"{kind}","coordinates":{coordinates}}}"#)
    }

    fn feature(geometry: &str, properties: &str) -> String {
        format!(r#"{{"type":"Feature","properties":{properties},"geometry":{geometry}}}"#)
    }

    fn collection(features: &[String], more: &str) -> String {
        let features = features.join(",");
        format!(r#"{{"type":"FeatureCollection"{more},"features":[{features}]}}"#)
    }

    fn crs(name: &str) -> String {
        format!(r#","crs":{{"type":"name","properties":{{"name":"{name}"}}}}"#)
    }

    fn places(file: &FileCurves) -> Vec<(CurveKind, Vec<[f64; 2]>)> {
        let curve = |curve: &FileCurve| {
            (curve.kind, curve.vertices.iter().map(|vertex| vertex.place).collect())
        };
        file.curves.iter().map(curve).collect()
    }

    #[test]
    fn every_kind_of_geometry_is_read() {
        use CurveKind::{Hole, Line, Points, Ring};
        let (a, b, c) = ([1.0, 2.0], [3.0, 4.5], [-5.0, 6.0]);
        for (kind, coordinates, expected) in [
            ("Point", "[1,2,99]", vec![(Points, vec![a])]),
            ("MultiPoint", "[[1,2],[3,4.5]]", vec![(Points, vec![a, b])]),
            ("LineString", "[[1,2],[3,4.5,7]]", vec![(Line, vec![a, b])]),
            (
                "MultiLineString",
                "[[[1,2],[3,4.5]],[[-5,6],[1,2]]]",
                vec![(Line, vec![a, b]), (Line, vec![c, a])],
            ),
            ("Polygon", "[[[1,2],[3,4.5],[-5,6],[1,2]]]", vec![(Ring, vec![a, b, c])]),
            (
                "Polygon",
                "[[[1,2],[3,4.5],[-5,6],[1,2]],[[1,2],[3,4.5],[-5,6],[1,2]]]",
                vec![(Ring, vec![a, b, c]), (Hole, vec![a, b, c])],
            ),
            (
                "MultiPolygon",
                "[[[[1,2],[3,4.5],[-5,6],[1,2]]],[[[1,2],[3,4.5],[-5,6],[1,2]]]]",
                vec![(Ring, vec![a, b, c]); 2],
            ),
        ] {
            let bare = geometry(kind, coordinates);
            let of_feature = feature(&bare, "null");
            let deep = format!(r#"{{"type":"GeometryCollection","geometries":[{bare}]}}"#);
            for text in [bare.clone(), of_feature.clone(), collection(&[of_feature], ""), deep] {
                let file = read(&text).unwrap();
                assert_eq!(places(&file), expected, "{text}");
                assert_eq!(file.coordinates, Coordinates::Map(MapCoordinates::Unnamed));
            }
        }
    }

    #[test]
    fn start_values_are_properties() {
        let point = geometry("Point", "[1,2]");
        let starts = |properties: [&str; 2]| {
            let features = properties.map(|properties| feature(&point, properties));
            let file = read(&collection(&features, ""))?;
            let starts =
                file.curves.iter().map(|curve| curve.vertices[0].start).collect::<Vec<_>>();
            Ok::<_, String>((starts, file.unused))
        };
        let found = starts([r#"{"name":"a","T0":1.5}"#, r#"{"name":"b"}"#]);
        assert_eq!(found, Ok((vec![1.5, 0.0], vec!["name".into()])));
        assert_eq!(starts([r#"{"start":"7"}"#, "null"]).unwrap().0, [7.0, 0.0]);
        for (properties, part) in [
            (r#"{"t0":null}"#, "null"),
            (r#"{"time":"2024-01-01T00:00:00Z"}"#, "2024-01-01"),
            (r#"{"t0":1,"start":2}"#, "second start value"),
            (r#"{"weight":1}"#, "weight"),
        ] {
            let reason = starts(["{}", properties]).unwrap_err();
            assert!(reason.contains(part) && reason.contains("feature 2"), "{reason}");
        }
    }

    #[test]
    fn coordinate_systems_are_named_in_several_ways() {
        let features = [feature(&geometry("Point", "[1,2]"), "{}")];
        for (name, expected) in [
            ("urn:ogc:def:crs:EPSG::32616", 32616),
            ("urn:ogc:def:crs:EPSG:9.8:32616", 32616),
            ("EPSG:3857", 3857),
            ("http://www.opengis.net/def/crs/EPSG/0/2056", 2056),
            ("http://www.opengis.net/gml/srs/epsg.xml#4326", 4326),
            ("urn:ogc:def:crs:OGC:1.3:CRS84", 4326),
        ] {
            let file = read(&collection(&features, &crs(name))).unwrap();
            assert_eq!(
                file.coordinates,
                Coordinates::Map(MapCoordinates::Epsg(expected)),
                "{name}"
            );
        }
        for name in ["urn:ogc:def:crs:IGNF::LAMB93", "local"] {
            let reason = read(&collection(&features, &crs(name))).unwrap_err();
            assert!(reason.contains(name), "{reason}");
        }
        assert!(read(&collection(&features, r#","crs":{"type":"link"}"#)).is_err());
        assert!(read(&collection(&features, r#","crs":null"#)).is_ok());
    }

    #[test]
    fn other_texts_are_refused() {
        for text in ["{", "{}", "[[1,2],[3,4]]", r#"{"type":"Topology"}"#, r#"{"type":"Point"}"#] {
            read(text).unwrap_err();
        }
        let empty = read(&collection(&[feature("null", "{}")], "")).unwrap();
        assert_eq!((empty.curves.len(), empty.empty), (0, 1));
    }
}
