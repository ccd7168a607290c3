//! What GeoTIFF's tags (OGC 19-008r4) say about a raster: the distance between its points and
//! where they lie.

use std::io::Cursor;

use ::tiff::TiffResult;
use ::tiff::decoder::Decoder;
use ::tiff::tags::Tag;

use super::file_spacing::{FileSpacing, LinearUnit};
use super::{CoordinateSystem, Georeference};
use crate::surface::Spacing;

/// Keys of the GeoKeyDirectory, and values of theirs.
mod geo_key {
    pub const MODEL_TYPE: u16 = 1024;
    pub const PROJECTED: u16 = 1;
    pub const GEOGRAPHIC: u16 = 2;
    pub const RASTER_TYPE: u16 = 1025;
    pub const PIXEL_IS_POINT: u16 = 2;
    pub const GEOGRAPHIC_SYSTEM: u16 = 2048;
    pub const PROJECTED_SYSTEM: u16 = 3072;
    pub const PROJECTED_LINEAR_UNITS: u16 = 3076;
    pub const VERTICAL_UNITS: u16 = 4099;
    pub const METRE: u16 = 9001;
    pub const FOOT: u16 = 9002;
    pub const US_SURVEY_FOOT: u16 = 9003;
    /// EPSG codes end below; above are "undefined" and "user-defined".
    pub const LARGEST_CODE: u16 = 32766;
}

/// A TIFF file in memory.
pub(super) type TiffDecoder<'a> = Decoder<Cursor<&'a [u8]>>;

/// The tags, as far as the file has them.
pub(super) struct GeoTags {
    pixel_scale: Option<Vec<f64>>,
    tie_points: Option<Vec<f64>>,
    transformation: Option<Vec<f64>>,
    keys: Vec<u16>,
}

/// Coordinates of raster place (0, 0), and what they change by per row and per column.
struct Transform {
    origin: [f64; 2],
    down: [f64; 2],
    right: [f64; 2],
}

impl GeoTags {
    pub fn read(decoder: &mut TiffDecoder) -> TiffResult<Self> {
        let keys = decoder.find_tag(Tag::GeoKeyDirectoryTag)?;
        let mut numbers =
            |tag| decoder.find_tag(tag)?.map(|value| value.into_f64_vec()).transpose();
        Ok(Self {
            pixel_scale: numbers(Tag::ModelPixelScaleTag)?,
            tie_points: numbers(Tag::ModelTiepointTag)?,
            transformation: numbers(Tag::ModelTransformationTag)?,
            keys: keys.map(|keys| keys.into_u16_vec()).transpose()?.unwrap_or_default(),
        })
    }

    fn key(&self, wanted: u16) -> Option<u16> {
        // Entries are (key, location, count, value); location 0 means the value itself.
        let (entries, _) = self.keys.as_chunks::<4>();
        entries.iter().skip(1).find(|entry| entry[..2] == [wanted, 0]).map(|entry| entry[3])
    }

    /// The distance between pixels, if the file says it in a unit of length.
    pub fn spacing(&self) -> FileSpacing {
        let Some(scale) = &self.pixel_scale else {
            return match self.transformation {
                Some(_) => {
                    FileSpacing::Unusable("the file places its pixels by a general transformation")
                }
                None => FileSpacing::Unknown,
            };
        };
        if self.key(geo_key::MODEL_TYPE) != Some(geo_key::PROJECTED) {
            return FileSpacing::Unusable(
                "the file gives its pixel size in degrees, or does not say in what unit",
            );
        }
        let unit = match self.unit() {
            Ok(unit) => unit,
            Err(why) => return FileSpacing::Unusable(why),
        };
        match scale[..] {
            [dx, dy, ..] => FileSpacing::Known(Spacing { dx, dy }, unit),
            _ => FileSpacing::Unusable("the file's pixel size is incomplete"),
        }
    }

