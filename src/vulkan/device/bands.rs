//! Divides a grid into bands of rows, in which its values pass between the program's memory and the device.

use std::ops::Range;

use crate::constants::SEAM_HALO;
use crate::surface::Chart;

/// Largest number of bytes of a band of rows. Edges are uploaded, points are measured and distances are read back band
/// by band.
const BAND_BYTES: usize = 16 << 20;
/// Smallest size of the upload buffer in bytes: room for the sources on a small grid.
const LEAST_UPLOAD_BYTES: usize = 64 << 10;
/// Largest number of bytes for sources in memory that only the device accesses.
const MOST_SOURCE_BYTES: usize = 1 << 20;
/// Largest number of bytes of a point: position and slowness, or its edges.
pub(crate) const POINT_BYTES: usize = 16;

/// Returns the largest number of bytes of a band that is transferred between the program's memory and the device. It is
/// 4 times the number of the grid's points, so that the buffers take a sixth of the memory of a map, but at most
/// `BAND_BYTES`. On small grids it is at least 256 KiB, since another submission would cost more time than the memory
/// is worth.
pub(in crate::vulkan) fn transfer_bytes(chart: Chart) -> usize {
    (4 * chart.points()).clamp(256 << 10, BAND_BYTES)
}

/// Returns the largest number of bytes of a band of distances if one band is copied while the host reads another. It
/// divides a map into two bands, or into more on grids of more than 2048 x 2048 points. Small maps stay in one band,
/// since a second submission would cost more time than it saves.
pub(in crate::vulkan) fn staged_bytes(chart: Chart) -> usize {
    (transfer_bytes(chart) / 2).max(256 << 10)
}

/// Returns the largest number of bytes of a band of a host's points: 6 times the number of the grid's points, which
/// gives three bands, but at least 4 MiB and at most `BAND_BYTES`. Points are measured band by band in each frame in
/// which they change. Grids of up to 512 x 512 points are measured at once: two more passes would cost too much time
/// for the memory that they save.
pub(crate) fn frame_bytes(chart: Chart) -> usize {
    (6 * chart.points()).clamp(4 << 20, BAND_BYTES)
}

/// Returns the number of rows of a band of at most `most` bytes. It is even, so that each texel lies in one band, and
/// at least two.
fn band_rows(chart: Chart, point_bytes: usize, most: usize) -> usize {
    let rows = most / (chart.cols * point_bytes);
    (rows / 2 * 2).clamp(2, chart.rows.next_multiple_of(2))
}

/// Returns the grid's rows in bands of at most `most` bytes.
pub(crate) fn bands(
    chart: Chart,
    point_bytes: usize,
    most: usize,
) -> impl Iterator<Item = Range<usize>> {
    let step = band_rows(chart, point_bytes, most);
    (0..chart.rows).step_by(step).map(move |row| row..(row + step).min(chart.rows))
}

/// Returns the rows whose points are needed to measure the edges of a band. The grid has `beyond` rows of points before
/// its first row and after its last row; the rows before the first row have negative numbers. The length of an edge to
/// the north also depends on how the surface bends at both of its ends. Where a grid line ends, the bend is taken from
/// the next two points inwards.
pub(crate) fn rows_around(band: &Range<usize>, chart: Chart, beyond: usize) -> Range<isize> {
    let [start, end, rows, beyond] =
        [band.start, band.end, chart.rows, beyond].map(|count| count as isize);
    (start - BEFORE as isize).max(-beyond)..(end + AFTER as isize).min(rows + beyond)
}

const BEFORE: usize = SEAM_HALO as usize;
const AFTER: usize = 2;
/// Largest number of rows around a band.
const HALO: usize = BEFORE + AFTER;

/// Returns the number of bytes that a headless surface reserves for sources. `is_staged` tells whether shaders read
/// them from the device's own memory.
pub(in crate::vulkan) fn source_bytes(chart: Chart, is_staged: bool) -> usize {
    let bytes = upload_bytes(chart, transfer_bytes(chart));
    if is_staged { bytes.min(MOST_SOURCE_BYTES) } else { bytes }
}

/// Returns the number of bytes of the distances in a band of at most `most` bytes.
pub(in crate::vulkan) fn distance_bytes(chart: Chart, most: usize) -> usize {
    band_rows(chart, size_of::<f32>(), most) * chart.cols * size_of::<f32>()
}

/// Returns the size in bytes of the upload buffer, which holds points in bands of at most `most` bytes, or sources.
pub(crate) fn upload_bytes(chart: Chart, most: usize) -> usize {
    let points = (band_rows(chart, POINT_BYTES, most) + HALO) * chart.cols * POINT_BYTES;
    points.max(LEAST_UPLOAD_BYTES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_cover_every_row_once() {
        let chart = Chart { rows: 4099, cols: 3000 };
        let bands: Vec<_> = bands(chart, POINT_BYTES, BAND_BYTES).collect();
        assert!(bands.len() > 2);
        assert!(bands.iter().all(|band| band.start.is_multiple_of(2)));
        assert_eq!(bands.iter().map(|band| band.len()).sum::<usize>(), chart.rows);
        assert!(bands.windows(2).all(|pair| pair[0].end == pair[1].start));
    }
}
