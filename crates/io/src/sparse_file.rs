//! Writes sparse matrices as SciPy's `save_npz` does: an `.npz` archive that its `load_npz` reads.

use std::io::{self, Write};

use rawzip::{CompressionMethod, ZipArchiveWriter};

use super::npy::{NpyElement, header, write_npy};
use geosweep_cpu::SparseRows;

/// Writes a sparse matrix, not compressed, for `scipy.sparse.load_npz`.
///
/// The archive has the arrays `indices` and `indptr` (both int32, or both int64 if a number of either does not fit
/// into 32 bits), `format` (the bytes `csr`), `shape` (int64) and `data` (float32). The distance 0 from a source to
/// itself is a stored entry.
///
/// # Errors
/// The errors of the writer.
pub fn write_sparse_npz(writer: &mut impl Write, rows: &SparseRows) -> io::Result<()> {
    let mut archive = ZipArchiveWriter::new(writer);
    let mut put = |name: &str, write: &dyn Fn(&mut dyn Write) -> io::Result<()>| {
        let failed = io::Error::other;
        let file = archive.new_file(name).compression_method(CompressionMethod::STORE);
        let (mut entry, config) = file.start().map_err(failed)?;
        let mut data = config.wrap(&mut entry);
        write(&mut data)?;
        let (_, descriptor) = data.finish().map_err(failed)?;
        entry.finish(descriptor).map(|_| ()).map_err(failed)
    };
    let indices = || rows.indices.iter().map(|&column| i64::from(column));
    let indptr = || rows.indptr.iter().map(|&entry| entry as i64);
    // SciPy wants one type for both.
    let are_small = indices().chain(indptr()).all(|number| i32::try_from(number).is_ok());
    put("indices.npy", &|writer| write_integers(writer, indices(), are_small))?;
    put("indptr.npy", &|writer| write_integers(writer, indptr(), are_small))?;
    put("format.npy", &|writer| {
        writer.write_all(&header("|S3", &[]))?;
        writer.write_all(b"csr")
    })?;
    let shape = [rows.rows() as i64, rows.cols as i64];
    put("shape.npy", &|writer| write_all(writer, &[2], &shape))?;
    put("data.npy", &|writer| write_all(writer, &[rows.data.len()], &rows.data))?;
    archive.finish().map(|_| ()).map_err(io::Error::other)
}

/// Writes integers as int32 if they `are_small`, else as int64.
fn write_integers(
    writer: &mut dyn Write,
    numbers: impl Iterator<Item = i64>,
    are_small: bool,
) -> io::Result<()> {
    if are_small {
        let numbers: Vec<i32> = numbers.map(|number| number as i32).collect();
        write_all(writer, &[numbers.len()], &numbers)
    } else {
        let numbers: Vec<i64> = numbers.collect();
        write_all(writer, &[numbers.len()], &numbers)
    }
}

fn write_all<T: NpyElement>(
    mut writer: &mut dyn Write,
    shape: &[usize],
    values: &[T],
) -> io::Result<()> {
    write_npy(&mut writer, shape, values)
}

#[cfg(test)]
mod tests {
    use super::super::npz;
    use super::*;

    #[test]
    fn the_archive_has_the_arrays_that_scipy_reads() {
        let rows = SparseRows {
            cols: 30,
            indptr: vec![0, 2, 5],
            indices: vec![0, 1, 8, 14, 20],
            data: vec![0.0, 1.0, 1.0, 0.0, 1.0],
        };
        let mut bytes = Vec::new();
        write_sparse_npz(&mut bytes, &rows).unwrap();
        let array = |name| npz::decode(&bytes, &[name]).unwrap().values;
        assert_eq!(array("indptr"), [0.0, 2.0, 5.0]);
        assert_eq!(array("shape"), [2.0, 30.0]);
        assert_eq!(array("indices"), [0.0, 1.0, 8.0, 14.0, 20.0]);
        assert_eq!(array("data"), [0.0, 1.0, 1.0, 0.0, 1.0]);
        assert!(bytes.windows(3).any(|window| window == b"csr"));
    }

    #[test]
    fn indices_and_counts_have_one_type() {
        let rows = |column: u32| SparseRows {
            cols: column as usize + 1,
            indptr: vec![0, 1],
            indices: vec![column],
            data: vec![1.0],
        };
        // The columns of a grid of more than 2^31 points do not fit, but the counts of the entries would.
        let (most, beyond) = (i32::MAX as u32, i32::MAX as u32 + 1);
        for (column, types) in [(most, [i32::DESCR; 2]), (beyond, [i64::DESCR; 2])] {
            let mut bytes = Vec::new();
            write_sparse_npz(&mut bytes, &rows(column)).unwrap();
            let file = |name| npz::decode(&bytes, &[name]).unwrap();
            assert_eq!(file("indices").values, [f64::from(column)]);
            assert_eq!(file("indptr").values, [0.0, 1.0]);
            let text = String::from_utf8_lossy(&bytes);
            let descriptions = text.split("'descr': '").skip(1);
            let found: Vec<_> = descriptions.map(|text| &text[..3]).collect();
            assert_eq!(found[..2], types, "column {column}");
        }
    }
}
