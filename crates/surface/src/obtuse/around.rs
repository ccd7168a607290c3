//! Parts of obtuse triangles, by their three corners.

use super::parts::SplitPart;
use crate::chart::Direction;
use crate::edges::EdgeLengths;
use crate::real::Real;

/// The parts of all obtuse triangles of a surface, listed at each of their corners.
#[derive(Clone, Debug)]
pub struct PartsAround<R> {
    /// Parts, with the point x0 whose triangle they split, in the order of these points.
    parts: Vec<(u32, SplitPart<R>)>,
    /// Start of each point's parts in `parts`.
    behind: Vec<u32>,
    /// Indices of parts by x1 and x2, and the start of each point's entries.
    beside: Vec<u32>,
    first: Vec<u32>,
}

impl<R: Real> PartsAround<R> {
    /// Returns the parts, or `None` if no triangle is obtuse.
    #[doc(hidden)]
    pub fn of(edges: &EdgeLengths<R>) -> Option<Self> {
        let obtuse = edges.obtuse_triangles()?;
        let chart = edges.chart();
        let (mut parts, mut behind) = (Vec::new(), Vec::with_capacity(obtuse.len() + 1));
        for (point, &bits) in obtuse.iter().enumerate() {
            behind.push(parts.len() as u32);
            for to in Direction::ALL.into_iter().filter(|&to| bits >> to as u8 & 1 != 0) {
                edges.split(point, [to, to.next()], |corners, lengths, slowness| {
                    parts.push((point as u32, SplitPart { corners, lengths, slowness }));
                });
            }
        }
        behind.push(parts.len() as u32);
        let ends = || {
            let numbered = parts.iter().zip(0u32..);
            numbered.flat_map(|((_, part), number)| part.corners.map(|corner| (corner, number)))
        };
        let mut first = vec![0; chart.bordered_points() + 1];
        ends().for_each(|(corner, _)| first[corner + 1] += 1);
        (1..first.len()).for_each(|point| first[point] += first[point - 1]);
        let (mut next, mut beside) = (first.clone(), vec![0; 2 * parts.len()]);
        for (corner, number) in ends() {
            beside[next[corner] as usize] = number;
            next[corner] += 1;
        }
        Some(Self { parts, behind, beside, first })
    }

    /// Returns the parts that have a point as x0.
    #[doc(hidden)]
    pub fn behind(&self, point: usize) -> impl Iterator<Item = SplitPart<R>> {
        let parts = self.behind[point] as usize..self.behind[point + 1] as usize;
        self.parts[parts].iter().map(|&(_, part)| part)
    }

    /// Returns the points whose triangles have parts.
    #[doc(hidden)]
    pub fn points(&self) -> impl Iterator<Item = usize> {
        let points = self.behind.windows(2).enumerate();
        points.filter(|(_, parts)| parts[0] < parts[1]).map(|(point, _)| point)
    }

    /// Returns the parts that have a point as x1 or x2, each after its x0 and before the length of the edge between both.
    #[doc(hidden)]
    pub fn beside(&self, point: usize) -> impl Iterator<Item = (usize, SplitPart<R>, R)> {
        let entries = self.first[point] as usize..self.first[point + 1] as usize;
        self.beside[entries].iter().map(move |&number| {
            let (x0, part) = self.parts[number as usize];
            (x0 as usize, part, part.lengths[usize::from(part.corners[0] != point)])
        })
    }

    #[doc(hidden)]
    pub fn bytes(&self) -> usize {
        let numbers = self.behind.len() + self.beside.len() + self.first.len();
        size_of_val(self.parts.as_slice()) + numbers * size_of::<u32>()
    }
}
