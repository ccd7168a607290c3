//! Numbers of sources inside cells, which are anchors but not grid points.

use glam::DVec2;

use crate::constants::ALIKE_AT_ANCHOR;
use crate::{EvenGrid, Seed};

/// The sources inside cells of a map over a floor plan, numbered from 0.
#[derive(Clone, Debug)]
pub struct InsideSources {
    grid: EvenGrid,
    known: Vec<InsideSource>,
}

/// A source inside a cell: its row and column, and its time.
#[derive(Clone, Copy, Debug)]
pub struct InsideSource {
    pub place: DVec2,
    pub time: f64,
}

impl InsideSources {
    #[doc(hidden)]
    pub fn new(grid: EvenGrid) -> Self {
        // Sources are few: with this capacity, further maps allocate nothing.
        Self { grid, known: Vec::with_capacity(16) }
    }

    #[doc(hidden)]
    pub fn grid(&self) -> EvenGrid {
        self.grid
    }

    /// Returns all sources, ordered by number.
    #[doc(hidden)]
    pub fn all(&self) -> &[InsideSource] {
        &self.known
    }

    /// Forgets all sources but the first `count`.
    #[doc(hidden)]
    pub fn truncate(&mut self, count: usize) {
        self.known.truncate(count);
    }

    /// Returns the number of the source from which a seed comes, or `None` if the source is the seed's own
    /// point. All seeds of one source get the same number.
    #[doc(hidden)]
    pub fn number(&mut self, seed: &Seed) -> Option<usize> {
        let place = seed.from?;
        let ahead = self.grid.length(place - seed.place());
        let time = seed.time - ahead;
        let rounding = ALIKE_AT_ANCHOR * f64::from(f32::EPSILON) * ahead.max(seed.time.abs());
        let is_same =
            |known: &InsideSource| known.place == place && (known.time - time).abs() <= rounding;
        // The seeds of a source follow one another.
        let known = self.known.iter().rposition(is_same);
        Some(known.unwrap_or_else(|| {
            self.known.push(InsideSource { place, time });
            self.known.len() - 1
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Sources, Spacing, Surface, with_diagonals};

    #[test]
    fn all_seeds_of_a_source_have_its_number() {
        let spacing = Spacing { dx: 0.3, dy: 1.7 };
        let plane = Surface::from_heights(70, 90, vec![0.0; 6300], spacing).unwrap();
        let mut inside = InsideSources::new(plane.floor().unwrap());
        // The second source starts later at the same place as the first.
        let places = [(50.826, 44.414, 0.7), (50.826, 44.414, 900.1), (3.1, 7.0, -2.6)];
        for (number, (row, col, initial)) in places.into_iter().enumerate() {
            let from = Sources::default().and_point(row, col, initial);
            let seeds = with_diagonals(&plane, from.seeds(&plane).unwrap());
            assert!(seeds.len() > 40);
            assert!(seeds.iter().all(|seed| inside.number(seed) == Some(number)));
            let InsideSource { place, time } = inside.all()[number];
            assert_eq!(place, DVec2::new(row, col));
            approx::assert_relative_eq!(time, initial, max_relative = 1e-12);
        }
        assert_eq!(inside.number(&Seed::at_source(3, 7, 0.0)), None);
    }
}
