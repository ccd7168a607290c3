//! Parts of obtuse triangles, by the points that pass their fronts on through them.

use crate::behind::TriangleSlots;
use geosweep_surface::{Direction, EdgeLengths, Real, SplitPart};

/// The parts of all obtuse triangles of a surface, each listed at its corners x1 and x2.
#[derive(Clone, Debug)]
pub(super) struct PartsAround<R> {
    /// Start of each point's entries in `entries`.
    first: Vec<u32>,
    /// Indices of parts.
    entries: Vec<u32>,
    /// Parts, with the point x0 whose triangle they split.
    parts: Vec<(u32, SplitPart<R>)>,
}

impl<R: Real> PartsAround<R> {
    /// Returns the parts, or `None` if no triangle is obtuse.
    pub(super) fn of(edges: &EdgeLengths<R>) -> Option<Self> {
        let obtuse = edges.obtuse_triangles()?;
        let chart = edges.chart();
        let triangles = Direction::ALL.map(|to| TriangleSlots::new(chart, to, to.next()));
        let mut parts = Vec::new();
        for (point, &bits) in obtuse.iter().enumerate().filter(|&(_, &bits)| bits != 0) {
            for slots in triangles.iter().filter(|slots| bits & slots.bit() != 0) {
                edges.split(point, slots.directions(), |corners, lengths, slowness| {
                    parts.push((point as u32, SplitPart { corners, lengths, slowness }));
                });
            }
        }
        let ends = || {
            let numbered = parts.iter().zip(0u32..);
            numbered.flat_map(|((_, part), number)| part.corners.map(|corner| (corner, number)))
        };
        let mut first = vec![0; chart.bordered_points() + 1];
        ends().for_each(|(corner, _)| first[corner + 1] += 1);
        (1..first.len()).for_each(|point| first[point] += first[point - 1]);
        let (mut next, mut entries) = (first.clone(), vec![0; 2 * parts.len()]);
        for (corner, number) in ends() {
            entries[next[corner] as usize] = number;
            next[corner] += 1;
        }
        Some(Self { first, entries, parts })
    }

    /// Returns the parts that have a point as x1 or x2, each with its x0.
    pub(super) fn around(&self, point: usize) -> impl Iterator<Item = (usize, SplitPart<R>)> {
        let entries = self.first[point] as usize..self.first[point + 1] as usize;
        self.entries[entries].iter().map(|&number| {
            let (x0, part) = self.parts[number as usize];
            (x0 as usize, part)
        })
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.first.as_slice())
            + size_of_val(self.entries.as_slice())
            + size_of_val(self.parts.as_slice())
    }
}
