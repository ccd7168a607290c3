//! Interprets and writes the fields of GeoTIFF (OGC 19-008r4) that locate the points of a raster.

use std::borrow::Cow;
use std::io::{Seek, Write};

use ::tiff::TiffResult;
use ::tiff::encoder::{DirectoryEncoder, TiffKind, TiffValue};
use ::tiff::tags::{Tag, Type};

use super::directory::Directory;
use super::{Beside, Location};
use crate::{CoordinateSystem, Georeference};
use geosweep_crs::ellipsoids::{self, not_degrees};
use geosweep_surface::Ellipsoid;

/// Keys of the GeoKeyDirectory, and some of their values.
pub(super) mod geo_key {
    pub const MODEL_TYPE: u16 = 1024;
    pub const PROJECTED: u16 = 1;
    pub const GEOGRAPHIC: u16 = 2;
    pub const RASTER_TYPE: u16 = 1025;
    pub const PIXEL_IS_AREA: u16 = 1;
    pub const PIXEL_IS_POINT: u16 = 2;
    pub const GEOGRAPHIC_SYSTEM: u16 = 2048;
    pub const ANGULAR_UNITS: u16 = 2054;
    pub const DEGREE: u16 = 9102;
    pub const SEMI_MAJOR_AXIS: u16 = 2057;
    pub const SEMI_MINOR_AXIS: u16 = 2058;
    pub const INVERSE_FLATTENING: u16 = 2059;
    pub const DOUBLES: u16 = 34736;
    pub const PROJECTED_SYSTEM: u16 = 3072;
    pub const PROJECTED_LINEAR_UNITS: u16 = 3076;
    pub const VERTICAL_SYSTEM: u16 = 4096;
    pub const VERTICAL_UNITS: u16 = 4099;
    pub const WGS_84_WITH_HEIGHTS: u16 = 4979;
    /// Upper limit of EPSG codes. Larger values stand for "undefined" and "user-defined".
    pub const LARGEST_CODE: u16 = 32766;
}

/// The fields of a GeoTIFF that give the location of its pixels: transformation, tie points and keys of the coordinate
/// reference system. The fields of the surface's file are written to maps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeoTags {
    pixel_scale: Option<Vec<f64>>,
    tie_points: Option<Vec<f64>>,
    transformation: Option<Vec<f64>>,
    keys: Vec<u16>,
    doubles: Option<Vec<f64>>,
    text: Option<Vec<u8>>,
}

/// Coordinates eastwards and northwards, or their change.
pub(super) type Pair = [f64; 2];

impl GeoTags {
    pub(super) fn read(directory: &Directory) -> Result<Self, String> {
        let keys = directory.integers(Tag::GeoKeyDirectoryTag)?.unwrap_or_default();
        Ok(Self {
            pixel_scale: directory.reals(Tag::ModelPixelScaleTag)?,
            tie_points: directory.reals(Tag::ModelTiepointTag)?,
            transformation: directory.reals(Tag::ModelTransformationTag)?,
            keys: keys.into_iter().map(|key| key as u16).collect(),
            doubles: directory.reals(Tag::GeoDoubleParamsTag)?,
            text: directory.bytes(Tag::GeoAsciiParamsTag)?.map(<[u8]>::to_vec),
        })
    }

    /// Returns the fields for rasters whose pixels lie where a georeference puts them, in its coordinate reference
    /// system if it names one.
    pub fn new(georeference: &Georeference) -> Self {
        let system = match georeference.system {
            Some(CoordinateSystem::Geographic(epsg)) => {
                [[geo_key::MODEL_TYPE, geo_key::GEOGRAPHIC], [geo_key::GEOGRAPHIC_SYSTEM, epsg]]
            }
            Some(CoordinateSystem::Projected(epsg)) => {
                [[geo_key::MODEL_TYPE, geo_key::PROJECTED], [geo_key::PROJECTED_SYSTEM, epsg]]
            }
            None => return Self::of_transform(georeference),
        };
        let [[model, kind], [key, epsg]] = system;
        let keys = [
            [1, 1, 0, 3],
            [model, 0, 1, kind],
            [geo_key::RASTER_TYPE, 0, 1, geo_key::PIXEL_IS_AREA],
            [key, 0, 1, epsg],
        ];
        Self { keys: keys.as_flattened().to_vec(), ..Self::of_transform(georeference) }
    }

