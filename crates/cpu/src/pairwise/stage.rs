//! Writes maps in SIMD lanes to rows of a matrix.

use super::kernel::{LANES, Lanes};
use crate::Instructions;
use crate::rotated::stream::stream;
use crate::rotated::transpose::{Turned, transpose};
use geosweep_surface::Chart;
use geosweep_surface::lanes::Loop;

/// A buffer that rearranges grid rows of several maps into parts of the matrix's rows before they are written to
/// memory.
pub(super) struct Stage {
    /// A span of each row of the matrix. Spans are a stride apart.
    rows: Vec<Lanes>,
    /// Capacity of the buffer in grid rows.
    band: usize,
}

impl Stage {
    pub(super) fn new(chart: Chart) -> Self {
        let band = band(chart);
        // With a stride that is a power of two, the spans would compete for few cache lines.
        Self { rows: vec![Lanes::all(0.0); band * chart.cols + LANES], band }
    }

    pub(super) fn bytes(chart: Chart) -> usize {
        (band(chart) * chart.cols + LANES) * size_of::<Lanes>()
    }

    /// Writes the distances of each map that has a row in `into`. Resets the points to unreached.
    pub(super) fn store(
        &mut self,
        chart: Chart,
        points: &mut [Lanes],
        instructions: Instructions,
        into: &mut [Option<&mut [f32]>],
    ) {
        let staged: &mut [f32] = bytemuck::cast_slice_mut(&mut self.rows);
        let to_stride = staged.len() / LANES;
        for first in (0..chart.rows).step_by(self.band) {
            let rows = first..chart.rows.min(first + self.band);
            for row in rows.clone() {
                let line = chart.row_of_mut(points, row);
                let block = Turned {
                    from: 0,
                    from_stride: LANES,
                    to: chart.index(row - first, 0),
                    to_stride,
                    rows: chart.cols,
                    cols: into.len(),
                };
                transpose(bytemuck::cast_slice_mut::<_, f32>(line), staged, block, instructions);
                // The line is cleared while it is in the cache.
                instructions.run(Clear(line));
            }
            let (start, count) = (chart.index(first, 0), rows.len() * chart.cols);
            let rows = into.iter_mut().zip(staged.chunks_exact(to_stride));
            stream(rows.filter_map(|(row, staged)| {
                Some((&staged[..count], &mut row.as_mut()?[start..][..count]))
            }));
        }
    }
}

/// Returns the number of rows in a band. A band is large, so that it is written to memory in long spans with few
/// partial cache lines, but still fits a cache.
fn band(chart: Chart) -> usize {
    (2048 / chart.cols).clamp(1, chart.rows)
}

struct Clear<'a>(&'a mut [Lanes]);

impl Loop for Clear<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.fill(Lanes::UNREACHED);
    }
}
