//! Valid files to start from: those in `seeds/NAME/`, and what this version of the library writes.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::write::DeflateEncoder;
use geosweep::io::{MatrixFile, OutputFile, Provenance};
use rawzip::{CompressionMethod, ZipArchiveWriter};

use crate::bodies::UNFINISHED;

/// Returns the seeds of a body in the order of their names.
pub fn of(name: &str) -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if name == "checkpoint" {
        return vec![unfinished()];
    }
    let mut files = files(&root.join("tests/fuzz/seeds").join(name));
    if name == "tiff" {
        // These files were written by GDAL.
        let gdal = self::files(&root.join("tests/maps/gdal")).into_iter();
        files.extend(gdal.filter(|file| file.extension() == Some("tif".as_ref())));
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

/// Returns the checkpoint of a matrix of one row, a zero byte and the matrix. A checkpoint holds the library's version.
fn unfinished() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let output = OutputFile::new(&folder.path().join("d.npy")).unwrap();
    let mut matrix = MatrixFile::begin(output, UNFINISHED, Provenance::new()).unwrap();
    matrix.append(&[0.0, 1.0, 2.0, 3.0]).unwrap();
    matrix.pause().unwrap();
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    [read("d.npy.part.json"), vec![0], read("d.npy.part")].concat()
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
