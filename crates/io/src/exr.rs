//! Decodes and encodes OpenEXR: geometry images (three channels are a position), heights and maps (one
//! channel). Where an alpha channel is 0 there is no surface.

use std::collections::HashSet;
use std::io::{self, Cursor, Seek, Write};

use ::exr::block::read as read_blocks;
use ::exr::block::reader::ChunksReader;
use ::exr::compression::Compression;
use ::exr::error::Error;
use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels,
    ReadLayers, Vec2, WritableImage, read,
};
use glam::DVec3;

use super::Grid;
use super::limits::{check_decoded, check_memory, checked_points, ratio};

/// The level of the full resolution, if there are smaller ones.
const LARGEST_LEVEL: Vec2<usize> = Vec2(0, 0);

/// The content of the channels.
pub(super) enum Pixels {
    Positions(Grid<DVec3>),
    Single(Grid<f64>),
}

/// Names of the channels that hold a position, as coordinates or as a geometry image.
const POSITION_CHANNELS: [[&str; 3]; 2] = [["X", "Y", "Z"], COLOURS];
const COLOURS: [&str; 3] = ["R", "G", "B"];

pub(super) fn decode(bytes: &[u8]) -> Result<Pixels, String> {
    let malformed = |error: Error| match error {
        Error::NotSupported(what) => format!("uses an EXR feature that is not supported: {what}"),
        other => format!("is not a usable EXR file: {other}"),
    };
    let meta = MetaData::read_from_buffered(bytes, false).map_err(malformed)?;
    check_headers(&meta.headers, bytes.len())?;
    check_blocks(bytes).map_err(malformed)?;
    let layer = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(malformed)?
        .layer_data;
    let (rows, cols) = (layer.size.height(), layer.size.width());
    let channels = &layer.channel_data.list;
    let find = |name: &str| channels.iter().find(|c| is_named(c, name));
    let alpha = find("A").or(find("alpha"));
    let covered = alpha.map(|alpha| coverage(alpha, cols)).transpose()?;
    let is_hole = |index: usize| covered.as_ref().is_some_and(|covered| !covered[index]);
    for names in POSITION_CHANNELS {
        let [Some(x), Some(y), Some(z)] = names.map(find) else { continue };
        // Renderers write a depth, or heights, as grey: three equal channels.
        if names == COLOURS && samples(x).eq(samples(y)) && samples(y).eq(samples(z)) {
            return Ok(Pixels::Single(heights(x, rows, cols, is_hole)));
        }
        let point = |(index, ((x, y), z))| match is_hole(index) {
            true => DVec3::NAN,
            false => DVec3::new(x, y, z),
        };
        let values = samples(x).zip(samples(y)).zip(samples(z)).enumerate().map(point).collect();
        return Ok(Pixels::Positions(Grid::new(rows, cols, values)));
    }
    let values: Vec<_> =
        channels.iter().filter(|&one| alpha.is_none_or(|alpha| alpha.name != one.name)).collect();
    match values[..] {
        [single] => Ok(Pixels::Single(heights(single, rows, cols, is_hole))),
        _ => {
            let names: Vec<_> = channels.iter().map(|channel| channel.name.to_string()).collect();
            Err(format!(
                "has channels {}; positions need X, Y, Z or R, G, B, and heights a single channel; A marks holes",
                names.join(", ")
            ))
        }
    }
}

fn is_named(channel: &AnyChannel<FlatSamples>, name: &str) -> bool {
    channel.name.to_string().eq_ignore_ascii_case(name)
}

fn heights(
    channel: &AnyChannel<FlatSamples>,
    rows: usize,
    cols: usize,
    is_hole: impl Fn(usize) -> bool,
) -> Grid<f64> {
    let height = |(index, value)| if is_hole(index) { f64::NAN } else { value };
    Grid::new(rows, cols, samples(channel).enumerate().map(height).collect())
}

