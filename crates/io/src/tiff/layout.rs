//! Reads the layout of a picture: its size, the type of its numbers, and the location of its strips or tiles.

use ::tiff::tags::{CompressionMethod, PhotometricInterpretation, Predictor, SampleFormat, Tag};

use super::compression::supported;
use super::cure::Cure;
use super::directory::Directory;
use crate::limits::checked_points;

/// The layout of a picture.
pub struct Layout {
    pub rows: usize,
    pub cols: usize,
    pub sample: Sample,
    /// Number of values per pixel, including the alpha channel.
    pub samples: usize,
    /// Whether each of these values has separate chunks. The chunks of the first value precede those of the second.
    pub planar: bool,
    /// Index of the opacity channel, if there is one.
    pub alpha: Option<usize>,
    /// Grey numbers, which are not inverted even if 0 is white, as in GDAL; indices into a table of colours; or a mask.
    pub photometric: PhotometricInterpretation,
    pub predictor: Predictor,
    pub compression: CompressionMethod,
    /// Whether the bits of each byte are stored in reverse order.
    pub reversed: bool,
    /// Rows and columns of a chunk. The last strip has fewer rows; tiles are padded.
    pub chunk: [usize; 2],
    pub tiled: bool,
    chunks: Vec<Chunk>,
}

/// The location of a chunk's bytes.
#[derive(Clone, Copy)]
pub struct Chunk {
    pub offset: u64,
    pub length: u64,
}

/// The type of a picture's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Unsigned or signed integers, or floating-point numbers.
    pub format: SampleFormat,
    /// Number of bits, from 1 to 64.
    pub bits: usize,
}

impl Layout {
    pub fn read(directory: &Directory, cure: &Cure) -> Result<Self, String> {
        let needed = |tag, name: &str| {
            let value = directory.integer(tag)?.and_then(|value| usize::try_from(value).ok());
            value.ok_or_else(|| format!("is not a usable TIFF file: it lacks the field {name}"))
        };
        let or = |tag, value| Ok::<_, String>(directory.integer(tag)?.unwrap_or(value));
        let rows = needed(Tag::ImageLength, "ImageLength")?;
        let cols = needed(Tag::ImageWidth, "ImageWidth")?;
        checked_points(rows, cols)?;
        let samples = or(Tag::SamplesPerPixel, 1)? as usize;
        let alpha = match directory.integers(Tag::ExtraSamples)?.unwrap_or_default()[..] {
            // Associated or unassociated alpha.
            [.., 1 | 2] if samples > 1 => Some(samples - 1),
            _ => None,
        };
        let photometric = directory.integer(Tag::PhotometricInterpretation)?;
        match samples - usize::from(alpha.is_some()) {
            0 => return Err("is not a usable TIFF file: it has no band".into()),
            1 => {}
            bands => {
                return Err(format!(
                    "has {bands} bands, but only one can be read; choose one: {}",
                    cure.translate("-b 1")
                ));
            }
        }
        let photometric = match photometric {
            None | Some(0 | 1) => PhotometricInterpretation::BlackIsZero,
            Some(3) => PhotometricInterpretation::RGBPalette,
            Some(4) => PhotometricInterpretation::TransparencyMask,
            Some(other) => {
                return Err(format!(
                    "is a picture of colours (PhotometricInterpretation {other}), not of numbers"
                ));
            }
        };
        let compression = supported(or(Tag::Compression, 1)?, cure)?;
        let sample = Sample::read(directory, cure)?;
        let predictor = match or(Tag::Predictor, 1)? {
            // Other compressions have no predictor, and the field is ignored.
            _ if !matches!(compression, CompressionMethod::LZW | CompressionMethod::Deflate) => {
                Predictor::None
            }
            1 => Predictor::None,
            2 if sample.is_whole_bytes() => Predictor::Horizontal,
            3 if sample.format == SampleFormat::IEEEFP => Predictor::FloatingPoint,
            other => {
                let Sample { bits, .. } = sample;
                return Err(format!(
                    "has predictor {other} for numbers of {bits} bits, which is not read; convert \
                     it: {}",
                    cure.translate("-co COMPRESS=DEFLATE -co PREDICTOR=1")
                ));
            }
        };
        let reversed = match or(Tag::FillOrder, 1)? {
            1 => false,
            2 => true,
            other => {
                return Err(format!("is not a usable TIFF file: FillOrder {other} is not valid"));
            }
        };
        let planar = match or(Tag::PlanarConfiguration, 1)? {
            1 => false,
            2 => samples > 1,
            other => {
                return Err(format!(
                    "is not a usable TIFF file: PlanarConfiguration {other} is not valid"
                ));
            }
        };
        let tiled = directory.has(Tag::TileWidth);
        let chunk = match tiled {
            true => [needed(Tag::TileLength, "TileLength")?, needed(Tag::TileWidth, "TileWidth")?],
            // The field's default, 2^32 - 1, stands for all rows.
            false => {
                let all = u64::from(u32::MAX);
                [(or(Tag::RowsPerStrip, all)?.min(rows as u64)) as usize, cols]
            }
        };
        if chunk.contains(&0) {
            return Err("is not a usable TIFF file: it has strips or tiles of no size".into());
        }
        let mut layout = Self {
            rows,
            cols,
            sample,
            samples,
            planar,
            alpha,
            photometric,
            predictor,
            compression,
            reversed,
            chunk,
            tiled,
            chunks: Vec::new(),
        };
        layout.chunks = layout.chunks(directory)?;
        Ok(layout)
    }

