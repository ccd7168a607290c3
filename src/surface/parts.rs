//! The parts of all obtuse triangles ([`EdgeLengths::split`]), found once for a surface, in the order in which scans
//! come to them.

use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

use super::chart::{Chart, Direction, Lines};
use super::edges::EdgeLengths;
use super::real::Real;

/// Obtuse triangles of a surface up to which their parts are kept: half a gigabyte in single precision. Those of more
/// are found whenever they are needed.
const KEPT: usize = 1 << 23;

/// The parts of all obtuse triangles, by the side of their point on which they lie. Unknown until they are asked for;
/// nothing if there are none, or too many to be kept.
#[derive(Clone, Debug)]
pub(super) struct Parts<R>(OnceLock<Option<[SideParts<R>; 4]>>);

impl<R> Default for Parts<R> {
    fn default() -> Self {
        Self(OnceLock::new())
    }
}

impl<R: Real> Parts<R> {
    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        let sides = self.0.get().and_then(Option::as_ref);
        sides.map_or(0, |sides| sides.iter().map(SideParts::bytes).sum())
    }
}

/// One of the two triangles on one side of a point, by the point's place in its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TriangleOfLine(u32);

impl TriangleOfLine {
    fn new(place: u32, is_second: bool) -> Self {
        Self(2 * place + u32::from(is_second))
    }

    /// Where in the line its point is, counted from the border.
    #[inline(always)]
    pub(crate) fn place(self) -> usize {
        (self.0 / 2) as usize
    }
}

/// The parts of triangles on one side of their points: of the two that have the edge to the neighbour there.
///
/// In the order of their points: line by line, and along lines. Lines are rows where that neighbour lies in another
/// row, else columns; lines and places in them are counted from the border.
#[derive(Clone, Debug, Default)]
pub(crate) struct SideParts<R> {
    /// Where each line's begin.
    starts: Vec<u32>,
    /// Of each part its triangle.
    triangles: Vec<TriangleOfLine>,
    /// The two other corners, in the bordered array.
    corners: [Vec<u32>; 2],
    /// The lengths of x0 x1, x0 x2 and x1 x2.
    lengths: [Vec<R>; 3],
    /// The slowness at x0, x1 and x2 by which they are weighted; nothing if there is none.
    slowness: [Vec<R>; 3],
}

/// Some parts that follow one another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartsOfLine<'a, R> {
    pub triangles: &'a [TriangleOfLine],
    pub corners: [&'a [u32]; 2],
    pub lengths: [&'a [R]; 3],
    /// Empty if there is none.
    pub slowness: [&'a [R]; 3],
}

impl<'a, R: Real> PartsOfLine<'a, R> {
    /// The two other corners of one of them.
    #[inline]
    pub(crate) fn corners(&self, part: usize) -> [usize; 2] {
        self.corners.map(|of| of[part] as usize)
    }

    /// Those of one of them.
    #[inline]
    pub(crate) fn lengths(&self, part: usize) -> [R; 3] {
        self.lengths.map(|of| of[part])
    }

    /// Likewise; 1 if there is none.
    #[inline]
    pub(crate) fn slowness(&self, part: usize) -> [R; 3] {
        self.slowness.map(|of| of.get(part).copied().unwrap_or(R::one()))
    }
}

impl<R: Real> SideParts<R> {
    /// The parts whose points lie in part of a line.
    #[inline]
    pub(crate) fn within(&self, line: usize, range: Range<usize>) -> PartsOfLine<'_, R> {
        let of_line = self.starts[line] as usize..self.starts[line + 1] as usize;
        let triangles = &self.triangles[of_line.clone()];
        let before = |end: usize| triangles.partition_point(|of| of.place() < end);
        // Most lines have none.
        let found = match triangles.is_empty() {
            true => of_line,
            false => of_line.start + before(range.start)..of_line.start + before(range.end),
        };
        self.among(found)
    }

    fn among(&self, range: Range<usize>) -> PartsOfLine<'_, R> {
        let slowness = self.slowness.each_ref();
        PartsOfLine {
            triangles: &self.triangles[range.clone()],
            corners: self.corners.each_ref().map(|of| &of[range.clone()]),
            lengths: self.lengths.each_ref().map(|of| &of[range.clone()]),
            slowness: slowness.map(|of| if of.is_empty() { of } else { &of[range.clone()] }),
        }
    }

    fn bytes(&self) -> usize {
        let numbers = self.starts.len() + self.triangles.len() + 2 * self.corners[0].len();
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
            all.triangles.extend(line.triangles);
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
        // As they lie along the line, by the first of their directions.
        let in_order = match side {
            Direction::North | Direction::East => [side, side.previous()],
            _ => [side.previous(), side],
        };
        for &place in edges.obtuse_points(lines == Lines::Rows, line, 0..length) {
            let (row, col) = lines.place(line, place as usize);
            let point = chart.entry_index(row, col);
            for (second, first) in in_order.into_iter().enumerate() {
                if obtuse[point] & 1 << first as u8 == 0 {
                    continue;
                }
                let triangle = TriangleOfLine::new(place, second != 0);
                edges.split(point, [first, first.next()], |corners, lengths, slowness| {
                    found.triangles.push(triangle);
                    found.corners.iter_mut().zip(corners).for_each(|(to, x)| to.push(x as u32));
                    found.lengths.iter_mut().zip(lengths).for_each(|(to, length)| to.push(length));
                    if is_slowed {
                        found.slowness.iter_mut().zip(slowness).for_each(|(to, of)| to.push(of));
                    }
                });
            }
        }
        found
    }
}

impl<R: Real> EdgeLengths<R> {
    /// The parts of obtuse triangles on one side of their points, if the surface has any such triangle and they are kept.
    pub(crate) fn parts_on_side(&self, side: Direction) -> Option<&SideParts<R>> {
        let of_all = || {
            let bits = self.obtuse_triangles()?;
            let triangles: usize = bits.par_iter().map(|bits| bits.count_ones() as usize).sum();
            (triangles <= KEPT).then(|| SIDES.map(|side| SideParts::of(self, side)))
        };
        let sides = self.parts.0.get_or_init(of_all).as_ref()?;
        Some(&sides[side as usize / 2])
    }
}

/// In the order of [`Direction::ALL`].
const SIDES: [Direction; 4] =
    [Direction::East, Direction::North, Direction::West, Direction::South];