/// Returns whether each pixel is covered. The values of a pixel that is covered in part are mixed with those of the
/// background, so they are refused.
fn coverage(alpha: &AnyChannel<FlatSamples>, cols: usize) -> Result<Vec<bool>, String> {
    let is_covered = |(index, alpha)| match alpha {
        0.0 => Ok(false),
        1.0 => Ok(true),
        part => Err(format!(
            "row {}, column {}: the alpha {part} is neither 0 (a hole) nor 1, so the values there are mixed with \
             those of the background; render without antialiasing, or leave the alpha channel out",
            index / cols,
            index % cols
        )),
    };
    samples(alpha).enumerate().map(is_covered).collect()
}

fn samples(channel: &AnyChannel<FlatSamples>) -> Box<dyn Iterator<Item = f64> + '_> {
    Box::new(channel.sample_data.values_as_f32().map(f64::from))
}

/// Checks the sizes and compressions of the layers before memory is allocated for pixels.
fn check_headers(headers: &[Header], file: usize) -> Result<(), String> {
    let mut all = 0usize;
    for header in headers {
        let ratio = match header.compression {
            Compression::Uncompressed => ratio::STORED,
            Compression::RLE => ratio::RUNS,
            Compression::ZIP1 | Compression::ZIP16 => ratio::DEFLATE,
            Compression::PXR24 => ratio::DEFLATED_24,
            Compression::PIZ => ratio::PIZ,
            // The B44 decoder of the crate `exr` panics if a block is too short. Its DWA decoder does not check the
            // sizes that blocks declare.
            lossy @ (Compression::B44
            | Compression::B44A
            | Compression::DWAA(_)
            | Compression::DWAB(_)) => {
                return Err(format!("has {lossy}, which loses digits; write it with ZIP or PIZ"));
            }
            _ => ratio::OTHER,
        };
        let points = checked_points(header.layer_size.height(), header.layer_size.width())?;
        let channels = &header.channels.list;
        if channels.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err("has subsampled channels; write them at full resolution".into());
        }
        let bytes: usize = channels.iter().map(|one| one.sample_type.bytes_per_sample()).sum();
        if bytes == 0 {
            return Err("has a layer without channels".into());
        }
        all = all.saturating_add(points.saturating_mul(bytes));
        check_decoded(file, ratio, all)?;
        // A position takes three numbers, in addition to the decoded data.
        check_memory::<[f64; 3]>(points.saturating_add(all / size_of::<[f64; 3]>()))?;
    }
    Ok(())
}

/// Checks that each block of the first layer's picture is present exactly once. The crate `exr` does not check the
/// table of offsets. If an entry leads to a block of another layer or level, that crate panics. If two entries lead to
/// the same block, the crate reads the missing block as zeros.
fn check_blocks(bytes: &[u8]) -> Result<(), Error> {
    let blocks = read_blocks(Cursor::new(bytes), false)?
        .filter_chunks(false, |_, tile, block| {
            block.layer == 0 && tile.level_index == LARGEST_LEVEL
        })?;
    let header = blocks.meta_data().headers.first().cloned();
    let header = header.ok_or(Error::Invalid("no layer".into()))?;
    let mut places = HashSet::new();
    for block in blocks {
        let block = block?;
        let place = match block.layer_index {
            0 => header.get_block_data_indices(&block.compressed_block)?,
            _ => return Err(Error::Invalid("a block of another layer".into())),
        };
        if place.level_index != LARGEST_LEVEL || !places.insert(place.tile_index) {
            return Err(Error::Invalid("a block in place of another".into()));
        }
    }
    Ok(())
}