    /// Returns the fields for a transformation alone, without a coordinate reference system.
    fn of_transform(georeference: &Georeference) -> Self {
        let &Georeference { origin, down, right, .. } = georeference;
        // In the fields, row 0 and column 0 lie at the first pixel's corner.
        let corner = [0, 1].map(|k| origin[k] - 0.5 * (down[k] + right[k]));
        if right[1] == 0.0 && down[0] == 0.0 && right[0] > 0.0 && down[1] < 0.0 {
            return Self {
                pixel_scale: Some(vec![right[0], -down[1], 0.0]),
                tie_points: Some(vec![0.0, 0.0, 0.0, corner[0], corner[1], 0.0]),
                ..Self::default()
            };
        }
        let mut matrix = vec![0.0; 16];
        matrix[..2].copy_from_slice(&[right[0], down[0]]);
        matrix[4..6].copy_from_slice(&[right[1], down[1]]);
        (matrix[3], matrix[7], matrix[15]) = (corner[0], corner[1], 1.0);
        Self { transformation: Some(matrix), ..Self::default() }
    }

    /// Returns the fields with the place and the system that the files beside a raster give.
    pub(crate) fn replaced_by(self, beside: &Beside) -> Self {
        let auxiliary = &beside.auxiliary;
        let place = auxiliary.transform.or(beside.world.filter(|_| !self.is_placed()));
        let moved = match place {
            Some(place) => self.moved_to(&place),
            None => self,
        };
        match auxiliary.system {
            Some(system) => moved.in_system(system),
            None => moved,
        }
    }

    /// Returns the location of the points. `unit_of_values` is the unit of the heights according to GDAL's metadata.
    pub(crate) fn location(self, unit_of_values: Option<&str>) -> Location {
        Location {
            georeference: self.georeference(),
            ellipsoid: self.ellipsoid(),
            metres: self.metres_per_height(unit_of_values),
            geo_tags: Some(self),
        }
    }

    /// Returns whether the fields place the pixels.
    pub(crate) fn is_placed(&self) -> bool {
        self.linear().is_some() || self.tie_points.as_ref().is_some_and(|points| points.len() > 6)
    }

    /// Returns the number of tie points.
    pub(super) fn tie_points(&self) -> usize {
        self.tie_points.as_ref().map_or(0, Vec::len) / 6
    }

    /// Returns what is wrong with pixels that lie at control points.
    pub(super) fn control_points(points: usize) -> String {
        format!(
            "the file places its pixels by {points} ground control points, not by a pixel size; \
             gdalwarp makes a plain grid of it"
        )
    }

    /// Returns the fields with another transformation.
    fn moved_to(self, place: &Georeference) -> Self {
        let Self { mut keys, doubles, text, .. } = self;
        // The corners of pixels are given, whatever the pixels stand for.
        for entry in keys.as_chunks_mut::<4>().0.iter_mut().skip(1) {
            if entry[0] == geo_key::RASTER_TYPE {
                entry[3] = geo_key::PIXEL_IS_AREA;
            }
        }
        Self { keys, doubles, text, ..Self::of_transform(place) }
    }

    /// Returns the fields with the keys of another coordinate reference system.
    fn in_system(self, system: CoordinateSystem) -> Self {
        let place = Georeference {
            origin: [0.0; 2],
            down: [0.0, -1.0],
            right: [1.0, 0.0],
            system: Some(system),
        };
        let point = self.key(geo_key::RASTER_TYPE) == Some(geo_key::PIXEL_IS_POINT);
        let mut keys = Self::new(&place).keys;
        for entry in keys.as_chunks_mut::<4>().0.iter_mut().skip(1) {
            if entry[0] == geo_key::RASTER_TYPE && point {
                entry[3] = geo_key::PIXEL_IS_POINT;
            }
        }
        Self { keys, doubles: None, text: None, ..self }
    }

    /// Returns whether the map coordinates are easting and northing.
    pub(crate) fn is_projected(&self) -> bool {
        self.key(geo_key::MODEL_TYPE) == Some(geo_key::PROJECTED)
    }

    pub(super) fn key(&self, wanted: u16) -> Option<u16> {
        // Entries are (key, location, count, value). Location 0 means that the entry holds the value itself.
        let (entries, _) = self.keys.as_chunks::<4>();
        entries.iter().skip(1).find(|entry| entry[..2] == [wanted, 0]).map(|entry| entry[3])
    }

