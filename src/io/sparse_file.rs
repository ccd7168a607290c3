//! Writes sparse matrices as SciPy's `save_npz` does: an `.npz` archive that its `load_npz` reads.

use std::io::{self, Write};

use rawzip::{CompressionMethod, ZipArchiveWriter};

use super::npy::{NpyElement, header, write_npy};
use crate::pairwise::SparseRows;

/// Writes a sparse matrix, not compressed, for `scipy.sparse.load_npz`.
///
/// The archive has the arrays `indices` (int32), `indptr` (int32, or int64 from 2^31 entries on), `format` (the
/// bytes `csr`), `shape` (int64) and `data` (float32). The distance 0 from a source to itself is a
/// stored entry.
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
    let array = |writer: &mut dyn Write, shape: &[usize], values: &[i64]| {
        write_all::<i64>(writer, shape, values)
    };
    put("indices.npy", &|writer| {
        let indices: Vec<i32> = rows.indices.iter().map(|&index| index as i32).collect();
        write_all(writer, &[indices.len()], &indices)
    })?;
    put("indptr.npy", &|writer| {
        let shape = [rows.indptr.len()];
        let small: Option<Vec<i32>> =
            rows.indptr.iter().map(|&entry| i32::try_from(entry).ok()).collect();
        match small {
            Some(small) => write_all(writer, &shape, &small),
            None => {
                let large: Vec<_> = rows.indptr.iter().map(|&entry| entry as i64).collect();
                array(writer, &shape, &large)
            }
        }
    })?;
    put("format.npy", &|writer| {
        writer.write_all(&header("|S3", &[]))?;
        writer.write_all(b"csr")
    })?;
    put("shape.npy", &|writer| array(writer, &[2], &[rows.rows() as i64, rows.cols as i64]))?;
    put("data.npy", &|writer| write_all(writer, &[rows.data.len()], &rows.data))?;
    archive.finish().map(|_| ()).map_err(io::Error::other)
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
    use crate::pairwise::pairs_within;
    use crate::{Options, Spacing, Surface};

    #[test]
    fn the_archive_has_the_arrays_that_scipy_reads() {
        let surface = Surface::from_heights(5, 6, vec![0.0; 30], Spacing::square(1.0)).unwrap();
        let options = Options::default().with_radius(1.5);
        let (rows, _) = pairs_within(&surface, &[0, 14], &options).unwrap();
        let mut bytes = Vec::new();
        write_sparse_npz(&mut bytes, &rows).unwrap();
        let array = |name| npz::decode(&bytes, &[name]).unwrap();
        let wide = |values: &[usize]| values.iter().map(|&value| value as f64).collect::<Vec<_>>();
        assert_eq!(array("indptr").values, wide(&rows.indptr));
        assert_eq!(array("shape").values, [2.0, 30.0]);
        // Within the radius of the corner lie four points, and within the radius of the inner point nine. Both counts
        // include the point itself.
        assert_eq!(rows.indptr, [0, 4, 13]);
        let columns: Vec<_> = rows.indices.iter().map(|&column| f64::from(column)).collect();
        assert_eq!(array("indices").values, columns);
        let distances: Vec<_> = rows.data.iter().map(|&distance| f64::from(distance)).collect();
        assert_eq!(array("data").values, distances);
        let format = b"csr";
        assert!(bytes.windows(3).any(|window| window == format));
    }
}
