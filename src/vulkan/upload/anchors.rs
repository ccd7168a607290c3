//! Gives shaders a number for each anchor of fronts over a floor plan. The twin of `glsl/update/anchors.glsl` and of
//! the numbers in `glsl/update/anchored.glsl`.

use crate::constants::{FIRST_INSIDE, SOURCES_INSIDE};
use crate::surface::{Seed, Surface};
use crate::update::{Anchor, InsideSources};
use crate::vulkan::TexelChart;

/// Size in bytes of the buffer that holds the sources inside cells and the metric.
pub(crate) const ANCHOR_BYTES: usize = (SOURCES_INSIDE as usize + 1) * size_of::<[f32; 4]>();

/// Floor plan with the sources inside cells of its last map.
#[derive(Debug)]
pub(crate) struct Anchors {
    /// Difference between the numbers of a point and of the point below it.
    points_in_row: usize,
    inside: InsideSources,
}

impl Anchors {
    /// Returns the anchors of a surface; `None` if it is not a floor plan whose points can be numbered.
    pub(crate) fn of(surface: &Surface, texels: TexelChart) -> Option<Self> {
        let points_in_row = texels.edges_extent().width as usize;
        Some(Self { points_in_row, inside: InsideSources::new(surface.floor()?) })
    }

    /// Returns the first fundamental form of a step to the next row and a step to the next column: the squared length
    /// of the first, the scalar product of both, and the squared length of the second.
    pub(crate) fn metric(&self) -> [f32; 3] {
        self.inside.grid().metric().map(|part| part as f32)
    }

    /// Forgets the sources of the last map.
    pub(crate) fn forget(&mut self) {
        self.inside.truncate(0);
    }

    /// Returns the numbers of the anchors of seeds, as fronts carry them. If there is no room for all sources
    /// inside cells, it returns `None` and forgets these sources.
    pub(crate) fn numbers(&mut self, seeds: &[Seed]) -> Option<Vec<f32>> {
        let before = self.inside.all().len();
        let numbers: Vec<_> = seeds.iter().map(|seed| self.number(seed)).collect();
        let has_room = self.inside.all().len() <= SOURCES_INSIDE as usize;
        if !has_room {
            self.inside.truncate(before);
        }
        has_room.then_some(numbers)
    }

    fn number(&mut self, seed: &Seed) -> f32 {
        let border = TexelChart::POINTS_BEFORE as usize;
        let number = match self.inside.number(seed) {
            Some(source) => FIRST_INSIDE as usize + source,
            None => (seed.row + border) * self.points_in_row + seed.col + border,
        };
        Anchor::new(number).value()
    }

    /// Writes the sources, each by column, row and time, and the metric to where shaders find them.
    pub(crate) fn write(&self, bytes: &mut [u8]) {
        let (sources, rest) = bytes.split_at_mut(SOURCES_INSIDE as usize * size_of::<[f32; 4]>());
        let places = sources.chunks_exact_mut(size_of::<[f32; 4]>());
        for (bytes, source) in places.zip(self.inside.all()) {
            let [row, col] =
                (source.place + f64::from(TexelChart::POINTS_BEFORE)).as_vec2().to_array();
            bytes.copy_from_slice(bytemuck::bytes_of(&[col, row, source.time as f32, 0.0]));
        }
        let metric = self.metric();
        let metric = bytemuck::bytes_of(&metric);
        rest[..metric.len()].copy_from_slice(metric);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Chart, Sources, Spacing};
    use glam::DVec2;

    fn floor() -> (Surface, Anchors) {
        let spacing = Spacing { dx: 1.0, dy: 2.0 };
        let surface = Surface::from_heights(9, 7, vec![0.0; 63], spacing).unwrap();
        let texels = TexelChart::new(Chart { rows: 9, cols: 7 }).unwrap();
        let anchors = Anchors::of(&surface, texels).unwrap();
        (surface, anchors)
    }

    #[test]
    fn all_seeds_of_a_source_have_one_number() {
        let (surface, mut anchors) = floor();
        let sources = Sources::point(3.25, 4.5).and_point(6.0, 2.0, 1.0).and_point(1.5, 1.5, 0.5);
        let seeds = sources.seeds(&surface).unwrap();
        let numbers = anchors.numbers(&seeds).unwrap();
        let mut bytes = vec![0; ANCHOR_BYTES];
        anchors.write(&mut bytes);
        let written: &[[f32; 4]] = bytemuck::cast_slice(&bytes);
        for (at, start) in [([6.5, 5.25], 0.0), ([3.5, 3.5], 0.5)] {
            let found = written[..2].iter().find(|source| source[..2] == at).unwrap();
            assert!((found[2] - start).abs() < 1e-6, "{found:?}");
        }
        assert_eq!(written[SOURCES_INSIDE as usize][..3], anchors.metric());
        for (seed, number) in seeds.iter().zip(numbers) {
            let own = (seed.row + 2) * 12 + seed.col + 2;
            let number = bytemuck::cast::<f32, Anchor<f32>>(number).number();
            assert!(if seed.from.is_some() { number >> 25 == 1 } else { number == own });
        }
    }

    #[test]
    fn too_many_sources_inside_cells_leave_those_that_were_there() {
        let (surface, mut anchors) = floor();
        let seeds = |count: usize| {
            let places = (0..count).map(|i| (0.1 + 7.0 * i as f64 / count as f64, 0.5));
            let sources = Sources::default();
            let sources = places.fold(sources, |all, (row, col)| all.and_point(row, col, 0.0));
            sources.seeds(&surface).unwrap()
        };
        assert!(anchors.numbers(&seeds(3)).is_some());
        let many: Vec<_> = (0..=SOURCES_INSIDE)
            .map(|i| {
                let from = DVec2::new(0.5, 0.5 + f64::from(i) / 8192.0);
                Seed { from: Some(from), ..seeds(1)[0] }
            })
            .collect();
        assert!(anchors.numbers(&many).is_none());
        assert_eq!(anchors.inside.all().len(), 3);
        anchors.forget();
        assert!(anchors.numbers(&many[1..]).is_some());
    }
}
