//! Stores the parts of all obtuse triangles ([`EdgeLengths::split`]) of a surface, in the order in which
//! scans visit them.

use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

use super::chart::{Chart, Direction, Lines};
use super::edges::EdgeLengths;
use super::real::Real;

/// Maximum number of obtuse triangles of a surface whose parts are stored: half a gigabyte in single
/// precision. If there are more, parts are found whenever they are needed.
const KEPT: usize = 1 << 23;

/// The parts of all obtuse triangles, by the side of their point on which they lie. They are computed when
/// several maps, or few triangles, make it worth their memory. `None` inside means that there are none, or too many to store.
#[derive(Clone, Debug)]
pub(super) struct Parts<R>(OnceLock<Option<[SideParts<R>; 4]>>);

impl<R> Default for Parts<R> {
    fn default() -> Self {
        Self(OnceLock::new())
    }
}

impl<R: Real> Parts<R> {
    /// Returns the number of bytes held.
    pub(super) fn bytes(&self) -> usize {
        let sides = self.0.get().and_then(Option::as_ref);
        sides.map_or(0, |sides| sides.iter().map(SideParts::bytes).sum())
    }
}

/// The obtuse triangles on one side of their points, with their parts. On each side a point has two
/// triangles, which share the edge to the neighbour there.
///
/// Triangles are sorted by their points: line by line, and along lines. Lines are rows where that neighbour
/// lies in another row, else columns. Lines and places in them are counted from the border.
#[derive(Clone, Debug, Default)]
pub(crate) struct SideParts<R> {
    /// Start of each line's triangles.
    starts: Vec<u32>,
    /// Place of each triangle's point in its line.
    triangles: Vec<u32>,
    /// End of each triangle's parts. Some triangles have none.
    ends: Vec<u32>,
    /// The two other corners of each part, as indices into the bordered array.
    corners: [Vec<u32>; 2],
    /// Lengths of x0 x1, x0 x2 and x1 x2.
    lengths: [Vec<R>; 3],
    /// Slowness at x0, x1 and x2, by which the lengths are weighted. Empty if there is none.
    slowness: [Vec<R>; 3],
}

/// A part of an obtuse triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part<R> {
    /// The two other corners, as indices into the bordered array.
    pub corners: [usize; 2],
    /// Lengths of x0 x1, x0 x2 and x1 x2.
    pub lengths: [R; 3],
    /// Slowness at x0, x1 and x2; 1 if there is none.
    pub slowness: [R; 3],
}

/// Successive obtuse triangles of a line.
#[derive(Clone, Debug)]
pub(crate) struct SplitTriangles<'a, R> {
    side: &'a SideParts<R>,
    triangles: Range<usize>,
}

impl<'a, R: Real> SplitTriangles<'a, R> {
    pub(crate) fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Returns, for each triangle, its parts and the place of its point in the line, counted from the border.
    pub(crate) fn parts(
        self,
    ) -> impl Iterator<Item = (usize, impl Iterator<Item = Part<R>> + use<'a, R>)> + use<'a, R>
    {
        let Self { side, triangles } = self;
        let part = move |part: usize| Part {
            corners: side.corners.each_ref().map(|of| of[part] as usize),
            lengths: side.lengths.each_ref().map(|of| of[part]),
            slowness: side.slowness.each_ref().map(|of| of.get(part).copied().unwrap_or(R::one())),
        };
        let place = |triangle: usize| side.triangles[triangle] as usize;
        triangles.map(move |triangle| (place(triangle), side.parts_of(triangle).map(part)))
    }
}

impl<R: Real> SideParts<R> {
    /// Returns the obtuse triangles whose points lie in part of a line.
    #[inline]
    pub(crate) fn within(&self, line: usize, range: Range<usize>) -> SplitTriangles<'_, R> {
        let of_line = self.starts[line] as usize..self.starts[line + 1] as usize;
        // Most lines have none.
        if of_line.is_empty() {
            return SplitTriangles { side: self, triangles: of_line };
        }
        let triangles = &self.triangles[of_line.clone()];
        let before =
            |end: usize| of_line.start + triangles.partition_point(|&place| (place as usize) < end);
        SplitTriangles { side: self, triangles: before(range.start)..before(range.end) }
    }