    /// Returns the value of a key that is a floating-point number.
    fn double(&self, wanted: u16) -> Option<f64> {
        let (entries, _) = self.keys.as_chunks::<4>();
        let is_wanted = |entry: &&[u16; 4]| entry[..2] == [wanted, geo_key::DOUBLES];
        let entry = entries.iter().skip(1).find(is_wanted)?;
        self.doubles.as_ref()?.get(usize::from(entry[3])).copied()
    }

    /// Returns the ellipsoid of longitudes and latitudes, or `None` if the file names no geographic system.
    ///
    /// # Errors
    /// If longitudes and latitudes are not in degrees, or the file names a system whose ellipsoid is not known.
    fn ellipsoid(&self) -> Result<Option<Ellipsoid>, String> {
        match self.key(geo_key::ANGULAR_UNITS) {
            None | Some(geo_key::DEGREE) => {}
            Some(9105) => return Err(not_degrees("grads (EPSG:9105)")),
            Some(9101) => return Err(not_degrees("radians (EPSG:9101)")),
            Some(unit) => return Err(not_degrees(&format!("the unit EPSG:{unit}"))),
        }
        let of_code = match self.code(geo_key::GEOGRAPHIC_SYSTEM) {
            Some(code) => ellipsoids::of_system(code)?,
            None => None,
        };
        let radius = self.double(geo_key::SEMI_MAJOR_AXIS);
        let inverse = self.double(geo_key::INVERSE_FLATTENING);
        let minor = self.double(geo_key::SEMI_MINOR_AXIS);
        let own = radius.and_then(|radius| match (inverse, minor) {
            (Some(inverse), _) => Ellipsoid::new(radius, inverse),
            (None, Some(minor)) if minor == radius => Ellipsoid::new(radius, 0.0),
            (None, Some(minor)) => Ellipsoid::new(radius, radius / (radius - minor)),
            (None, None) => None,
        });
        match (own.or(of_code), self.key(geo_key::GEOGRAPHIC_SYSTEM)) {
            (None, Some(code)) => Err(format!(
                "it names a coordinate system ({}) whose ellipsoid is not known here; gdalwarp -t_srs EPSG:4326 makes a \
                 grid on WGS 84",
                self.code(geo_key::GEOGRAPHIC_SYSTEM)
                    .map_or("its own".into(), |_| format!("EPSG:{code}"))
            )),
            (found, _) => Ok(found),
        }
    }

    /// Returns the value of a key if it is an EPSG code.
    pub(super) fn code(&self, wanted: u16) -> Option<u16> {
        self.key(wanted).filter(|code| (1..=geo_key::LARGEST_CODE).contains(code))
    }

    /// Returns the scale and the offset of the values, if the transformation contains them. As in GDAL, this
    /// is so in GeoTIFF 1.1 for files with a vertical system.
    pub(super) fn vertical(&self) -> Result<Option<[f64; 2]>, String> {
        let is_1_1 = self.keys.get(2).is_some_and(|minor| *minor >= 1);
        // Geographic systems with heights are not vertical systems.
        let vertical =
            self.key(geo_key::VERTICAL_SYSTEM).filter(|code| *code != geo_key::WGS_84_WITH_HEIGHTS);
        let (Some(scale), Some(tie)) = (&self.pixel_scale, &self.tie_points) else {
            return Ok(None);
        };
        let ([_, _, scale], [_, _, from, _, _, to, ..]) = (&scale[..], &tie[..]) else {
            return Ok(None);
        };
        match (is_1_1 && vertical.is_some(), *scale, to - from * scale) {
            (false, ..) | (true, 0.0 | 1.0, 0.0) => Ok(None),
            (true, 0.0, _) => {
                Err("its ModelTiepoint shifts heights, and its ModelPixelScale gives \
                                   them no scale; gdal_translate -a_scale 1 -a_offset 0 takes \
                                   values as they are"
                    .into())
            }
            (true, scale, offset) => Ok(Some([scale, offset])),
        }
    }

