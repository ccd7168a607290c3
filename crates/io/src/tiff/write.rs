//! Writes maps and fields of vectors as GeoTIFF.

use std::io::{self, Seek, Write};

use ::tiff::TiffError;
use ::tiff::encoder::colortype::ColorType as Channel;
use ::tiff::encoder::{TiffEncoder, TiffValue};
use ::tiff::tags::{PhotometricInterpretation, SampleFormat, Tag};

use super::GeoTags;

/// Two interleaved channels of single precision that are not colours.
pub enum Pair32Float {}

impl Channel for Pair32Float {
    type Inner = f32;
    const TIFF_VALUE: PhotometricInterpretation = PhotometricInterpretation::BlackIsZero;
    const BITS_PER_SAMPLE: &'static [u16] = &[32; 2];
    const SAMPLE_FORMAT: &'static [SampleFormat] = &[SampleFormat::IEEEFP; 2];

    /// Copies the values, since only compressed integers are predicted from their neighbours.
    fn horizontal_predict(row: &[f32], result: &mut Vec<f32>) {
        result.extend_from_slice(row);
    }
}

/// The value of the tag `ExtraSamples` for a channel without a stated meaning.
const UNSPECIFIED: u16 = 0;

/// Writes values as channels, with the no-data value and, if it is known, the location of the grid. The file
/// states no meaning for channels after the first.
pub fn encode<C: Channel>(
    writer: &mut (impl Write + Seek),
    [rows, cols]: [usize; 2],
    values: &[C::Inner],
    no_data: &str,
    geo_tags: Option<&GeoTags>,
) -> io::Result<()>
where
    [C::Inner]: TiffValue,
{
    let size = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let (rows, cols) = (size(rows)?, size(cols)?);
    let encode = || {
        let mut encoder = TiffEncoder::new(writer)?;
        let mut image = encoder.new_image::<C>(cols, rows)?;
        image.encoder().write_tag(Tag::GdalNodata, no_data)?;
        let further = vec![UNSPECIFIED; C::BITS_PER_SAMPLE.len() - 1];
        if !further.is_empty() {
            image.encoder().write_tag(Tag::ExtraSamples, further.as_slice())?;
        }
        if let Some(tags) = geo_tags {
            tags.write(image.encoder())?;
        }
        image.write_data(values)
    };
    encode().map_err(|error| match error {
        TiffError::IoError(error) => error,
        other => io::Error::other(other),
    })
}
