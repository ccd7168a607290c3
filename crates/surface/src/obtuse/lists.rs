//! Lists the obtuse triangles of a surface and their points.

use std::ops::Range;
use std::sync::OnceLock;

use super::cells::MarkedCells;

/// The obtuse triangles of a surface. They are computed on first use; `None` in the lock means that the
/// surface has no such triangle.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObtuseTriangles {
    pub(super) found: OnceLock<Option<Found>>,
    /// The cells to search, if they are known.
    pub(super) marked: Option<MarkedCells>,
}

impl ObtuseTriangles {
    pub(crate) fn none() -> Self {
        Self { found: OnceLock::from(None), marked: None }
    }

    /// Returns the list, not yet computed, of obtuse triangles that lie in marked cells only.
    pub(crate) fn within(marked: MarkedCells) -> Self {
        Self { found: OnceLock::new(), marked: Some(marked) }
    }

    /// Returns the number of bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let marks = self.marked.as_ref().map_or(0, |cells| cells.marks.len());
        marks
            + self.found.get().and_then(Option::as_ref).map_or(0, |found| {
                let numbers: usize =
                    found.lines.iter().map(|lines| lines.starts.len() + lines.places.len()).sum();
                found.bits.len() + numbers * size_of::<u32>()
            })
    }
}

/// Obtuse triangles that were found.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Obtuse triangles of each point of the bordered array. Bit q stands for the triangle between the
    /// neighbours in directions q and q + 1 of [`Direction::ALL`].
    pub(super) bits: Vec<u8>,
    /// Points that have obtuse triangles, by row and by column.
    pub(super) lines: [Lines; 2],
    /// Largest distance in rows and columns at which splits are needed. It may be larger than the one at which updates
    /// look for them, [`crate::EdgeLengths::reach`].
    pub(super) needed: usize,
}

/// Points of some lines, line by line, as positions in the line.
#[derive(Clone, Debug)]
pub struct Lines {
    /// Start of each line in `places`.
    starts: Vec<u32>,
    pub(super) places: Vec<u32>,
}

impl Lines {
    /// Returns the lists of `lines`, in their order, with an empty list for the border line before them and
    /// for the one after them.
    pub(super) fn of(lines: &[Vec<u32>]) -> Self {
        let (mut starts, mut places) = (vec![0, 0], Vec::new());
        for line in lines {
            places.extend(line);
            starts.push(places.len() as u32);
        }
        starts.push(places.len() as u32);
        Self { starts, places }
    }

    /// Returns these points listed by the `lines` lines of the other orientation.
    pub(super) fn turned(&self, lines: usize) -> Self {
        let mut starts = vec![0; lines + 1];
        for &place in &self.places {
            starts[place as usize + 1] += 1;
        }
        for line in 0..lines {
            starts[line + 1] += starts[line];
        }
        let (mut ends, mut places) = (starts.clone(), vec![0; self.places.len()]);
        for (line, range) in self.starts.windows(2).enumerate() {
            for &place in &self.places[range[0] as usize..range[1] as usize] {
                let end = &mut ends[place as usize];
                places[*end as usize] = line as u32;
                *end += 1;
            }
        }
        Self { starts, places }
    }

    pub(super) fn within(&self, line: usize, range: Range<usize>) -> &[u32] {
        let places = &self.places[self.starts[line] as usize..self.starts[line + 1] as usize];
        let before = |end: usize| places.partition_point(|&place| (place as usize) < end);
        &places[before(range.start)..before(range.end)]
    }
}
