//! Decodes grey PNG pictures: heights and masks.

use std::io::Cursor;

use ::png::{BitDepth, ColorType, Decoder, Limits, Transformations};

use super::Grid;
use super::limits::{PNG_BUFFERS, check_decoded, check_memory, checked_points, ratio};

/// The values of a grey picture. Values of 8 and 16 bits are unscaled; fewer bits are scaled to 0..=255.
pub(super) struct GreyPicture {
    pub grid: Grid<f64>,
    /// Bits per value in the file.
    pub bits: u8,
}

pub(super) fn decode(bytes: &[u8]) -> Result<GreyPicture, String> {
    let malformed = |error: ::png::DecodingError| format!("is not a usable PNG file: {error}");
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: PNG_BUFFERS });
    // These chunks could decompress to any size, and they say nothing about heights.
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_ignore_text_chunk(true);
    let info = decoder.read_header_info().map_err(malformed)?;
    let (rows, cols) = (info.height as usize, info.width as usize);
    let (color, depth) = (info.color_type, info.bit_depth);
    let points = checked_points(rows, cols)?;
    if color != ColorType::Grayscale {
        return Err(format!(
            "is a picture of type {color:?}; only grey PNG without alpha is read, since colours are not numbers"
        ));
    }
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(malformed)?;
    let width = if depth == BitDepth::Sixteen { 2 } else { 1 };
    check_decoded(bytes.len(), ratio::DEFLATE, rows * (cols * depth as usize).div_ceil(8))?;
    check_memory::<[u64; 2]>(points)?;
    let mut samples = vec![0; points * width];
    if reader.output_buffer_size() != Some(samples.len()) {
        return Err("is a PNG file with transparency; only grey PNG without alpha is read".into());
    }
    reader.next_frame(&mut samples).map_err(malformed)?;
    let values = match depth {
        BitDepth::Sixteen => {
            samples.as_chunks().0.iter().map(|b| u16::from_be_bytes(*b).into()).collect()
        }
        _ => samples.into_iter().map(f64::from).collect(),
    };
    Ok(GreyPicture { grid: Grid::new(rows, cols, values), bits: depth as u8 })
}
