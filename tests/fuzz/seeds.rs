//! Valid files to start from, in `seeds/NAME/`: small, and of every kind that the encoders used here write.

use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression as ExrCompression, Encoding, FlatSamples, Image,
    Layer, LayerAttributes, Vec2, WritableImage, f16,
};
use flate2::write::DeflateEncoder;
use geosweep::io::{MatrixFile, OutputFile, Provenance, write_npy};
use rawzip::{CompressionMethod, ZipArchiveWriter};
use tiff::encoder::{Compression, DeflateLevel, Predictor, TiffEncoder, colortype};
use tiff::tags::Tag;

use crate::bodies::UNFINISHED;

const ROWS: usize = 12;
const COLS: usize = 15;

/// Returns the seeds of a body in the order of their names.
pub fn of(name: &str) -> Vec<Vec<u8>> {
    let mut files = files(&folder(name));
    if name == "tiff" {
        // These files were written by GDAL.
        let gdal = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/maps/gdal");
        files.extend(
            self::files(&gdal).into_iter().filter(|file| file.extension() == Some("tif".as_ref())),
        );
    }
    files.iter().map(|file| fs::read(file).unwrap()).collect()
}

/// Returns the files of a folder in the order of their names.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder);
    let entries = entries.unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<_> = entries.map(|file| file.unwrap().path()).collect();
    files.sort();
    files
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/seeds").join(name)
}

/// Writes all seeds again.
pub fn write() {
    let put = |name: &str, file: &str, bytes: &[u8]| {
        fs::create_dir_all(folder(name)).unwrap();
        fs::write(folder(name).join(file), bytes).unwrap();
    };
    arrays(&put);
    archives(&put);
    put(
        "asc",
        "corner.asc",
        b"ncols 3\nnrows 2\nxllcorner 0\nyllcorner 5\ncellsize 2\n1 2 3\n4 5 6\n",
    );
    put(
        "asc",
        "center.asc",
        b"NCOLS 2\r\nNROWS 2\r\nXLLCENTER 1e3\r\nYLLCENTER -5\r\nDX 2\r\nDY 3\r\nNODATA_value -1\r\n1 -1\r\n0.5 2e1",
    );
    pictures(&put);
    tiffs(&put);
    exrs(&put);
    tables(&put);
    matrices(&put);
    // Small and large, flat and rough surfaces. Pseudo-random bytes that depend on these bytes follow them.
    for (index, bytes) in
        [&[5u8, 0, 7, 0, 1, 1][..], &[23, 0, 23, 0, 1], &[0; 8], b"geosweep"].iter().enumerate()
    {
        put("surface", &format!("{index}"), bytes);
    }
}

type Put<'a> = &'a dyn Fn(&str, &str, &[u8]);

/// Returns heights with steps, so that compression makes them smaller. Otherwise files store them
/// uncompressed.
fn heights() -> Vec<f32> {
    (0..ROWS * COLS).map(|index| (index / 7 % 5) as f32).collect()
}

fn npy(shape: &[usize], values: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_npy(&mut bytes, shape, values).unwrap();
    bytes
}

fn arrays(put: Put) {
    let heights = heights();
    put("npy", "heights.npy", &npy(&[ROWS, COLS], &heights));
    let positions: Vec<f32> = heights
        .iter()
        .enumerate()
        .flat_map(|(i, h)| [(i % COLS) as f32, (i / COLS) as f32, *h])
        .collect();
    put("npy", "positions.npy", &npy(&[ROWS, COLS, 3], &positions));
    put(
        "npy",
        "metric.npy",
        &npy(&[ROWS, COLS, 2, 2], &[1.0, 0.25, 0.25, 2.0].repeat(ROWS * COLS)),
    );
    put("npy", "curve.npy", &npy(&[3, 2], &[0.0, 1.0, 2.5, 3.0, 4.0, 5.0]));
    let nan = f32::NAN;
    let curves = [1.0, 2.0, 0.0, 0.0, 0.0, nan, nan, nan, nan, nan, 3.0, 4.0, 0.0, 0.0, 0.0];
    put("npy", "curves.npy", &npy(&[3, 5], &curves));
    put("npy", "points.npy", &npy(&[3], &[0.0, 5.0, 62.0]));
    let mask = format!("{{'descr': '|b1', 'fortran_order': True, 'shape': ({ROWS}, {COLS}), }}\n");
    let length = (mask.len() as u16).to_le_bytes();
    let bits = [1u8, 0, 1].repeat(ROWS * COLS / 3);
    put("npy", "mask.npy", &[b"\x93NUMPY\x01\0", &length[..], mask.as_bytes(), &bits].concat());
}