    fn chunks(&self, directory: &Directory) -> Result<Vec<Chunk>, String> {
        let (offsets, lengths) = match self.tiled {
            true => (Tag::TileOffsets, Tag::TileByteCounts),
            false => (Tag::StripOffsets, Tag::StripByteCounts),
        };
        let lacks =
            |name: &str| format!("is not a usable TIFF file: it lacks the {name} of its data");
        let offsets = directory.integers(offsets)?.ok_or_else(|| lacks("offsets"))?;
        let lengths = match directory.integers(lengths)? {
            Some(lengths) => lengths,
            // Old writers omit the lengths of chunks, which then follow from the picture's size.
            None if self.compression == CompressionMethod::None => {
                let per_plane = self.chunks_down() * self.chunks_across();
                let length = |index| self.chunk_bytes((index % per_plane) / self.chunks_across());
                (0..offsets.len()).map(|index| length(index) as u64).collect()
            }
            None => return Err(lacks("sizes")),
        };
        let planes = if self.planar { self.samples } else { 1 };
        let needed = self.chunks_across().checked_mul(self.chunks_down());
        let needed = needed.and_then(|needed| needed.checked_mul(planes));
        if needed.is_none_or(|needed| needed > offsets.len().min(lengths.len())) {
            return Err("is not a usable TIFF file: it does not say where all its data lie".into());
        }
        let chunks = offsets.into_iter().zip(lengths);
        Ok(chunks.map(|(offset, length)| Chunk { offset, length }).collect())
    }

    pub fn chunks_across(&self) -> usize {
        self.cols.div_ceil(self.chunk[1])
    }

    pub fn chunks_down(&self) -> usize {
        self.rows.div_ceil(self.chunk[0])
    }

    /// Returns the chunk at a row and column of chunks, or `None` if it is not stored (a sparse file).
    pub fn chunk_at(&self, down: usize, across: usize, band: usize) -> Option<Chunk> {
        let plane = if self.planar { band } else { 0 };
        let index = (plane * self.chunks_down() + down) * self.chunks_across() + across;
        let chunk = self.chunks[index];
        (chunk.length > 0).then_some(chunk)
    }

    /// Returns the number of rows that are stored in each chunk of a row of chunks.
    pub fn stored_rows(&self, down: usize) -> usize {
        let [rows, _] = self.chunk;
        if self.tiled { rows } else { rows.min(self.rows - down * rows) }
    }

    /// Returns the number of values per pixel in a chunk.
    pub fn interleaved(&self) -> usize {
        if self.planar { 1 } else { self.samples }
    }

    /// Returns the number of bytes of a row of a chunk. If the number of bits is too large for a `usize`, it
    /// counts as `usize::MAX`.
    pub fn row_bytes(&self) -> usize {
        let numbers = self.chunk[1].saturating_mul(self.interleaved());
        numbers.saturating_mul(self.sample.bits).div_ceil(8)
    }

    /// Returns the number of bytes of a decompressed chunk of a row of chunks.
    pub fn chunk_bytes(&self, down: usize) -> usize {
        self.stored_rows(down).saturating_mul(self.row_bytes())
    }
}

impl Sample {
    fn read(directory: &Directory, cure: &Cure) -> Result<Self, String> {
        let same = |tag, default, name: &str| {
            let values = directory.integers(tag)?.unwrap_or_default();
            let first = values.first().copied().unwrap_or(default);
            if values.iter().any(|value| *value != first) {
                return Err(format!(
                    "has bands of different types ({name}); {}",
                    cure.translate("-b 1")
                ));
            }
            Ok(first)
        };
        let bits = same(Tag::BitsPerSample, 1, "BitsPerSample")?;
        let format = same(Tag::SampleFormat, 1, "SampleFormat")?;
        let (format, name, known) = match format {
            // The value 4 is "undefined", which libtiff and GDAL treat as unsigned. GDAL stores the bytes of 24-bit
            // numbers in an order of its own, whatever the byte order of the file.
            1 | 4 => (SampleFormat::Uint, "unsigned", matches!(bits, 1..=23 | 25..=32 | 64)),
            2 => (SampleFormat::Int, "signed", matches!(bits, 8 | 16 | 32 | 64)),
            3 => (SampleFormat::IEEEFP, "floating-point", matches!(bits, 16 | 32 | 64)),
            5 | 6 => {
                return Err(format!(
                    "holds complex numbers; this takes their real parts: {}",
                    cure.translate("-ot Float64")
                ));
            }
            other => {
                return Err(format!(
                    "is not a usable TIFF file: SampleFormat {other} is not valid"
                ));
            }
        };
        if !known {
            return Err(format!(
                "holds {name} numbers of {bits} bits, which are not read; convert them: {}",
                cure.translate("-ot Float64")
            ));
        }
        Ok(Self { format, bits: bits as usize })
    }

    /// Returns whether numbers fill whole bytes, and the number of bytes is a power of two.
    pub fn is_whole_bytes(self) -> bool {
        matches!(self.bits, 8 | 16 | 32 | 64)
    }

    /// Returns the number that the bits stand for.
    pub fn value(self, word: u64) -> f64 {
        match (self.format, self.bits) {
            (SampleFormat::Uint, _) => word as f64,
            (SampleFormat::Int, bits) => ((word << (64 - bits)) as i64 >> (64 - bits)) as f64,
            (_, 16) => half::f16::from_bits(word as u16).to_f64(),
            (_, 32) => f64::from(f32::from_bits(word as u32)),
            _ => f64::from_bits(word),
        }
    }
}