    /// Returns the location of the pixels' middles, or a message that says what is missing.
    pub(super) fn georeference(&self) -> Result<Georeference, String> {
        let missing = |what: &str| {
            format!(
                "is not georeferenced: it lacks the GeoTIFF tag {what}; gdal_translate -a_ullr \
                 writes it"
            )
        };
        let Some((origin, [down, right])) = self.linear() else {
            return Err(match self.tie_points() {
                0 | 1 => missing("ModelPixelScale (or ModelTransformation)"),
                points => format!("is not georeferenced: {}", Self::control_points(points)),
            });
        };
        let of_tie_point = || match self.tie_points.as_deref() {
            Some(&[col, row, _, x, y, ..]) => Some([x - col * right[0], y - row * down[1]]),
            _ => None,
        };
        let origin = origin.or_else(of_tie_point).ok_or_else(|| missing("ModelTiepoint"))?;
        let numbers = [origin, down, right];
        let determinant = right[0] * down[1] - right[1] * down[0];
        if !numbers.as_flattened().iter().all(|number| number.is_finite()) || determinant == 0.0 {
            return Err("is not georeferenced: its transformation has no inverse".into());
        }
        // In the fields, row 0 and column 0 lie at the first pixel's corner, unless pixels stand for points.
        let point = self.key(geo_key::RASTER_TYPE) == Some(geo_key::PIXEL_IS_POINT);
        let half = if point { 0.0 } else { 0.5 };
        let origin = std::array::from_fn(|k| origin[k] + half * (down[k] + right[k]));
        Ok(Georeference { origin, down, right, system: self.system() })
    }

    /// Returns the coordinates at row 0, column 0 of the raster, unless a tie point gives them, and their changes per
    /// row and per column, from the field to which GDAL gives precedence.
    pub(super) fn linear(&self) -> Option<(Option<Pair>, [Pair; 2])> {
        match (self.pixel_scale.as_deref(), self.transformation.as_deref()) {
            // As in GDAL, files with a negative pixel height count as north-up.
            (Some(&[dx, dy, ..]), _) if dx != 0.0 && dy != 0.0 => {
                Some((None, [[0.0, -dy.abs()], [dx, 0.0]]))
            }
            (_, Some(&[a, b, _, x, c, d, _, y, ..])) => Some((Some([x, y]), [[b, d], [a, c]])),
            _ => None,
        }
    }

    /// Returns the coordinate reference system, if the keys name it by an EPSG code.
    fn system(&self) -> Option<CoordinateSystem> {
        match self.key(geo_key::MODEL_TYPE)? {
            geo_key::PROJECTED => {
                self.code(geo_key::PROJECTED_SYSTEM).map(CoordinateSystem::Projected)
            }
            geo_key::GEOGRAPHIC => {
                self.code(geo_key::GEOGRAPHIC_SYSTEM).map(CoordinateSystem::Geographic)
            }
            _ => None,
        }
    }

    /// Writes the fields, for values that are not heights: no field scales or shifts them.
    pub(super) fn write<W: Write + Seek, K: TiffKind>(
        &self,
        directory: &mut DirectoryEncoder<W, K>,
    ) -> TiffResult<()> {
        if let Some(mut scale) = self.pixel_scale.clone() {
            if let Some(up) = scale.get_mut(2) {
                *up = f64::from(u8::from(self.key(geo_key::VERTICAL_SYSTEM).is_some()));
            }
            directory.write_tag(Tag::ModelPixelScaleTag, &scale[..])?;
        }
        if let Some(mut points) = self.tie_points.clone() {
            for point in points.as_chunks_mut::<6>().0 {
                (point[2], point[5]) = (0.0, 0.0);
            }
            directory.write_tag(Tag::ModelTiepointTag, &points[..])?;
        }
        if let Some(mut matrix) = self.transformation.clone() {
            if let Some(up) = matrix.get_mut(8..12) {
                up.fill(0.0);
            }
            directory.write_tag(Tag::ModelTransformationTag, &matrix[..])?;
        }
        if !self.keys.is_empty() {
            directory.write_tag(Tag::GeoKeyDirectoryTag, &self.keys[..])?;
        }
        if let Some(doubles) = &self.doubles {
            directory.write_tag(Tag::GeoDoubleParamsTag, &doubles[..])?;
        }
        if let Some(text) = &self.text {
            directory.write_tag(Tag::GeoAsciiParamsTag, Text(text))?;
        }
        Ok(())
    }
}

