//! A matrix of distances from its file.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use crate::io::npy::{Header, shape_text};
use crate::io::{IoError, check_regular, extension};

/// The distances between n points.
#[derive(Clone, Debug, PartialEq)]
pub struct SquareMatrix {
    /// Number of points.
    pub points: usize,
    /// n x n distances, row-major.
    pub distances: Vec<f32>,
}

/// Reads a matrix of distances: an `.npy` array (n, n), or what lies above the diagonal,
/// (n (n - 1) / 2,) as SciPy's `squareform` has it. Memory is needed for the matrix alone.
///
/// # Errors
/// If the file cannot be read or holds no such array, or memory does not suffice.
pub fn read_matrix(path: &Path) -> Result<SquareMatrix, IoError> {
    if extension(path) != "npy" {
        return Err(IoError::extension(path, "a matrix of distances", ".npy"));
    }
    let size = check_regular(path)?;
    let read_error = |source| IoError::Read { path: path.to_owned(), source };
    let content = |reason| IoError::content(path, reason);
    let mut file = BufReader::new(File::open(path).map_err(read_error)?);
    let header = Header::read(&mut file).map_err(content)?;
    let bytes = header.check_size(size).map_err(content)?;
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

/// Which distances the numbers of a file are.
enum Place {
    Square { points: usize, transposed: bool },
    /// Above the diagonal, with the number at which each row begins.
    Condensed { begins: Vec<usize> },
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
