//! Reads matrices of distances from files.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use crate::npy::{Header, shape_text};
use crate::{IoError, check_regular, extension};

/// The distances between n points.
#[derive(Clone, Debug, PartialEq)]
pub struct SquareMatrix {
    /// Number of points.
    pub points: usize,
    /// Distances, n x n, row-major.
    pub distances: Vec<f32>,
}

/// Reads a matrix of distances: an `.npy` array (n, n), or the part above the diagonal, (n (n - 1) / 2,), in
/// the form of SciPy's `squareform`. Memory is needed for the matrix only.
///
/// # Errors
/// If the file cannot be read or holds no such array, or memory does not suffice.
pub fn read_matrix(path: &Path) -> Result<SquareMatrix, IoError> {
    if extension(path) != "npy" {
        return Err(IoError::extension(path, "a matrix of distances", ".npy"));
    }
    let read_error = |source| IoError::Read { path: path.to_owned(), source };
    let content = |reason| IoError::content(path, reason);
    let (mut file, header, bytes) = open(path)?;
    let place = Place::of(&header).map_err(content)?;
    let points = place.points();

    let mut distances = Vec::new();
    let room = points.checked_mul(points).filter(|&n| distances.try_reserve_exact(n).is_ok());
    let room = room.ok_or_else(|| content(format!("{points} points have too many distances")))?;
    distances.resize(room, 0.0);
    let mut part = vec![0; header.dtype.bytes << 16];
    let mut numbers = 0..bytes / header.dtype.bytes;
    while !numbers.is_empty() {
        let part = &mut part[..numbers.len().min(1 << 16) * header.dtype.bytes];
        file.read_exact(part).map_err(read_error)?;
        for (value, number) in header.dtype.decode(part).into_iter().zip(&mut numbers) {
            place.put(&mut distances, number, value as f32);
        }
    }
    Ok(SquareMatrix { points, distances })
}

/// Opens an array, and returns a reader of its numbers, its header and the number of bytes of its numbers. The file
/// contains these bytes, so memory for them may be allocated.
fn open(path: &Path) -> Result<(BufReader<File>, Header, usize), IoError> {
    let read_error = |source| IoError::Read { path: path.to_owned(), source };
    let content = |reason| IoError::content(path, reason);
    let size = check_regular(path)?;
    let mut file = BufReader::new(File::open(path).map_err(read_error)?);
    let header = Header::read(&mut file).map_err(content)?;
    let after_header = file.stream_position().map_err(read_error)?;
    let bytes = header.check_size(size.saturating_sub(after_header)).map_err(content)?;
    Ok((file, header, bytes))
}

/// Returns whether a file is an `.npy` array that can be a matrix of distances and is unlikely to be anything
/// else: an array with one axis (an upper triangle), or a square floating-point array. The diagonal of a square
/// array must have only 0 and, for holes, +infinity, and its first row a positive value.
pub fn is_distance_matrix(path: &Path) -> bool {
    let is = || {
        let (mut file, header, _) = open(path).ok()?;
        let points = match header.shape[..] {
            [_] => return Some(true),
            [rows, cols] if rows == cols && rows > 0 && header.dtype.kind == b'f' => rows,
            _ => return None,
        };
        let size = header.dtype.bytes;
        let mut row = vec![0; points.checked_mul(size)?];
        file.read_exact(&mut row).ok()?;
        let first = header.dtype.decode(&row);
        let is_zero = |distance: f64| distance == 0.0 || distance == f64::INFINITY;
        let mut diagonal = is_zero(first[0]);
        for row_number in 1..points {
            // Skips from the end of row 0, or from the previous number on the diagonal.
            let skipped = if row_number == 1 { size } else { row.len() };
            file.seek_relative(i64::try_from(skipped).ok()?).ok()?;
            file.read_exact(&mut row[..size]).ok()?;
            diagonal &= is_zero(header.dtype.decode(&row[..size])[0]);
        }
        Some(diagonal && first.iter().any(|distance| *distance > 0.0))
    };
    extension(path) == "npy" && is().unwrap_or(false)
}

/// The positions of a file's numbers in the matrix.
enum Place {
    Square {
        points: usize,
        transposed: bool,
    },
    /// The part above the diagonal. `begins` holds the number at which each row begins.
    Condensed {
        begins: Vec<usize>,
    },
}

impl Place {
    fn of(header: &Header) -> Result<Self, String> {
        match header.shape[..] {
            [rows, cols] if rows == cols && rows > 0 => {
                Ok(Self::Square { points: rows, transposed: header.fortran_order })
            }
            [count] => {
                // n (n - 1) / 2 lies between (n - 1)^2 / 2 and n^2 / 2.
                let points = 1 + count.saturating_mul(2).isqrt();
                if points * (points - 1) / 2 != count {
                    return Err(format!(
                        "has {count} numbers, which is n (n - 1) / 2 for no number n of points"
                    ));
                }
                let begins = (0..points).scan(0, |next, row| {
                    let begin = *next;
                    *next += points - 1 - row;
                    Some(begin)
                });
                Ok(Self::Condensed { begins: begins.collect() })
            }
            _ => Err(format!(
                "is an array of shape {}; a matrix of distances is square, (n, n), or its upper \
                 triangle, (n (n - 1) / 2,)",
                shape_text(&header.shape)
            )),
        }
    }

    fn points(&self) -> usize {
        match self {
            Self::Square { points, .. } => *points,
            Self::Condensed { begins } => begins.len(),
        }
    }

    fn put(&self, distances: &mut [f32], number: usize, distance: f32) {
        match self {
            Self::Square { transposed: false, .. } => distances[number] = distance,
            Self::Square { points, .. } => {
                distances[number % points * points + number / points] = distance;
            }
            Self::Condensed { begins } => {
                let points = begins.len();
                let row = begins.partition_point(|&begin| begin <= number) - 1;
                let col = row + 1 + number - begins[row];
                distances[row * points + col] = distance;
                distances[col * points + row] = distance;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::npy;

    /// Writes a file of the given shape, with only `numbers` numbers.
    fn file(folder: &Path, shape: &[usize], numbers: usize) -> std::path::PathBuf {
        let path = folder.join("d.npy");
        let data = vec![0; numbers * size_of::<f32>()];
        std::fs::write(&path, [npy::header("<f4", shape), data].concat()).unwrap();
        path
    }

    #[test]
    fn shapes_that_the_file_does_not_fill_are_no_matrices() {
        let folder = tempfile::tempdir().unwrap();
        for side in [0, 3, 1 << 40, 1 << 61] {
            let path = file(folder.path(), &[side, side], 8);
            assert!(!is_distance_matrix(&path), "{side}");
            read_matrix(&path).unwrap_err();
        }
        // The header is longer than the missing number, so this fails if the bytes of the header count as data.
        let path = file(folder.path(), &[3, 3], 8);
        let message = read_matrix(&path).unwrap_err().to_string();
        assert!(message.contains("needs 36 bytes, 32 are there"), "{message}");
        assert_eq!(read_matrix(&file(folder.path(), &[3, 3], 9)).unwrap().points, 3);
    }
}
