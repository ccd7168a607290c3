//! Writes maps as GeoTIFF.

use std::io::{self, Seek, Write};

use ::tiff::TiffError;
use ::tiff::encoder::colortype::ColorType as Channel;
use ::tiff::encoder::{TiffEncoder, TiffValue};
use ::tiff::tags::Tag;

use super::GeoTags;

/// Writes values as one grey channel with a no-data value and, if it is known, their location.
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
