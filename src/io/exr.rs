//! OpenEXR: geometry images (three channels are a position), heights and maps (one channel).

use std::io::{self, Cursor, Seek, Write};

use ::exr::error::Error;
use ::exr::meta::MetaData;
use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels,
    ReadLayers, WritableImage, read,
};
use glam::DVec3;

use super::{Grid, checked_points};

/// What the channels are.
pub(super) enum Pixels {
    Positions(Grid<DVec3>),
    Single(Grid<f64>),
}

/// Names of channels that hold a position, as a geometry image or as coordinates.
const POSITION_CHANNELS: [[&str; 3]; 2] = [["X", "Y", "Z"], ["R", "G", "B"]];

pub(super) fn decode(bytes: &[u8]) -> Result<Pixels, String> {
    let malformed = |error: Error| match error {
        Error::NotSupported(what) => format!("uses an EXR feature that is not supported: {what}"),
        other => format!("is no usable EXR file: {other}"),
    };
    check_sizes(bytes).map_err(malformed)??;
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
    if channels.iter().any(|channel| channel.sampling.x() != 1 || channel.sampling.y() != 1) {
        return Err("has subsampled channels; write them at full resolution".into());
    }
    let find = |name: &str| {
        channels.iter().find(|c| c.name.to_string().eq_ignore_ascii_case(name)).map(samples)
    };
    for names in POSITION_CHANNELS {
        if let [Some(x), Some(y), Some(z)] = names.map(find) {
            let values = x.zip(y).zip(z).map(|((x, y), z)| DVec3::new(x, y, z)).collect();
            return Ok(Pixels::Positions(Grid { rows, cols, values }));
        }
    }
    match &channels[..] {
        [single] => Ok(Pixels::Single(Grid { rows, cols, values: samples(single).collect() })),
        several => {
            let names: Vec<_> = several.iter().map(|channel| channel.name.to_string()).collect();
            Err(format!(
                "has channels {}; positions need X, Y, Z or R, G, B, and heights a single channel",
                names.join(", ")
            ))
        }
    }
}

fn samples(channel: &AnyChannel<FlatSamples>) -> Box<dyn Iterator<Item = f64> + '_> {
    Box::new(channel.sample_data.values_as_f32().map(f64::from))
}

/// Looks at every layer's size before any pixel is given memory.
fn check_sizes(bytes: &[u8]) -> Result<Result<(), String>, Error> {
    let meta = MetaData::read_from_buffered(bytes, false)?;
    let check = |size: ::exr::math::Vec2<usize>| checked_points(size.height(), size.width());
    Ok(meta.headers.iter().try_for_each(|header| check(header.layer_size).map(drop)))
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
