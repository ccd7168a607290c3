//! Reads the numbers of one band, chunk by chunk.

use std::borrow::Cow;

use ::tiff::tags::Predictor;

use super::compression::decode;
use super::directory::File;
use super::layout::Layout;

/// Calls `put` with the row-major index of each grid point and the bits of its number, chunk by chunk. The
/// bits are `None` in sparse chunks, which were never written.
pub fn read_band(
    file: &File,
    layout: &Layout,
    band: usize,
    mut put: impl FnMut(usize, Option<u64>),
) -> Result<(), String> {
    let [chunk_rows, chunk_cols] = layout.chunk;
    let mut words = Vec::new();
    for down in 0..layout.chunks_down() {
        for across in 0..layout.chunks_across() {
            let (top, left) = (down * chunk_rows, across * chunk_cols);
            let rows = top..layout.rows.min(top + chunk_rows);
            let cols = left..layout.cols.min(left + chunk_cols);
            let Some(chunk) = layout.chunk_at(down, across, band) else {
                for point in rows.flat_map(|row| cols.clone().map(move |col| (row, col))) {
                    put(point.0 * layout.cols + point.1, None);
                }
                continue;
            };
            let place = |reason| {
                let kind = if layout.tiled { "tile" } else { "strip" };
                format!("its {kind} at row {top}, column {left} cannot be read: {reason}")
            };
            let missing = || place("the file is cut short".into());
            let data = file.slice(chunk.offset, chunk.length).ok_or_else(missing)?;
            if chunk.offset == 0 {
                return Err(place("it would lie in the file's header".into()));
            }
            let data = if layout.reversed {
                Cow::Owned(data.iter().map(|byte| byte.reverse_bits()).collect())
            } else {
                Cow::Borrowed(data)
            };
            let decoded =
                decode(layout.compression, data, layout.chunk_bytes(down)).map_err(place)?;
            let (stride, first) = (layout.interleaved(), if layout.planar { 0 } else { band });
            for (row, bytes) in rows.zip(decoded.chunks_exact(layout.row_bytes())) {
                unpack(bytes, layout, file.is_big_endian(), &mut words);
                for (col, word) in cols.clone().zip(words.iter().skip(first).step_by(stride)) {
                    put(row * layout.cols + col, Some(*word));
                }
            }
        }
    }
    Ok(())
}

/// Decodes the numbers of a row of a chunk, and reverses the predictor.
fn unpack(bytes: &[u8], layout: &Layout, big_endian: bool, words: &mut Vec<u64>) {
    let stride = layout.interleaved();
    let (count, bits) = (layout.chunk[1] * stride, layout.sample.bits);
    words.clear();
    if layout.predictor == Predictor::FloatingPoint {
        // Bytes are cumulative sums over the row. The first bytes of all numbers come first, then all second
        // ones, and so on.
        let mut bytes = bytes.to_vec();
        for index in stride..bytes.len() {
            bytes[index] = bytes[index].wrapping_add(bytes[index - stride]);
        }
        let word = |index| {
            let planes = bytes.chunks_exact(count);
            planes.fold(0, |word, plane| word << 8 | u64::from(plane[index]))
        };
        words.extend((0..count).map(word));
        return;
    }
    macro_rules! whole {
        ($type:ty) => {{
            let from = if big_endian { <$type>::from_be_bytes } else { <$type>::from_le_bytes };
            words.extend(bytes.as_chunks().0.iter().map(|bytes| u64::from(from(*bytes))));
        }};
    }
    match bits {
        8 => words.extend(bytes.iter().map(|byte| u64::from(*byte))),
        16 => whole!(u16),
        32 => whole!(u32),
        64 => whole!(u64),
        _ => words.extend((0..count).map(|index| bit_field(bytes, index * bits, bits))),
    }
    if layout.predictor == Predictor::Horizontal {
        let mask = u64::MAX >> (64 - bits);
        for index in stride..words.len() {
            words[index] = words[index].wrapping_add(words[index - stride]) & mask;
        }
    }
}

/// Returns the number of `bits` bits that begins at bit `from`. The most significant bit comes first in
/// either byte order.
fn bit_field(bytes: &[u8], from: usize, bits: usize) -> u64 {
    let bit = |at: usize| u64::from(bytes[at / 8] >> (7 - at % 8) & 1);
    (from..from + bits).fold(0, |word, at| word << 1 | bit(at))
}
