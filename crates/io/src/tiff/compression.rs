//! Decompresses strips and tiles, for lossless compressions.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::ZlibDecoder;
use weezl::LzwStatus;

use super::cure::Cure;
use crate::limits::{check_decoded, ratio};

/// A supported compression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    None,
    PackBits,
    Lzw,
    Deflate,
}

impl Compression {
    /// Returns the compression with this number, or an error with a command that converts the file.
    pub fn of(number: u64, cure: &Cure) -> Result<Self, String> {
        let name = match number {
            1 => return Ok(Self::None),
            5 => return Ok(Self::Lzw),
            8 | 32946 => return Ok(Self::Deflate),
            32773 => return Ok(Self::PackBits),
            2..=4 => "CCITT fax",
            6 | 7 => "JPEG, which loses digits",
            34676 | 34677 => "SGI Log, which loses digits",
            34712 => "JPEG 2000",
            34887 => "LERC",
            34892 | 52546 => "JPEG XL",
            34925 => "LZMA",
            50000 => "ZSTD",
            50001 => "WebP",
            50002 => "JPEG XL",
            _ => "a kind that is not known",
        };
        Err(format!(
            "is compressed by {name} (Compression {number}), which is not read; convert it: {}",
            cure.translate("-co COMPRESS=DEFLATE")
        ))
    }

    /// Returns whether streams of this compression may hold differences instead of numbers.
    pub fn has_predictor(self) -> bool {
        matches!(self, Self::Lzw | Self::Deflate)
    }

    /// Returns the maximum ratio of decompressed to compressed bytes.
    fn ratio(self) -> u64 {
        match self {
            Self::None => ratio::STORED,
            Self::PackBits => ratio::RUNS,
            Self::Lzw => ratio::LZW,
            Self::Deflate => ratio::DEFLATE,
        }
    }

    /// Decompresses the first `size` bytes. The result may be longer, and callers ignore its rest. As in libtiff, data
    /// after the first `size` bytes are not decoded.
    pub fn decode(self, data: Cow<[u8]>, size: usize) -> Result<Cow<[u8]>, String> {
        check_decoded(data.len(), self.ratio(), size)?;
        let decoded: Cow<[u8]> = match self {
            Self::None => data,
            Self::PackBits => unpacked(&data, size).into(),
            Self::Lzw => lzw(&data, size)?.into(),
            Self::Deflate => inflated(&data, size)?.into(),
        };
        match decoded.len() {
            there if there < size => Err(format!("ends after {there} of {size} bytes")),
            _ => Ok(decoded),
        }
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