fn pictures(put: Put) {
    use png::{BitDepth, ColorType, Encoder};
    for (depth, name) in [
        (BitDepth::One, "1.png"),
        (BitDepth::Four, "4.png"),
        (BitDepth::Eight, "8.png"),
        (BitDepth::Sixteen, "16.png"),
    ] {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, COLS as u32, ROWS as u32);
        encoder.set_depth(depth);
        encoder.set_color(ColorType::Grayscale);
        encoder.add_text_chunk("Title".into(), "heights".into()).unwrap();
        encoder.add_ztxt_chunk("Comment".into(), "flat ".repeat(20)).unwrap();
        let row = (COLS * depth as usize).div_ceil(8);
        let data: Vec<u8> = (0..row * ROWS).map(|index| (37 * index) as u8).collect();
        encoder.write_header().unwrap().write_image_data(&data).unwrap();
        put("png", name, &bytes);
    }
    // Colours are refused, but the chunks before them are read.
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(ColorType::Indexed);
    encoder.set_palette(&[0, 0, 0, 255, 255, 255][..]);
    encoder.set_trns(&[0, 255][..]);
    encoder.write_header().unwrap().write_image_data(&[0, 1, 1, 0]).unwrap();
    put("png", "indexed.png", &bytes);
}

/// Writes archives of one array and of two, as NumPy writes them but without its extra fields.
fn archives(put: Put) {
    let mut array = Vec::new();
    write_npy(&mut array, &[ROWS, COLS], &heights()).unwrap();
    put("npz", "stored.npz", &archive(&[("arr_0.npy", &array)], CompressionMethod::STORE));
    let two = [("mask.npy", &array[..]), ("heights.npy", &array[..])];
    put("npz", "deflated.npz", &archive(&two, CompressionMethod::DEFLATE));
}

/// Returns a ZIP archive of some files.
pub fn archive(files: &[(&str, &[u8])], method: CompressionMethod) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut archive = ZipArchiveWriter::new(&mut bytes);
    for (name, content) in files {
        let (mut entry, config) =
            archive.new_file(name).compression_method(method).start().unwrap();
        let descriptor = if method == CompressionMethod::STORE {
            let mut writer = config.wrap(&mut entry);
            writer.write_all(content).unwrap();
            writer.finish().unwrap().1
        } else {
            let encoder = DeflateEncoder::new(&mut entry, flate2::Compression::default());
            let mut writer = config.wrap(encoder);
            writer.write_all(content).unwrap();
            let (encoder, descriptor) = writer.finish().unwrap();
            encoder.finish().unwrap();
            descriptor
        };
        entry.finish(descriptor).unwrap();
    }
    archive.finish().unwrap();
    bytes
}

fn tiffs(put: Put) {
    for (compression, name) in [
        (Compression::Uncompressed, "plain.tif"),
        (Compression::Lzw, "lzw.tif"),
        (Compression::Deflate(DeflateLevel::Fast), "deflate.tif"),
        (Compression::Packbits, "packbits.tif"),
    ] {
        let mut file = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut file).unwrap().with_compression(compression);
        let mut image =
            encoder.new_image::<colortype::Gray32Float>(COLS as u32, ROWS as u32).unwrap();
        image.rows_per_strip(2).unwrap();
        let tags = image.encoder();
        tags.write_tag(Tag::GdalNodata, "-9999").unwrap();
        tags.write_tag(Tag::ModelPixelScaleTag, &[30.0, 20.0, 0.0][..]).unwrap();
        tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 5e5, 4e6, 0.0][..]).unwrap();
        let keys = [1u16, 1, 0, 3, 1024, 0, 1, 1, 3072, 0, 1, 32616, 3076, 0, 1, 9001];
        tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).unwrap();
        image.write_data(&heights()).unwrap();
        put("tiff", name, &file.into_inner());
    }
    let mut file = Cursor::new(Vec::new());
    let small: Vec<i16> = (0..(ROWS * COLS) as i16).collect();
    let encoder = TiffEncoder::new(&mut file).unwrap().with_compression(Compression::Lzw);
    let mut encoder = encoder.with_predictor(Predictor::Horizontal);
    encoder.write_image::<colortype::GrayI16>(COLS as u32, ROWS as u32, &small).unwrap();
    put("tiff", "predicted.tif", &file.into_inner());
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new_big(&mut file).unwrap();
    let bytes: Vec<u8> = (0..ROWS * COLS).map(|index| index as u8).collect();
    encoder.write_image::<colortype::Gray8>(COLS as u32, ROWS as u32, &bytes).unwrap();
    put("tiff", "big.tif", &file.into_inner());
    put("tiff", "tiled.tif", &tiled());
}