    fn parts_of(&self, triangle: usize) -> Range<usize> {
        let start = triangle.checked_sub(1).map_or(0, |before| self.ends[before]);
        start as usize..self.ends[triangle] as usize
    }

    fn bytes(&self) -> usize {
        let numbers =
            self.starts.len() + self.triangles.len() + self.ends.len() + 2 * self.corners[0].len();
        let lengths = self.lengths.iter().chain(&self.slowness).map(Vec::len).sum::<usize>();
        numbers * size_of::<u32>() + lengths * size_of::<R>()
    }

    fn of(edges: &EdgeLengths<R>, side: Direction) -> Self {
        let lines = if side.step().0 == 0 { Lines::Cols } else { Lines::Rows };
        let turned = edges.chart().by(lines);
        let found = (0..turned.rows + 2)
            .into_par_iter()
            .map(|line| Self::of_line(edges, side, lines, line));
        let mut all = Self { starts: vec![0], ..Self::default() };
        for line in found.collect::<Vec<_>>() {
            let before = all.corners[0].len() as u32;
            all.triangles.extend(line.triangles);
            all.ends.extend(line.ends.into_iter().map(|end| before + end));
            all.starts.push(all.triangles.len() as u32);
            all.corners.iter_mut().zip(line.corners).for_each(|(to, of)| to.extend(of));
            all.lengths.iter_mut().zip(line.lengths).for_each(|(to, of)| to.extend(of));
            all.slowness.iter_mut().zip(line.slowness).for_each(|(to, of)| to.extend(of));
        }
        all
    }

    fn of_line(edges: &EdgeLengths<R>, side: Direction, lines: Lines, line: usize) -> Self {
        let mut found = Self::default();
        let Some(obtuse) = edges.obtuse_triangles() else { return found };
        let is_slowed = edges.slowness().is_some();
        let chart: Chart = edges.chart();
        let length = chart.by(lines).cols + 2;
        // Sorted along the line, by the first of their directions.
        let in_order = match side {
            Direction::North | Direction::East => [side, side.previous()],
            _ => [side.previous(), side],
        };
        for &place in edges.obtuse_points(lines == Lines::Rows, line, 0..length) {
            let (row, col) = lines.place(line, place as usize);
            let point = chart.entry_index(row, col);
            for first in in_order {
                if obtuse[point] & 1 << first as u8 == 0 {
                    continue;
                }
                edges.split(point, [first, first.next()], |corners, lengths, slowness| {
                    found.corners.iter_mut().zip(corners).for_each(|(to, x)| to.push(x as u32));
                    found.lengths.iter_mut().zip(lengths).for_each(|(to, length)| to.push(length));
                    if is_slowed {
                        found.slowness.iter_mut().zip(slowness).for_each(|(to, of)| to.push(of));
                    }
                });
                found.triangles.push(place);
                found.ends.push(found.corners[0].len() as u32);
            }
        }
        found
    }
}

/// Reciprocal of the largest fraction of a surface's points that have obtuse triangles for which storing the
/// parts pays within a single map. If all points have some, storing takes half as long again as the map.
const FEW: usize = 4;

impl<R: Real> EdgeLengths<R> {
    /// Stores the parts of obtuse triangles if there are few. A map of few iterations finds more of them as it
    /// needs them.
    pub(crate) fn store_few_parts(&self) {
        if self.obtuse_count() <= self.chart().points() / FEW {
            self.parts_on_side(Direction::North);
        }
    }

    /// Returns the parts of obtuse triangles on one side of their points if they are stored already.
    pub(crate) fn stored_parts_on_side(&self, side: Direction) -> Option<&SideParts<R>> {
        let sides = self.parts.0.get()?.as_ref()?;
        Some(&sides[side as usize / 2])
    }

    /// Returns the parts of obtuse triangles on one side of their points, which are stored from now on. The
    /// result is `None` if the surface has no such triangle, or more than can be stored.
    pub(crate) fn parts_on_side(&self, side: Direction) -> Option<&SideParts<R>> {
        if self.parts.0.get().is_none() {
            // Computed outside the lock: a thread that waits for others here may take up work that needs the
            // parts too.
            let sides = self.find_parts();
            self.parts.0.get_or_init(|| sides);
        }
        self.stored_parts_on_side(side)
    }