/// A field of text, byte for byte with its end mark.
struct Text<'a>(&'a [u8]);

impl TiffValue for Text<'_> {
    const BYTE_LEN: u8 = 1;
    const FIELD_TYPE: Type = Type::ASCII;

    fn count(&self) -> usize {
        self.0.len()
    }

    fn data(&self) -> Cow<'_, [u8]> {
        self.0.into()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::file_spacing::FileSpacing;

    pub const UTM: [u16; 12] = [1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32616];

    pub fn tags(keys: &[u16]) -> GeoTags {
        GeoTags {
            pixel_scale: Some(vec![30.0, 20.0, 0.0]),
            tie_points: Some(vec![1.0, 2.0, 0.0, 5e5, 4e6, 0.0]),
            transformation: None,
            keys: keys.to_vec(),
            ..GeoTags::default()
        }
    }

    #[test]
    fn degrees_are_written_in_any_order_of_rows() {
        for down in [-0.5, 0.5] {
            let right = [0.25, 0.0];
            let system = Some(CoordinateSystem::WGS_84);
            let wanted = Georeference { origin: [8.0, 47.0], down: [0.0, down], right, system };
            let tags = GeoTags::new(&wanted);
            assert_eq!(tags.georeference(), Ok(wanted));
            assert!(matches!(tags.spacing(None), FileSpacing::Degrees(_)));
        }
    }

    #[test]
    fn missing_fields_are_named() {
        let missing = |tags: GeoTags| tags.georeference().unwrap_err();
        assert!(missing(GeoTags { tie_points: None, ..tags(&UTM) }).contains("ModelTiepoint"));
        assert!(missing(GeoTags { pixel_scale: None, ..tags(&UTM) }).contains("ModelPixelScale"));
        let transformation = Some([[1.0, 0.0, 0.0, 5.0]; 4].concat());
        let short = GeoTags { pixel_scale: Some(vec![30.0]), transformation, ..tags(&UTM) };
        assert!(short.georeference().unwrap_err().contains("no inverse"));
        let user_defined = [1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 32767];
        for keys in [&[][..], &[1, 1, 0, 1, 1024, 0, 1, 1], &user_defined] {
            assert_eq!(tags(keys).georeference().unwrap().system, None);
        }
    }

    #[test]
    fn units_of_values_and_control_points_count() {
        let spacing = |unit| tags(&UTM).spacing(unit);
        assert_eq!(spacing(Some("Metre")), spacing(None));
        let us_feet = [&UTM[..9], &[0, 1, 2263]].concat();
        for (keys, unit) in [(&UTM[..], "ft"), (&UTM, "degC"), (&us_feet, "m")] {
            assert!(matches!(tags(keys).spacing(Some(unit)), FileSpacing::Unusable(_)), "{unit}");
        }
        let FileSpacing::Known(_, unit) = tags(&us_feet).spacing(Some("US survey foot")) else {
            panic!("both are in US feet")
        };
        assert_eq!(unit.name, Some("US ft"));
        let points = GeoTags { pixel_scale: None, tie_points: Some(vec![0.0; 18]), ..tags(&UTM) };
        assert!(points.georeference().unwrap_err().contains("3 ground control points"));
        let FileSpacing::Unusable(why) = points.spacing(None) else { panic!("no pixel size") };
        assert!(why.contains("gdalwarp"), "{why}");
    }

    #[test]
    fn a_vertical_system_makes_the_transformation_scale_heights() {
        let vertical = |minor, scale, to| {
            let keys = [1, 1, minor, 3, 1024, 0, 1, 1, 3072, 0, 1, 32633, 4096, 0, 1, 5773];
            let tie_points = Some(vec![0.0, 0.0, 7.0, 5e5, 4e6, to]);
            GeoTags { pixel_scale: Some(vec![30.0, 20.0, scale]), tie_points, ..tags(&keys) }
                .vertical()
        };
        // The expected values are those of GDAL.
        assert_eq!(vertical(1, 2.0, 100.0), Ok(Some([2.0, 86.0])));
        assert_eq!(vertical(0, 2.0, 100.0), Ok(None));
        assert_eq!(vertical(1, 1.0, 7.0), Ok(None));
        assert!(vertical(1, 0.0, 100.0).unwrap_err().contains("gdal_translate"));
    }
}
