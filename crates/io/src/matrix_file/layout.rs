//! Defines the layout of a matrix in its file.

use std::path::Path;

use half::f16;
use half::slice::HalfFloatSliceExt;

use crate::IoError;
use crate::npy;

/// The type of the numbers of a matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Element {
    /// Four bytes, as the solvers compute.
    #[default]
    Float32,
    /// Two bytes: eleven significant bits, a relative error below 5e-4, and 65504 at most.
    Float16,
}

impl Element {
    /// Returns the number of bytes of a number.
    pub fn bytes(self) -> usize {
        match self {
            Self::Float32 => 4,
            Self::Float16 => 2,
        }
    }

    /// Returns NumPy's name of the type.
    pub fn name(self) -> &'static str {
        match self {
            Self::Float32 => "float32",
            Self::Float16 => "float16",
        }
    }

    fn descr(self) -> &'static str {
        match self {
            Self::Float32 => "<f4",
            Self::Float16 => "<f2",
        }
    }
}

impl std::fmt::Display for Element {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// The size of a matrix and the part of it that is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MatrixLayout {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// Type of the numbers.
    pub element: Element,
    /// Whether only the part above the diagonal of a square matrix is stored, row after row: an array (n (n -
    /// 1) / 2,), the condensed form of SciPy's `squareform`.
    pub upper: bool,
    /// Whether both distances between two points of a square matrix are replaced by their mean. The matrix is
    /// first written whole in float32, and that file exists until the end.
    pub symmetric: bool,
}

impl MatrixLayout {
    /// Returns the peak number of bytes that the files of the matrix take on disk.
    pub fn bytes(&self) -> u64 {
        let finished = self.bytes_of_rows(self.rows);
        if self.symmetric { finished + self.of_rows().bytes() } else { finished }
    }

    /// Returns the layout of the unfinished file, in which rows are collected.
    pub(super) fn of_rows(&self) -> Self {
        let Self { rows, cols, .. } = *self;
        if self.symmetric {
            Self { rows, cols, element: Element::Float32, upper: false, symmetric: false }
        } else {
            *self
        }
    }

    /// Returns the shape of the array.
    pub fn shape(&self) -> Vec<usize> {
        if self.upper { vec![self.numbers_of_rows(self.rows)] } else { vec![self.rows, self.cols] }
    }

    pub(super) fn header(&self) -> Vec<u8> {
        npy::header(self.element.descr(), &self.shape())
    }

    /// Returns the size of the file in bytes after `rows` rows.
    pub(super) fn bytes_of_rows(&self, rows: usize) -> u64 {
        (self.header().len() + self.numbers_of_rows(rows) * self.element.bytes()) as u64
    }

    /// Returns the number of values in the first `rows` rows.
    fn numbers_of_rows(&self, rows: usize) -> usize {
        let whole = rows * self.cols;
        // Row r leaves out its first r + 1 numbers.
        if self.upper { whole - rows * (rows + 1) / 2 } else { whole }
    }

    /// Returns the bytes of whole rows, beginning with the row number `first`. They are written to `buffer`
    /// unless they equal the bytes of `distances`.
    pub(super) fn encode<'a>(
        &self,
        first: usize,
        distances: &'a [f32],
        buffer: &'a mut Vec<u8>,
    ) -> Result<&'a [u8], String> {
        let as_they_are = cfg!(target_endian = "little") && self.element == Element::Float32;
        if as_they_are && !self.upper {
            return Ok(bytemuck::cast_slice(distances));
        }
        buffer.clear();
        for (row, distances) in (first..).zip(distances.chunks_exact(self.cols)) {
            let kept = if self.upper { &distances[row + 1..] } else { distances };
            self.element.encode(kept, buffer)?;
        }
        Ok(buffer)
    }

    /// Checks that the disk has `needed` bytes left.
    pub(super) fn check_space(&self, path: &Path, needed: u64) -> Result<(), IoError> {
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        // If the system does not report the free space, a full disk causes an error when rows are written.
        let Ok(free) = fs4::available_space(folder.unwrap_or(Path::new("."))) else {
            return Ok(());
        };
        if needed <= free {
            return Ok(());
        }
        let shape = npy::shape_text(&self.shape());
        let [needed, free] = [needed, free].map(|bytes| bytes.div_ceil(1 << 20));
        let reason = format!(
            "an array {shape} of {} needs {needed} MiB, and {free} MiB are free; choose another \
             disk, fewer rows or smaller numbers",
            self.element.name()
        );
        Err(IoError::write(path, reason))
    }
}

impl Element {
    fn encode(self, distances: &[f32], bytes: &mut Vec<u8>) -> Result<(), String> {
        match self {
            Self::Float32 => bytes.extend(distances.iter().flat_map(|d| d.to_le_bytes())),
            Self::Float16 => {
                let mut halves = vec![f16::ZERO; distances.len()];
                halves.convert_from_f32_slice(distances);
                let lost = |(half, distance): (&f16, &f32)| {
                    (half.is_infinite() && distance.is_finite()).then_some(*distance)
                };
                if let Some(distance) = halves.iter().zip(distances).find_map(lost) {
                    return Err(format!(
                        "the distance {distance} is more than float16 holds, {}; write float32, or \
                         choose a larger unit of length",
                        f16::MAX
                    ));
                }
                bytes.extend(halves.iter().flat_map(|half| half.to_le_bytes()));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_of_what_is_written() {
        for (upper, element) in [(false, Element::Float32), (true, Element::Float16)] {
            let layout = MatrixLayout { rows: 7, cols: 7, element, upper, symmetric: false };
            let mut bytes = layout.header();
            for row in 0..7 {
                assert_eq!(bytes.len() as u64, layout.bytes_of_rows(row), "{layout:?}");
                bytes.extend_from_slice(layout.encode(row, &[1.5; 7], &mut Vec::new()).unwrap());
            }
            assert_eq!(bytes.len() as u64, layout.bytes());
        }
        let upper = MatrixLayout {
            rows: 4,
            cols: 4,
            element: Element::Float32,
            upper: true,
            symmetric: false,
        };
        assert_eq!(upper.shape(), [6]);
    }

    #[test]
    fn distances_beyond_half_precision_are_refused() {
        let layout = MatrixLayout {
            rows: 1,
            cols: 3,
            element: Element::Float16,
            upper: false,
            symmetric: false,
        };
        let mut buffer = Vec::new();
        let bytes = layout.encode(0, &[0.0, 65504.0, f32::INFINITY], &mut buffer).unwrap();
        assert_eq!(bytes, [0, 0, 0xff, 0x7b, 0, 0x7c]);
        let message = layout.encode(0, &[0.0, 65536.0, 1.0], &mut buffer).unwrap_err();
        assert!(message.contains("65536") && message.contains("float32"), "{message}");
    }
}
