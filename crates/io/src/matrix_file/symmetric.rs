//! Replaces both distances between two points by their mean, for matrices larger than memory.

use std::io::{self, Read, Seek, SeekFrom, Write};

use super::MatrixLayout;

/// Bytes of the rows that are in memory at a time.
const BAND: usize = 16 << 20;
/// Number of columns between two calls of `go_on`.
const BETWEEN_QUESTIONS: usize = 256;

/// Writes the mean of a whole matrix and its transpose. Returns an error once `go_on` returns false.
pub(super) fn write_means(
    whole: &mut (impl Read + Seek),
    layout: MatrixLayout,
    writer: &mut impl Write,
    go_on: impl Fn() -> bool,
) -> io::Result<()> {
    let source = layout.of_rows();
    let points = layout.rows;
    let band = (BAND / (points * size_of::<f32>())).clamp(1, points);
    let mut rows = vec![0f32; band * points];
    let mut column = vec![0f32; band];
    let mut buffer = Vec::new();
    writer.write_all(&layout.header())?;
    for first in (0..points).step_by(band) {
        let band = band.min(points - first);
        let rows = &mut rows[..band * points];
        whole.seek(SeekFrom::Start(source.bytes_of_rows(first)))?;
        read_floats(whole, rows)?;
        for other in 0..points {
            if other % BETWEEN_QUESTIONS == 0 && !go_on() {
                return Err(io::Error::other("interrupted"));
            }
            let column = &mut column[..band];
            let start = source.bytes_of_rows(other) + (first * size_of::<f32>()) as u64;
            whole.seek(SeekFrom::Start(start))?;
            read_floats(whole, column)?;
            for (row, back) in column.iter().enumerate() {
                let there = &mut rows[row * points + other];
                *there = 0.5 * (*there + back);
            }
        }
        writer.write_all(layout.encode(first, rows, &mut buffer).map_err(io::Error::other)?)?;
    }
    Ok(())
}

fn read_floats(reader: &mut impl Read, numbers: &mut [f32]) -> io::Result<()> {
    reader.read_exact(bytemuck::cast_slice_mut(numbers))?;
    numbers.iter_mut().for_each(|number| *number = f32::from_bits(number.to_bits().to_le()));
    Ok(())
}
