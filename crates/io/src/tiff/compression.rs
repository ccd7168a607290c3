//! Decompresses strips and tiles, for lossless compressions.

use std::borrow::Cow;
use std::io::Read;

use ::tiff::tags::CompressionMethod;
use flate2::read::ZlibDecoder;
use weezl::LzwStatus;

use super::cure::Cure;
use crate::limits::{check_decoded, ratio};

/// Returns the supported compression with this number, or an error with a command that converts the file.
pub fn supported(number: u64, cure: &Cure) -> Result<CompressionMethod, String> {
    let name = match number {
        1 => return Ok(CompressionMethod::None),
        5 => return Ok(CompressionMethod::LZW),
        8 | 32946 => return Ok(CompressionMethod::Deflate),
        32773 => return Ok(CompressionMethod::PackBits),
        2..=4 => "CCITT fax",
        6 | 7 => "JPEG, which loses digits",
        34676 | 34677 => "SGI Log, which loses digits",
        34712 => "JPEG 2000",
        34887 => "LERC",
        34892 | 50002 | 52546 => "JPEG XL",
        34925 => "LZMA",
        50000 => "ZSTD",
        50001 => "WebP",
        _ => "a kind that is not known",
    };
    Err(format!(
        "is compressed by {name} (Compression {number}), which is not read; convert it: {}",
        cure.translate("-co COMPRESS=DEFLATE")
    ))
}

/// Decompresses the first `size` bytes of a supported compression. The result may be longer, and callers ignore its
/// rest. As in libtiff, data after the first `size` bytes are not decoded.
pub fn decode(
    compression: CompressionMethod,
    data: Cow<[u8]>,
    size: usize,
) -> Result<Cow<[u8]>, String> {
    let check = |ratio| check_decoded(data.len(), ratio, size);
    let decoded: Cow<[u8]> = match compression {
        CompressionMethod::PackBits => check(ratio::RUNS).map(|()| unpacked(&data, size))?.into(),
        CompressionMethod::LZW => check(ratio::LZW).and_then(|()| lzw(&data, size))?.into(),
        CompressionMethod::Deflate => {
            check(ratio::DEFLATE).and_then(|()| inflated(&data, size))?.into()
        }
        _ => check(ratio::STORED).map(|()| data)?,
    };
    match decoded.len() {
        there if there < size => Err(format!("ends after {there} of {size} bytes")),
        _ => Ok(decoded),
    }
}

fn inflated(data: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut decoded = Vec::with_capacity(size);
    let read = ZlibDecoder::new(data).take(size as u64).read_to_end(&mut decoded);
    read.map_err(|error| format!("its deflate stream is damaged: {error}"))?;
    Ok(decoded)
}

fn lzw(data: &[u8], size: usize) -> Result<Vec<u8>, String> {
    // Before TIFF 6, codes were stored in reverse bit order. The first code is "clear", 256.
    if let [0, second, ..] = data
        && second & 1 == 1
    {
        return Err("uses the LZW compression from before TIFF 6, which is not read".into());
    }
    let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8);
    let mut decoded = vec![0; size];
    let (mut consumed, mut written) = (0, 0);
    while written < size {
        let step = decoder.decode_bytes(&data[consumed..], &mut decoded[written..]);
        consumed += step.consumed_in;
        written += step.consumed_out;
        match step.status {
            // Writers end streams in different ways, so an error after the last wanted byte is ignored.
            Ok(LzwStatus::Ok) if step.consumed_in + step.consumed_out > 0 => {}
            Ok(_) => break,
            Err(error) if written < size => {
                return Err(format!("its LZW stream is damaged: {error}"));
            }
            Err(_) => break,
        }
    }
    decoded.truncate(written);
    Ok(decoded)
}

/// Decodes PackBits: runs and copies of at most 128 bytes each.
fn unpacked(data: &[u8], size: usize) -> Vec<u8> {
    let mut decoded = Vec::with_capacity(size);
    let mut rest = data;
    while decoded.len() < size
        && let Some((&control, after)) = rest.split_first()
    {
        rest = after;
        match control as i8 {
            -128 => {}
            count @ 0.. => {
                let (copied, after) = rest.split_at(rest.len().min(count as usize + 1));
                decoded.extend_from_slice(copied);
                rest = after;
            }
            count => {
                let Some((&value, after)) = rest.split_first() else { break };
                decoded.resize(decoded.len() + usize::from(count.unsigned_abs()) + 1, value);
                rest = after;
            }
        }
    }
    decoded
}
