//! Measures the typical length of edges. The twin of `glsl/passes/typical_edge.comp`.

use geosweep_surface::constants::EDGE_LOOKS;
use geosweep_surface::{Chart, Direction, EdgeLengths, Real};

/// Returns the typical length of edges along rows and columns, in single precision, or 0 if there are none.
pub(crate) fn typical_edge<R: Real>(edges: &EdgeLengths<R>) -> f32 {
    let Chart { rows, cols } = edges.chart();
    let looks = EDGE_LOOKS as usize;
    let point = |look: usize, points: usize| {
        let texels = points.div_ceil(2);
        2 * (texels * (2 * look + 1) / (2 * looks))
    };
    let all = (0..looks * looks).flat_map(|look| {
        let (row, col) = (point(look / looks, rows), point(look % looks, cols));
        [Direction::East, Direction::North].map(|to| edges.length(row, col, to).wide() as f32)
    });
    let there = all.filter(|length| *length > 0.0 && *length < f32::FAR);
    let logarithms = there.map(|length| length.to_bits() >> 12);
    let (sum, count) = logarithms.fold((0u32, 0u32), |(sum, count), bits| (sum + bits, count + 1));
    sum.checked_div(count).map_or(0.0, |mean| f32::from_bits(mean << 12))
}
