//! Knows the sources of a map, so that an output for other sources is refused.

use super::inputs::{PointSource, SourceInput};
use super::surface::FrameSurface;
use crate::vulkan::grid_images::INLINE_SOURCES;

/// Sources of a map, as far as the host knows them. Recording allocates nothing, so the room is fixed.
#[derive(Debug)]
pub(super) struct MapSources {
    known: Known,
    /// Hashes of the sources in the program's memory, sorted and without repetition, and their number.
    hashes: Box<[u64; INLINE_SOURCES]>,
    count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Known {
    /// The hashes are those of all sources.
    All,
    Place(Place),
    /// Too many sources, or sources of several recordings, some of them in buffers.
    Nothing,
}

/// Place of sources in a buffer of the surface, whose contents the host does not know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    number: usize,
    offset: u64,
    /// Number of replacements of the buffer.
    changes: u32,
}

/// Sources of a recording.
#[derive(Clone, Copy, Debug)]
pub(super) enum Given<'a> {
    Inline(&'a [PointSource]),
    Place(Place),
}

impl<'a> Given<'a> {
    /// Describes sources that fit the surface.
    pub(super) fn new(sources: SourceInput<'a>, surface: &FrameSurface) -> Self {
        match sources {
            SourceInput::Inline(sources) => Self::Inline(sources),
            SourceInput::Buffer(_) | SourceInput::BufferAt { .. } => {
                let (number, offset) = sources.buffer().unwrap_or_default();
                let changes = surface.sets.sources[number].changes;
                Self::Place(Place { number, offset, changes })
            }
        }
    }
}

impl MapSources {
    pub(super) fn new() -> Self {
        Self { known: Known::Nothing, hashes: Box::new([0; INLINE_SOURCES]), count: 0 }
    }

    /// Takes the sources of a new map.
    pub(super) fn set(&mut self, given: Given) {
        (self.known, self.count) = (Known::All, 0);
        self.add(given);
    }

    /// Adds sources to those of the map.
    pub(super) fn add(&mut self, given: Given) {
        let is_empty = self.known == Known::All && self.count == 0;
        self.known = match (self.known, given) {
            (known, Given::Inline([])) => known,
            (Known::All, Given::Inline(sources)) => self.insert(sources),
            (_, Given::Place(place)) if is_empty || self.known == Known::Place(place) => {
                Known::Place(place)
            }
            _ => Known::Nothing,
        };
    }

    fn insert(&mut self, sources: &[PointSource]) -> Known {
        let sorted = self.count;
        for hash in sources.iter().map(hash) {
            if self.hashes[..sorted].binary_search(&hash).is_ok() {
                continue;
            }
            let Some(free) = self.hashes.get_mut(self.count) else { return Known::Nothing };
            *free = hash;
            self.count += 1;
        }
        self.count = sort(&mut self.hashes[..self.count]);
        Known::All
    }

    /// Returns whether these may be the sources of the map.
    pub(super) fn may_be(&self, given: Given) -> bool {
        match (self.known, given) {
            (Known::All, Given::Inline(sources)) => {
                let mut hashes = [0; INLINE_SOURCES];
                let Some(of) = hashes.get_mut(..sources.len()) else { return true };
                of.iter_mut().zip(sources).for_each(|(to, source)| *to = hash(source));
                let count = sort(of);
                hashes[..count] == self.hashes[..self.count]
            }
            (Known::Place(of), Given::Place(place)) => of == place,
            _ => true,
        }
    }
}

/// Sorts hashes, and moves each to the front once. Returns the number of these.
fn sort(hashes: &mut [u64]) -> usize {
    hashes.sort_unstable();
    let mut count = 0;
    for at in 0..hashes.len() {
        if count == 0 || hashes[at] != hashes[count - 1] {
            hashes[count] = hashes[at];
            count += 1;
        }
    }
    count
}

/// Returns a hash of a source's place and time. Outputs do not read the curvature.
fn hash(source: &PointSource) -> u64 {
    // Adding 0 makes 0 of -0.
    let words = [source.row, source.col, source.time].map(|value| (value + 0.0).to_bits());
    words.into_iter().fold(0x9E37_79B9_7F4A_7C15, |hash, word| {
        let mixed = (hash ^ u64::from(word)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (mixed ^ (mixed >> 31)).wrapping_mul(0x94D0_49BB_1331_11EB)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(parts: &[Given]) -> MapSources {
        let mut all = MapSources::new();
        all.set(parts[0]);
        parts[1..].iter().for_each(|&part| all.add(part));
        all
    }

    #[test]
    fn sources_are_the_same_in_any_order_and_however_they_were_added() {
        use Given::Inline;
        let later = |time, at| PointSource { time, ..at };
        let [a, b, c] = [
            PointSource::at(0.0, 4.5),
            later(2.0, PointSource::at(3.0, 1.0)),
            PointSource::at(7.0, 7.0),
        ];
        let minus = PointSource::at(-0.0, 4.5);
        for parts in [
            [Inline(&[a, b, c]), Inline(&[])],
            [Inline(&[c, a]), Inline(&[b])],
            [Inline(&[c, a]), Inline(&[a, b, c])],
            [Inline(&[]), Inline(&[b, c, b, minus])],
        ] {
            let all = of(&parts);
            for same in [&[a, b, c][..], &[c, b, minus], &[a, a, c, b]] {
                assert!(all.may_be(Inline(same)), "{parts:?} {same:?}");
            }
            let others: [&[PointSource]; 5] = [
                &[],
                &[a, b],
                &[a, later(2.5, b), c],
                &[PointSource::at(4.5, 0.0), b, c],
                &[a, b, c, later(1.0, a)],
            ];
            for others in others {
                assert!(!all.may_be(Inline(others)), "{parts:?} {others:?}");
            }
        }
        let many: Vec<_> = (0..INLINE_SOURCES).map(|at| PointSource::at(1.0, at as f32)).collect();
        let full = of(&[Inline(&many)]);
        assert!(full.may_be(Inline(&many)) && !full.may_be(Inline(&many[1..])));
        let more = of(&[Inline(&many), Inline(&[a])]);
        assert!(more.may_be(Inline(&many)) && more.may_be(Inline(&[a])), "too many to know");
    }

    #[test]
    fn the_contents_of_buffers_are_not_known() {
        let place = |number, offset, changes| Given::Place(Place { number, offset, changes });
        let array = [PointSource::at(1.0, 2.0)];
        let buffer = of(&[place(0, 16, 1), place(0, 16, 1), Given::Inline(&[])]);
        assert!(buffer.may_be(place(0, 16, 1)) && buffer.may_be(Given::Inline(&array)));
        for other in [place(1, 16, 1), place(0, 0, 1), place(0, 16, 2)] {
            assert!(!buffer.may_be(other), "{other:?}");
        }
        let mixed = of(&[place(0, 16, 1), Given::Inline(&array)]);
        assert!(mixed.may_be(Given::Inline(&[])) && mixed.may_be(place(2, 0, 0)));
        assert!(!of(&[Given::Inline(&array)]).may_be(Given::Inline(&[])));
    }
}
