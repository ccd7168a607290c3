//! TIFF: heights, with what GeoTIFF and GDAL say about them, and distance maps.

use std::io::{self, Cursor, Seek, Write};

use ::tiff::decoder::{Decoder, DecodingResult, Limits};
use ::tiff::encoder::{TiffEncoder, colortype::Gray32Float};
use ::tiff::tags::Tag;
use ::tiff::{ColorType, TiffError, TiffResult};

use super::surface_file::FileSpacing;
use super::{Grid, MAX_POINTS, checked_points};
use crate::surface::Spacing;

/// Heights, NaN where the file says "no data".
pub(super) struct Raster {
    pub grid: Grid<f64>,
    pub spacing: FileSpacing,
}

/// Keys and values of GeoTIFF's GeoKeyDirectory.
mod geo_key {
    pub const MODEL_TYPE: u16 = 1024;
    pub const PROJECTED: u16 = 1;
    pub const PROJECTED_LINEAR_UNITS: u16 = 3076;
    pub const METRE: u16 = 9001;
}

pub(super) fn decode(bytes: &[u8]) -> Result<Raster, String> {
    let malformed = |error: TiffError| format!("is no usable TIFF file: {error}");
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(malformed)?.with_limits(limits());
    let (cols, rows) = decoder.dimensions().map_err(malformed)?;
    let (rows, cols) = (rows as usize, cols as usize);
    let points = checked_points(rows, cols)?;
    let color = decoder.colortype().map_err(malformed)?;
    if !matches!(color, ColorType::Gray(_)) {
        return Err(format!("is a picture of type {color:?}; heights are a single grey channel"));
    }
    let no_data = no_data(&mut decoder)?;
    let spacing = spacing(&mut decoder).map_err(malformed)?;
    let samples = decoder.read_image().map_err(malformed)?;
    let values = heights(samples, no_data)?;
    if values.len() != points {
        return Err(format!("holds {} values for {rows} x {cols} points", values.len()));
    }
    Ok(Raster { grid: Grid { rows, cols, values }, spacing })
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MAX_POINTS * size_of::<f64>();
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    limits
}

type TiffDecoder<'a> = Decoder<Cursor<&'a [u8]>>;

/// GDAL's value for "no data", written as text.
fn no_data(decoder: &mut TiffDecoder) -> Result<Option<f64>, String> {
    let Ok(text) = decoder.get_tag_ascii_string(Tag::GdalNodata) else { return Ok(None) };
    let text = text.trim_matches(|c: char| c == '\0' || c.is_whitespace());
    let value = text.parse().map_err(|_| format!("its no-data value `{text}` is no number"))?;
    Ok(Some(value))
}

fn heights(samples: DecodingResult, no_data: Option<f64>) -> Result<Vec<f64>, String> {
    macro_rules! widen {
        ($samples:expr, $type:ty) => {{
            // Compared in the file's type, if that has the value: the text may have more digits
            // than a float32, or be -9999 for unsigned integers.
            let in_type = |value: f64| {
                let rounded = value as $type as f64;
                ((rounded - value).abs() <= 1e-6 * value.abs()).then_some(rounded)
            };
            let no_data = no_data.and_then(in_type);
            let widen = |sample: $type| match sample as f64 {
                value if Some(value) == no_data => f64::NAN,
                value => value,
            };
            $samples.into_iter().map(widen).collect()
        }};
    }
    Ok(match samples {
        DecodingResult::U8(samples) => widen!(samples, u8),
        DecodingResult::U16(samples) => widen!(samples, u16),
        DecodingResult::U32(samples) => widen!(samples, u32),
        DecodingResult::I8(samples) => widen!(samples, i8),
        DecodingResult::I16(samples) => widen!(samples, i16),
        DecodingResult::I32(samples) => widen!(samples, i32),
        DecodingResult::F32(samples) => widen!(samples, f32),
        DecodingResult::F64(samples) => widen!(samples, f64),
        _ => {
            return Err("its number type is not supported; use integers of 8, 16 or 32 bits or \
                        float32 or float64, e.g. gdal_translate -ot Float32"
                .into());
        }
    })
}

/// The distance between pixels, if the file says it in a unit of length.
fn spacing(decoder: &mut TiffDecoder) -> TiffResult<FileSpacing> {
    let Some(scale) = decoder.find_tag(Tag::ModelPixelScaleTag)? else {
        let turned = decoder.find_tag(Tag::ModelTransformationTag)?.is_some();
        return Ok(if turned {
            FileSpacing::Unusable("the file places its pixels by a general transformation")
        } else {
            FileSpacing::Unknown
        });
    };
    let keys = match decoder.find_tag(Tag::GeoKeyDirectoryTag)? {
        Some(keys) => keys.into_u16_vec()?,
        None => Vec::new(),
    };
    // Entries are (key, location, count, value); location 0 means the value itself.
    let key = |wanted| {
        let (entries, _) = keys.as_chunks::<4>();
        entries.iter().skip(1).find(|entry| entry[..2] == [wanted, 0]).map(|entry| entry[3])
    };
    if key(geo_key::MODEL_TYPE) != Some(geo_key::PROJECTED) {
        return Ok(FileSpacing::Unusable(
            "the file gives its pixel size in degrees, or does not say in what unit",
        ));
    }
    if key(geo_key::PROJECTED_LINEAR_UNITS).is_some_and(|unit| unit != geo_key::METRE) {
        return Ok(FileSpacing::Unusable(
            "the file gives its pixel size in a unit other than metres",
        ));
    }
    Ok(match scale.into_f64_vec()?[..] {
        [dx, dy, ..] => FileSpacing::Known(Spacing { dx, dy }),
        _ => FileSpacing::Unusable("the file's pixel size is incomplete"),
    })
}

/// Writes a map as one channel of float32.
pub(super) fn encode(
    writer: &mut (impl Write + Seek),
    rows: usize,
    cols: usize,
    values: &[f32],
) -> io::Result<()> {
    let size = |n: usize| u32::try_from(n).map_err(io::Error::other);
    TiffEncoder::new(writer)
        .and_then(|mut encoder| {
            encoder.write_image::<Gray32Float>(size(cols)?, size(rows)?, values)
        })
        .map_err(|error| match error {
            TiffError::IoError(error) => error,
            other => io::Error::other(other),
        })
}
