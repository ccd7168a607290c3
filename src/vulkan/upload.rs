//! Points and sources in the form in which the shaders read them.

use std::ops::Range;

use bytemuck::{NoUninit, bytes_of};
use glam::DVec3;

use super::TexelChart;
use crate::surface::{FAR, Geometry, MetricTensor, Real, Seed, Surface};

/// Writes the points of some rows into the upload buffer, as edges_from_*.comp read them:
/// slowness 0 marks a hole. Positions and heights are taken relative to `origin`.
pub(crate) fn write_points(
    surface: &Surface,
    rows: Range<usize>,
    origin: DVec3,
    buffer: &mut [u8],
) {
    let chart = surface.chart();
    let indices = chart.index(rows.start, 0)..chart.index(rows.end, 0);
    let slowness = |index: usize| match (surface.present()[index], surface.slowness()) {
        (false, _) => 0.0,
        (true, None) => 1.0,
        (true, Some(slowness)) => slowness[index] as f32,
    };
    match surface.geometry() {
        Geometry::Positions(positions) => write(buffer, indices, |index| {
            let point = (positions[index] - origin).as_vec3();
            [point.x, point.y, point.z, slowness(index)]
        }),
        Geometry::Heights { heights, .. } => {
            write(buffer, indices, |index| [(heights[index] - origin.z) as f32, slowness(index)])
        }
        Geometry::Metric(metric) => write(buffer, indices, |index| {
            let MetricTensor { rr, rc, cc } = metric[index];
            [rr as f32, rc as f32, cc as f32, slowness(index)]
        }),
    }
}

fn write<T: NoUninit>(buffer: &mut [u8], indices: Range<usize>, point: impl Fn(usize) -> T) {
    for (bytes, index) in buffer.chunks_exact_mut(size_of::<T>()).zip(indices) {
        bytes.copy_from_slice(bytes_of(&point(index)));
    }
}

/// A place near the surface: single precision keeps more digits of positions relative to it.
pub(crate) fn origin(surface: &Surface) -> DVec3 {
    let chart = surface.chart();
    let present = (0..chart.points()).filter(|&index| surface.present()[index]);
    let position = |index| {
        let (row, col) = chart.position(index);
        surface.position(row, col)
    };
    let (low, high) = present
        .filter_map(position)
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), position| {
            (low.min(position), high.max(position))
        });
    if low.is_finite() { 0.5 * (low + high) } else { DVec3::ZERO }
}

/// The sources in one texel, as seed.comp reads them.
#[derive(Clone, Copy, Debug, PartialEq, NoUninit)]
#[repr(C)]
pub(crate) struct SeedTexel {
    /// Column and row of the texel, the image's border included.
    pub(crate) texel: [i32; 2],
    unused: [i32; 2],
    /// Arrival times of its points.
    pub(crate) times: [f32; 4],
    /// Curvatures of their fronts.
    pub(crate) curvatures: [f32; 4],
}

/// Groups seeds by texel, since each texel is written by one invocation.
pub(crate) fn seed_texels(seeds: &[Seed]) -> Vec<SeedTexel> {
    let mut placed: Vec<_> =
        seeds.iter().map(|seed| (TexelChart::texel_of(seed.row, seed.col), seed)).collect();
    placed.sort_by_key(|&((row, col, _), _)| (row, col));
    let mut texels: Vec<SeedTexel> = Vec::new();
    for ((row, col, component), seed) in placed {
        let texel = [col as i32, row as i32];
        if texels.last().is_none_or(|last| last.texel != texel) {
            let (times, curvatures) = ([FAR as f32; 4], [0.0; 4]);
            texels.push(SeedTexel { texel, unused: [0; 2], times, curvatures });
        }
        let last = texels.last_mut().expect("one was pushed above");
        let time = seed.time as f32;
        if time < last.times[component] {
            last.times[component] = time;
            last.curvatures[component] = (seed.curvature as f32).with_tag(0);
        }
    }
    texels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_that_share_a_texel_are_written_together() {
        let seed = |row, col, time| Seed { row, col, time, curvature: 1.0 };
        let seeds = [seed(3, 3, 1.0), seed(0, 0, 0.0), seed(2, 3, 2.0), seed(3, 3, 0.5)];
        let texels = seed_texels(&seeds);
        assert_eq!(texels.len(), 2);
        assert_eq!((texels[0].texel, texels[0].times[0]), ([1, 1], 0.0));
        let far = FAR as f32;
        assert_eq!((texels[1].texel, texels[1].times), ([2, 2], [far, 2.0, far, 0.5]));
    }
}