    /// The unit of pixel sizes and heights, which must be one.
    fn unit(&self) -> Result<LinearUnit, &'static str> {
        let across = self.key(geo_key::PROJECTED_LINEAR_UNITS);
        let name = |unit| match unit {
            geo_key::METRE => Some("m"),
            geo_key::FOOT => Some("ft"),
            geo_key::US_SURVEY_FOOT => Some("US ft"),
            _ => None,
        };
        // Heights are in metres unless the file says otherwise.
        match (across, self.key(geo_key::VERTICAL_UNITS).unwrap_or(geo_key::METRE)) {
            (None, geo_key::METRE) => Ok(LinearUnit { name: name(geo_key::METRE), said: false }),
            (None, _) => {
                Err("the file gives its heights in a unit other than metres, and does not \
                              say in what unit its pixel size is (key ProjLinearUnits)")
            }
            (Some(across), up) if across == up && across <= geo_key::LARGEST_CODE => {
                Ok(LinearUnit { name: name(across), said: true })
            }
            (Some(geo_key::METRE), _) => {
                Err("the file gives its heights in a unit other than its \
                                              pixel size's, which is in metres")
            }
            _ => Err("the file gives its pixel size in a unit other than metres, and not its \
                      heights in the same"),
        }
    }

    /// Where the pixels' middles lie, or what is missing.
    pub fn georeference(&self) -> Result<Georeference, String> {
        let Transform { origin, down, right } = self.transform()?;
        let system = self.system()?;
        // Tags count from the first pixel's corner, unless pixels stand for points.
        let point = self.key(geo_key::RASTER_TYPE) == Some(geo_key::PIXEL_IS_POINT);
        let half = if point { 0.0 } else { 0.5 };
        let origin = std::array::from_fn(|k| origin[k] + half * (down[k] + right[k]));
        Ok(Georeference { origin, down, right, system: Some(system) })
    }

    fn transform(&self) -> Result<Transform, String> {
        if let Some([a, b, _, x, c, d, _, y, ..]) = self.transformation.as_deref() {
            return Ok(Transform { origin: [*x, *y], down: [*b, *d], right: [*a, *c] });
        }
        let missing = |what: &str| {
            format!(
                "is not georeferenced: it lacks the GeoTIFF tag {what}; gdal_translate -a_ullr \
                 writes it"
            )
        };
        let Some([dx, dy, ..]) = self.pixel_scale.as_deref() else {
            return Err(missing("ModelPixelScale (or ModelTransformation)"));
        };
        let Some([col, row, _, x, y, ..]) = self.tie_points.as_deref() else {
            return Err(missing("ModelTiepoint"));
        };
        let origin = [x - col * dx, y + row * dy];
        Ok(Transform { origin, down: [0.0, -dy], right: [*dx, 0.0] })
    }

    fn system(&self) -> Result<CoordinateSystem, String> {
        let code = |key, name| match self.key(key) {
            Some(code @ 1..=geo_key::LARGEST_CODE) => Ok(code),
            _ => Err(format!(
                "is not georeferenced: its GeoTIFF key {name} names no EPSG code; gdal_translate \
                 -a_srs EPSG:CODE writes it"
            )),
        };
        match self.key(geo_key::MODEL_TYPE) {
            Some(geo_key::PROJECTED) => {
                code(geo_key::PROJECTED_SYSTEM, "ProjectedCRS").map(CoordinateSystem::Projected)
            }
            Some(geo_key::GEOGRAPHIC) => {
                code(geo_key::GEOGRAPHIC_SYSTEM, "GeodeticCRS").map(CoordinateSystem::Geographic)
            }
            _ => Err("is not georeferenced: its GeoTIFF key GTModelType is missing, or says \
                      neither projected nor geographic; gdal_translate -a_srs EPSG:CODE writes it"
                .into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UTM: [u16; 12] = [1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32616];

    fn tags(keys: &[u16]) -> GeoTags {
        GeoTags {
            pixel_scale: Some(vec![30.0, 20.0, 0.0]),
            tie_points: Some(vec![1.0, 2.0, 0.0, 5e5, 4e6, 0.0]),
            transformation: None,
            keys: keys.to_vec(),
        }
    }

    #[test]
    fn pixels_lie_by_their_middles_or_where_they_are_points() {
        let area = tags(&UTM).georeference().unwrap();
        assert_eq!(area.system, Some(CoordinateSystem::Projected(32616)));
        // Row 2, column 1 has its upper left corner at the tie point.
        assert_eq!(area.coordinates([2.0, 1.0]), [5e5 + 15.0, 4e6 - 10.0]);
        assert_eq!(area.coordinates([3.0, 3.0]), [5e5 + 75.0, 4e6 - 30.0]);
        let point = tags(&[&UTM[..], &[1025, 0, 1, 2]].concat()).georeference().unwrap();
        assert_eq!(point.coordinates([2.0, 1.0]), [5e5, 4e6]);
    }

    #[test]
    fn transformations_may_turn_the_raster() {
        let mut tags = tags(&[1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326]);
        let mut matrix = vec![0.0; 16];
        matrix[..8].copy_from_slice(&[0.0, 0.5, 0.0, 10.0, 0.25, 0.0, 0.0, 50.0]);
        tags.transformation = Some(matrix);
        let found = tags.georeference().unwrap();
        assert_eq!(found.system, Some(CoordinateSystem::WGS_84));
        // X grows by 0.5 a row, Y by 0.25 a column.
        assert_eq!(found.coordinates([2.0, 4.0]), [10.0 + 0.5 * 2.5, 50.0 + 0.25 * 4.5]);
    }

    #[test]
    fn what_is_missing_is_named() {
        let missing = |tags: GeoTags| tags.georeference().unwrap_err();
        assert!(missing(GeoTags { tie_points: None, ..tags(&UTM) }).contains("ModelTiepoint"));
        assert!(missing(GeoTags { pixel_scale: None, ..tags(&UTM) }).contains("ModelPixelScale"));
        assert!(missing(tags(&[])).contains("GTModelType"));
        assert!(missing(tags(&[1, 1, 0, 1, 1024, 0, 1, 1])).contains("ProjectedCRS"));
        let user_defined = [1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 32767];
        assert!(missing(tags(&user_defined)).contains("GeodeticCRS"));
    }

    #[test]
    fn pixel_sizes_count_where_heights_are_in_the_same_unit() {
        let spacing = |units: &[[u16; 2]]| {
            let entries = units.iter().flat_map(|&[key, unit]| [key, 0, 1, unit]);
            tags(&UTM.into_iter().chain(entries).collect::<Vec<_>>()).spacing()
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