/// Writes a map as one channel `Y` of float32.
pub(super) fn encode(
    writer: &mut (impl Write + Seek),
    rows: usize,
    cols: usize,
    values: &[f32],
) -> io::Result<()> {
    let channel = AnyChannel::new("Y", FlatSamples::F32(values.to_vec()));
    let channels = AnyChannels::sort(std::iter::once(channel).collect());
    let attributes = LayerAttributes::named("distance");
    let layer = Layer::new((cols, rows), attributes, Encoding::SMALL_LOSSLESS, channels);
    Image::from_layer(layer).write().to_buffered(writer).map_err(|error| match error {
        Error::Io(error) => error,
        other => io::Error::other(other),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn file(compression: Compression, channels: usize) -> Vec<u8> {
        let channel = |n: usize| {
            AnyChannel::new(format!("c{n}").as_str(), FlatSamples::F32(vec![1.0; 64 * 64]))
        };
        let channels = AnyChannels::sort((0..channels).map(channel).collect());
        let encoding = Encoding { compression, ..Encoding::SMALL_LOSSLESS };
        let layer = Layer::new((64, 64), LayerAttributes::named("heights"), encoding, channels);
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn compression_that_loses_digits_is_refused() {
        assert!(matches!(decode(&file(Compression::ZIP16, 1)), Ok(Pixels::Single(_))));
        for compression in
            [Compression::B44, Compression::B44A, Compression::DWAA(None), Compression::DWAB(None)]
        {
            let message = decode(&file(compression, 1)).err().unwrap();
            assert!(message.contains("loses digits"), "{message}");
        }
    }

    /// Encodes channels of 3 x 5 pixels.
    fn picture(channels: &[(&str, [f32; 15])]) -> Vec<u8> {
        let channel = |&(name, values): &(&str, [f32; 15])| {
            AnyChannel::new(name, FlatSamples::F32(values.to_vec()))
        };
        let channels = AnyChannels::sort(channels.iter().map(channel).collect());
        let attributes = LayerAttributes::named("positions");
        let layer = Layer::new((5, 3), attributes, Encoding::SMALL_LOSSLESS, channels);
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    proptest! {
        #[test]
        fn pixels_without_coverage_are_holes(
            covered in prop::array::uniform15(any::<bool>()),
            names in prop::sample::select(vec!["XYZ", "RGB", "xyz", "Y", "depth"]),
            alpha in prop::sample::select(vec!["A", "a", "Alpha"]),
        ) {
            let kept = covered.map(|covered| f32::from(u8::from(covered)));
            let values = |k: usize| std::array::from_fn(|at| kept[at] * (at + 100 * k) as f32);
            let mut channels: Vec<_> = match names.len() {
                3 => (0..3).map(|k| (&names[k..=k], values(k))).collect(),
                _ => vec![(names, values(0))],
            };
            channels.push((alpha, kept));
            let is_hole: Vec<bool> = match decode(&picture(&channels)).unwrap() {
                Pixels::Positions(grid) => grid.values.iter().map(|point| point.is_nan()).collect(),
                Pixels::Single(grid) => grid.values.iter().map(|height| height.is_nan()).collect(),
            };
            prop_assert_eq!(is_hole, covered.map(|covered| !covered));
        }
    }

    #[test]
    fn partial_coverage_is_refused() {
        let mut alpha = [1.0; 15];
        alpha[7] = 0.25;
        let ramp = std::array::from_fn(|at| at as f32);
        let message = decode(&picture(&[("Z", ramp), ("A", alpha)])).err().unwrap();
        assert!(message.contains("row 1, column 2: the alpha 0.25"), "{message}");
    }

    #[test]
    fn grey_is_one_height_at_each_pixel() {
        let ramp: [f32; 15] = std::array::from_fn(|at| at as f32);
        let grey = [("R", ramp), ("G", ramp), ("B", ramp)];
        let Ok(Pixels::Single(heights)) = decode(&picture(&grey)) else { panic!("grey") };
        assert_eq!(heights.values, ramp.map(f64::from));
        let positions = ["X", "Y", "Z"].map(|name| (name, ramp));
        assert!(matches!(decode(&picture(&positions)), Ok(Pixels::Positions(_))));
    }

    #[test]
    fn files_that_claim_more_than_they_hold_are_refused() {
        // 16384 x 16384 points instead of 64 x 64: the corner of both windows.
        let corner = [63i32, 63].map(i32::to_le_bytes).concat();
        let large = [16383i32, 16383].map(i32::to_le_bytes).concat();
        let mut bytes = file(Compression::ZIP16, 1);
        while let Some(at) = bytes.windows(8).position(|window| window == corner) {
            bytes[at..at + 8].copy_from_slice(&large);
        }
        let message = decode(&bytes).err().unwrap();
        assert!(message.contains("more than its compression can hold"), "{message}");
    }
}