    fn find_parts(&self) -> Option<[SideParts<R>; 4]> {
        let bits = self.obtuse_triangles()?;
        let triangles: usize = bits.par_iter().map(|bits| bits.count_ones() as usize).sum();
        (triangles <= KEPT).then(|| SIDES.map(|side| SideParts::of(self, side)))
    }
}

/// The sides in the order of [`Direction::ALL`].
const SIDES: [Direction; 4] =
    [Direction::East, Direction::North, Direction::West, Direction::South];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::builtin::Builtin;
    use crate::surface::{Spacing, Surface};

    /// Returns hills with holes, flat sheared cells, and hills with a slowness.
    fn surfaces() -> [Surface; 3] {
        let (rows, cols) = (19, 23);
        let height = |k: usize| 2.5 * ((k * k / 3 % 7) as f64).sin();
        let heights = || (0..rows * cols).map(height).collect();
        let hills = || Surface::from_heights(rows, cols, heights(), Spacing::square(1.0)).unwrap();
        let present: Vec<_> = (0..rows * cols).map(|k| k % 29 != 3).collect();
        let slowness = (0..rows * cols).map(|k| 1.0 + (k % 5) as f64).collect();
        [
            hills().with_mask(&present).unwrap(),
            Builtin::ShearedPlane { degrees: 65.0 }.surface(rows, cols).unwrap(),
            hills().with_slowness(slowness).unwrap(),
        ]
    }

    /// Corners, lengths and slowness of a part of a triangle.
    type Told = ([usize; 2], [f64; 3], [f64; 3]);

    /// Returns the parts of a point's triangles on a side, as they are found one by one.
    fn found(edges: &EdgeLengths<f64>, point: usize, side: Direction) -> Vec<Told> {
        let mut found = Vec::new();
        let bits = edges.obtuse_triangles().unwrap()[point];
        for first in [side.previous(), side].into_iter().filter(|&to| bits >> to as u8 & 1 != 0) {
            edges.split(point, [first, first.next()], |corners, lengths, slowness| {
                found.push((corners, lengths, slowness));
            });
        }
        found
    }

    #[test]
    fn parts_are_listed_by_line_with_the_triangles_they_come_from() {
        for surface in surfaces() {
            let edges = EdgeLengths::<f64>::new(&surface).unwrap();
            let (chart, bits) = (edges.chart(), edges.obtuse_triangles().unwrap());
            let mut triangles = 0;
            for side in SIDES {
                let lines = if side.step().0 == 0 { Lines::Cols } else { Lines::Rows };
                let listed = edges.parts_on_side(side).unwrap();
                let turned = chart.by(lines);
                for (line, range) in (0..turned.rows + 2)
                    .flat_map(|line| [(line, 0..turned.cols + 2), (line, 3..turned.cols - 2)])
                {
                    let mut told: Vec<(usize, Told)> = Vec::new();
                    let mut places = Vec::new();
                    for (place, parts) in listed.within(line, range.clone()).parts() {
                        places.push(place);
                        told.extend(
                            parts.map(|part| (place, (part.corners, part.lengths, part.slowness))),
                        );
                    }
                    assert!(places.is_sorted() && places.iter().all(|at| range.contains(at)));
                    let at = |place: usize| {
                        let (row, col) = lines.place(line, place);
                        chart.entry_index(row, col)
                    };
                    let of_side = 1 << side as u8 | 1 << side.previous() as u8;
                    let count = |place| (bits[at(place)] & of_side).count_ones() as usize;
                    assert_eq!(places.len(), range.clone().map(count).sum::<usize>());
                    triangles += if range.start == 0 { places.len() } else { 0 };
                    let expected = range.flat_map(|place| {
                        let found = found(&edges, at(place), side);
                        found.into_iter().map(move |part| (place, part))
                    });
                    let mut expected: Vec<_> = expected.collect();
                    // Either of a point's two triangles may come first.
                    let by = |a: &(usize, Told), b: &(usize, Told)| a.partial_cmp(b).unwrap();
                    told.sort_by(by);
                    expected.sort_by(by);
                    assert_eq!(told, expected);
                }
            }
            let all: u32 = bits.iter().map(|bits| bits.count_ones()).sum();
            assert_eq!(triangles, all as usize);
        }
    }
}
