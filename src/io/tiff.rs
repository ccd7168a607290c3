//! TIFF: heights, with what GeoTIFF and GDAL say about them, and distance maps.

use std::io::{self, Cursor, Seek, Write};

use ::tiff::decoder::ifd::Value;
use ::tiff::decoder::{Decoder, DecodingResult, Limits};
use ::tiff::encoder::colortype::ColorType as Channel;
pub(super) use ::tiff::encoder::colortype::{Gray32Float, Gray64Float};
use ::tiff::encoder::{TiffEncoder, TiffValue};
use ::tiff::tags::{CompressionMethod, Tag};
use ::tiff::{ColorType, TiffError, TiffResult};

use super::file_spacing::FileSpacing;
use super::geotiff::{GeoTags, TiffDecoder};
use super::limits::{check_decoded, check_memory, checked_points, most_decoded, ratio};
use super::{Georeference, Grid};

/// Heights, NaN where the file says "no data".
pub(super) struct Raster {
    pub grid: Grid<f64>,
    pub spacing: FileSpacing,
    /// Where its points lie on the Earth, or what the file does not say about it.
    pub georeference: Result<Georeference, String>,
}

pub(super) fn decode(bytes: &[u8]) -> Result<Raster, String> {
    let malformed = |error: TiffError| format!("is no usable TIFF file: {error}");
    let mut decoder = Decoder::new(Cursor::new(bytes))
        .map_err(malformed)?
        .with_limits(limits(bytes.len(), ratio::OTHER));
    let (cols, rows) = decoder.dimensions().map_err(malformed)?;
    let (rows, cols) = (rows as usize, cols as usize);
    let points = checked_points(rows, cols)?;
    let color = decoder.colortype().map_err(malformed)?;
    let ColorType::Gray(bits) = color else {
        return Err(format!("is a picture of type {color:?}; heights are a single grey channel"));
    };
    let ratio = compression(&mut decoder).map_err(malformed)?;
    check_decoded(bytes.len(), ratio, rows * (cols * usize::from(bits)).div_ceil(8))?;
    check_memory::<[u64; 2]>(points)?;
    let mut decoder = decoder.with_limits(limits(bytes.len(), ratio));
    let no_data = no_data(&mut decoder)?;
    let geo_tags = GeoTags::read(&mut decoder).map_err(malformed)?;
    let samples = decoder.read_image().map_err(malformed)?;
    let values = heights(samples, no_data)?;
    if values.len() != points {
        return Err(format!("holds {} values for {rows} x {cols} points", values.len()));
    }
    Ok(Raster {
        grid: Grid { rows, cols, values },
        spacing: geo_tags.spacing(),
        georeference: geo_tags.georeference(),
    })
}

fn limits(file: usize, ratio: u64) -> Limits {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = most_decoded(file, ratio);
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    limits
}

/// How many bytes the file's compression makes of one.
fn compression(decoder: &mut TiffDecoder) -> TiffResult<u64> {
    let method = decoder.find_tag(Tag::Compression)?.map(Value::into_u16).transpose()?;
    let method = method.map_or(CompressionMethod::None, CompressionMethod::from_u16_exhaustive);
    Ok(match method {
        CompressionMethod::None => ratio::STORED,
        CompressionMethod::PackBits => ratio::RUNS,
        CompressionMethod::Deflate | CompressionMethod::OldDeflate => ratio::DEFLATE,
        CompressionMethod::LZW => ratio::LZW,
        _ => ratio::OTHER,
    })
}

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

/// Writes a map as one grey channel.
pub(super) fn encode<C: Channel>(
    writer: &mut (impl Write + Seek),
    rows: usize,
    cols: usize,
    values: &[C::Inner],
) -> io::Result<()>
where
    [C::Inner]: TiffValue,
{
    let size = |n: usize| u32::try_from(n).map_err(io::Error::other);
    TiffEncoder::new(writer)
        .and_then(|mut encoder| encoder.write_image::<C>(size(cols)?, size(rows)?, values))
        .map_err(|error| match error {
            TiffError::IoError(error) => error,
            other => io::Error::other(other),
        })
}
