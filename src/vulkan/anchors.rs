//! The anchors of fronts over a floor plan, as shaders have them. The twin of `glsl/anchors.glsl` and
//! `glsl/anchor_number.glsl`.

use glam::DVec2;

use super::TexelChart;
use crate::constants::{ALIKE_AT_ANCHOR, BORDER, SOURCES_INSIDE};
use crate::surface::{EvenGrid, Real, Seed, Surface};

/// From here on numbers are those of sources inside cells.
const FIRST_INSIDE: usize = f32::NUMBERS / 2;

/// Bytes of the sources inside cells and of the metric where shaders find them.
pub(crate) const ANCHOR_BYTES: usize = (SOURCES_INSIDE as usize + 1) * size_of::<[f32; 4]>();

/// A floor plan, and the sources inside cells of its last map.
#[derive(Debug)]
pub(crate) struct Anchors {
    grid: EvenGrid,
    /// From a point's number to that of the point below it.
    points_in_row: usize,
    /// Column and row in the shaders' points, and time.
    inside: Vec<[f32; 4]>,
}

impl Anchors {
    /// If a surface is a floor plan, whose points can be numbered.
    pub(crate) fn of(surface: &Surface, texels: TexelChart) -> Option<Self> {
        let points_in_row = texels.edges_extent().width as usize;
        Some(Self { grid: surface.floor()?, points_in_row, inside: Vec::new() })
    }

    /// The first fundamental form: of rows, of both, of columns.
    pub(crate) fn metric(&self) -> [f32; 3] {
        self.grid.metric().map(|part| part as f32)
    }

    /// Forgets the sources of the last map.
    pub(crate) fn forget(&mut self) {
        self.inside.clear();
    }

    /// The numbers of the anchors of seeds, as fronts carry them; `None`, and nothing is remembered, if
    /// there is no room for so many sources inside cells.
    pub(crate) fn numbers(&mut self, seeds: &[Seed]) -> Option<Vec<f32>> {
        let before = self.inside.len();
        let numbers: Option<Vec<f32>> = seeds.iter().map(|seed| self.number(seed)).collect();
        if numbers.is_none() {
            self.inside.truncate(before);
        }
        numbers
    }

    fn number(&mut self, seed: &Seed) -> Option<f32> {
        let border = 2 * BORDER as usize;
        let Some(from) = seed.from else {
            let number = (seed.row + border) * self.points_in_row + seed.col + border;
            return Some(f32::of_number(number));
        };
        let ahead = self.grid.length(from - DVec2::new(seed.row as f64, seed.col as f64));
        let time = seed.time - ahead;
        let place = (from + f64::from(2 * BORDER)).as_vec2();
        let rounding = ALIKE_AT_ANCHOR * f64::from(f32::EPSILON) * ahead.max(seed.time.abs());
        let is_known = |&[col, row, start, _]: &[f32; 4]| {
            [row, col] == place.to_array() && (f64::from(start) - time).abs() <= rounding
        };
        // The seeds of a source follow one another.
        let number = match self.inside.iter().rposition(is_known) {
            Some(known) => known,
            None if self.inside.len() == SOURCES_INSIDE as usize => return None,
            None => {
                self.inside.push([place.y, place.x, time as f32, 0.0]);
                self.inside.len() - 1
            }
        };
        Some(f32::of_number(FIRST_INSIDE + number))
    }

    /// Writes sources and metric where shaders find them.
    pub(crate) fn write(&self, bytes: &mut [u8]) {
        let sources = bytemuck::cast_slice(&self.inside);
        bytes[..sources.len()].copy_from_slice(sources);
        let metric = self.metric();
        let metric = bytemuck::bytes_of(&metric);
        bytes[ANCHOR_BYTES - size_of::<[f32; 4]>()..][..metric.len()].copy_from_slice(metric);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Chart, Sources, Spacing};

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
        assert_eq!(anchors.inside.len(), 2);
        for (at, start) in [([6.5, 5.25], 0.0), ([3.5, 3.5], 0.5)] {
            let found = anchors.inside.iter().find(|inside| inside[..2] == at).unwrap();
            assert!((found[2] - start).abs() < 1e-6, "{found:?}");
        }
        for (seed, number) in seeds.iter().zip(numbers) {
            let own = (seed.row + 2) * 12 + seed.col + 2;
            let number = number.number();
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
        assert_eq!(anchors.inside.len(), 3);
        anchors.forget();
        assert!(anchors.numbers(&many[1..]).is_some());
    }
}
