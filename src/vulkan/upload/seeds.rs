//! Converts sources to the form in which shaders read them.

use crate::constants::WHOLE;
use crate::surface::{FAR, Seed, Tagged};
use crate::update::{Wavefront, tag_of};
use crate::vulkan::TexelChart;
pub(crate) use crate::vulkan::device::shaders::seed::SeedTexel;

/// Bytes of a source as `glsl/passes/sources.comp` reads it.
pub(crate) const SOURCE_BYTES: usize = 16;

/// Number of bytes that profiles count for a texel with seeds: all members of [`SeedTexel`] but `window`.
pub(crate) const SEED_BYTES: u64 = (size_of::<SeedTexel>() - size_of::<[i32; 2]>()) as u64;

/// Returns the curvatures of the fronts at seeds as fronts carry them, tagged like curvatures that come
/// through a whole triangle.
pub(crate) fn curvatures(seeds: &[Seed]) -> Vec<f32> {
    seeds.iter().map(|seed| (seed.curvature as f32).with_tag(tag_of(seed) | WHOLE as u8)).collect()
}

/// Groups seeds by texel, since one invocation writes each texel. `carried` is what the front of each seed
/// carries in addition to its time.
pub(crate) fn seed_texels(seeds: &[Seed], carried: &[f32], wavefront: Wavefront) -> Vec<SeedTexel> {
    let place = |seed: &Seed| TexelChart::texel_of(seed.row, seed.col);
    let start = |seed: &Seed| match wavefront {
        Wavefront::Curved => seed.start_of_curved(),
        _ => seed.time as f32,
    };
    let mut placed: Vec<_> = seeds
        .iter()
        .zip(carried)
        .map(|(seed, carried)| (place(seed), start(seed), *carried))
        .collect();
    placed.sort_by_key(|&((row, col, _), ..)| (row, col));
    let mut texels: Vec<SeedTexel> = Vec::new();
    for ((row, col, component), time, carried) in placed {
        let texel = [col as i32, row as i32];
        if texels.last().is_none_or(|last| last.texel != texel) {
            let (times, curvatures) = ([FAR as f32; 4], [0.0; 4]);
            texels.push(SeedTexel { texel, window: [0; 2], times, curvatures });
        }
        let last = texels.last_mut().expect("one was pushed above");
        if time < last.times[component] {
            last.times[component] = time;
            last.curvatures[component] = carried;
        }
    }
    texels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::update::{Curvature, Front, SEED};

    /// If the fronts differed, a front that arrives at the same time as a seed would replace the seed on a
    /// device, but not on the CPU.
    #[test]
    fn fronts_at_seeds_are_those_of_the_cpu() {
        for curvature in [0.0, -0.0, 0.5, Seed::AT_SOURCE] {
            let seed = Seed {
                row: 1,
                col: 2,
                time: 0.25,
                curvature,
                from: None,
                origin: None,
                exact: false,
                heading: geosweep_surface::Heading::Everywhere,
                source: 0,
            };
            let front = Front { time: 0.25, curvature: curvature as f32, whole: true };
            let of_cpu = Curvature::of(front, SEED).value();
            assert_eq!(curvatures(&[seed])[0].to_bits(), of_cpu.to_bits(), "{curvature}");
        }
    }

    #[test]
    fn seeds_that_share_a_texel_are_written_together() {
        let seed = |row, col, time| Seed {
            row,
            col,
            time,
            curvature: 1.0,
            from: None,
            origin: None,
            exact: false,
            heading: geosweep_surface::Heading::Everywhere,
            source: 0,
        };
        let seeds = [seed(3, 3, 1.0), seed(0, 0, 0.0), seed(2, 3, 2.0), seed(3, 3, 0.5)];
        let texels = seed_texels(&seeds, &curvatures(&seeds), Wavefront::Planar);
        assert_eq!(texels.len(), 2);
        assert_eq!((texels[0].texel, texels[0].times[0]), ([1, 1], 0.0));
        let far = FAR as f32;
        assert_eq!((texels[1].texel, texels[1].times), ([2, 2], [far, 2.0, far, 0.5]));
    }
}
