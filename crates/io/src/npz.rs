//! Decodes NumPy's `.npz` files: ZIP archives of `.npy` arrays, as `np.savez` and `np.savez_compressed` write
//! them.

use std::io::Read;

use flate2::bufread::DeflateDecoder;
use rawzip::{CompressionMethod, ZipArchive};

use super::limits::{check_decoded, check_memory, ratio};
use super::npy::NpyArray;

const EXTENSION: &str = ".npy";

/// Decodes one array of the archive: the only one, or among several the one whose name comes first in
/// `names`.
pub(super) fn decode(bytes: &[u8], names: &[&str]) -> Result<NpyArray, String> {
    let malformed = |error: rawzip::Error| format!("is not a usable .npz file: {error}");
    let archive = ZipArchive::from_slice(bytes).map_err(malformed)?;
    let mut arrays = Vec::new();
    let mut entries = archive.entries();
    while let Some(entry) = entries.next_entry().map_err(malformed)? {
        let path = String::from_utf8_lossy(entry.file_path().as_ref()).into_owned();
        if let Some(name) = path.strip_suffix(EXTENSION) {
            let (method, size) = (entry.compression_method(), entry.uncompressed_size_hint());
            arrays.push((name.to_owned(), method, size, entry.wayfinder()));
        }
    }
    let named = |wanted: &&str| arrays.iter().position(|(name, ..)| name == wanted);
    let chosen = match arrays.len() {
        0 => return Err("holds no array; write one with np.savez".into()),
        1 => 0,
        count => names.iter().find_map(named).ok_or_else(|| {
            let there: Vec<_> = arrays.iter().take(8).map(|(name, ..)| &name[..]).collect();
            let more = if count > there.len() { ", ..." } else { "" };
            format!(
                "holds {count} arrays ({}{more}); keep only one of them, or give the array to be read the name {}",
                there.join(", "),
                names.join(" or ")
            )
        })?,
    };
    let (name, method, size, wayfinder) = &arrays[chosen];
    let entry = archive.get_entry(*wayfinder).map_err(malformed)?;
    let size = usize::try_from(*size).map_err(|_| "holds an array too large for this machine")?;
    let damaged = |error: std::io::Error| format!("its array {name} is damaged: {error}");
    let mut array = Vec::new();
    let data = entry.data();
    match *method {
        CompressionMethod::STORE => {
            check_decoded(data.len(), ratio::STORED, size)?;
            check_memory::<u8>(size)?;
            entry.verifying_reader(data).read_to_end(&mut array).map_err(damaged)?;
        }
        CompressionMethod::DEFLATE => {
            check_decoded(data.len(), ratio::DEFLATE, size)?;
            check_memory::<u8>(size)?;
            // At most one byte more than the archive declares is read, however much the stream holds. If that
            // byte is there, the verifying reader reports the array as damaged.
            let stream = DeflateDecoder::new(data).take(size as u64 + 1);
            entry.verifying_reader(stream).read_to_end(&mut array).map_err(damaged)?;
        }
        other => {
            return Err(format!(
                "its array {name} is compressed by {other:?}, which is not supported; write the file with \
                 np.savez_compressed"
            ));
        }
    }
    NpyArray::decode(&array).map_err(|reason| format!("its array {name} {reason}"))
}