/// Returns a picture in one tile of 16 x 16 bytes, which the encoder of the crate `tiff` cannot write.
fn tiled() -> Vec<u8> {
    const ENTRIES: [(u16, u32); 10] = [
        (256, COLS as u32),
        (257, ROWS as u32),
        (258, 8),
        (259, 1),
        (262, 1),
        (277, 1),
        (322, 16),
        (323, 16),
        (324, 8 + 2 + 12 * 10 + 4),
        (325, 256),
    ];
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend((ENTRIES.len() as u16).to_le_bytes());
    for (tag, value) in ENTRIES {
        bytes.extend(tag.to_le_bytes());
        // The entry has one LONG.
        bytes.extend(4u16.to_le_bytes());
        bytes.extend(1u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    bytes.extend(0..=255u8);
    bytes
}

fn exrs(put: Put) {
    let file = |compression, blocks, samples: &[(&str, FlatSamples)]| {
        let channels =
            samples.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone()));
        let channels = AnyChannels::sort(channels.collect());
        let encoding = Encoding { compression, blocks, ..Encoding::SMALL_LOSSLESS };
        let layer = Layer::new((COLS, ROWS), LayerAttributes::named("heights"), encoding, channels);
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    };
    let single = FlatSamples::F32(heights());
    for (compression, name) in [
        (ExrCompression::Uncompressed, "plain.exr"),
        (ExrCompression::RLE, "rle.exr"),
        (ExrCompression::ZIP1, "zip.exr"),
        (ExrCompression::ZIP16, "zips.exr"),
        (ExrCompression::PIZ, "piz.exr"),
        (ExrCompression::PXR24, "pxr24.exr"),
    ] {
        put("exr", name, &file(compression, Blocks::ScanLines, &[("Y", single.clone())]));
    }
    let half = FlatSamples::F16(heights().into_iter().map(f16::from_f32).collect());
    let tiles = Blocks::Tiles(Vec2(4, 4));
    put("exr", "tiles.exr", &file(ExrCompression::PIZ, tiles, &[("Y", half.clone())]));
    let mixed =
        [("X", single), ("Y", half), ("Z", FlatSamples::U32((0..(ROWS * COLS) as u32).collect()))];
    put("exr", "positions.exr", &file(ExrCompression::ZIP16, Blocks::ScanLines, &mixed));
}

fn tables(put: Put) {
    put("table", "points.csv", b"1,2\n3;4 # a comment\n\n5\t6\n");
    put("table", "named.csv", b"curve,kind,level,closed,row,col,x\n0,contour,1,1,1,2,0.5\n0,contour,1,1,3,4,0.5\n1,contour,2,0,5,6,0.5\n");
    put(
        "table",
        "excel.csv",
        b"\xef\xbb\xbfsep=;\r\nrow;col;t0;name\r\n1,5;2;0,5;\"a;b\"\r\n3;4;1;\r\n",
    );
    put("table", "r.csv", b"\"\",\"x\",\"y\",\"start\"\n\"1\",101.5,48,2\n\"2\",104,45.25,3\n");
    put("table", "places.geojson", br#"{"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"EPSG:32616"}},"features":[{"type":"Feature","properties":{"t0":1.5,"name":"a"},"geometry":{"type":"Point","coordinates":[102,47]}},{"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[[[101,49],[105,49],[103,45],[101,49]]]}}]}"#);
    put("table", "fields.tsv", b"x\ty\tcol\trow\n\t\t2.5\t1\n8\t9\t-4\t3\n");
}

fn matrices(put: Put) {
    let between = |a: usize, b: usize| a.abs_diff(b) as f32;
    let square: Vec<f32> = (0..25).map(|index| between(index / 5, index % 5)).collect();
    put("matrix", "square.npy", &npy(&[5, 5], &square));
    let upper: Vec<f32> = (0..5).flat_map(|a| (a + 1..5).map(move |b| between(a, b))).collect();
    put("matrix", "upper.npy", &npy(&[10], &upper));

    let folder = tempfile::tempdir().unwrap();
    let output = OutputFile::new(&folder.path().join("d.npy")).unwrap();
    let mut matrix = MatrixFile::begin(output, UNFINISHED, Provenance::new()).unwrap();
    matrix.append(&[0.0, 1.0, 2.0, 3.0]).unwrap();
    matrix.pause().unwrap();
    let mut bytes = fs::read(folder.path().join("d.npy.part.json")).unwrap();
    bytes.push(0);
    bytes.write_all(&fs::read(folder.path().join("d.npy.part")).unwrap()).unwrap();
    put("checkpoint", "one-row", &bytes);
}
