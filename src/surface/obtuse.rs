//! Finds the triangles that are obtuse at the point that is updated from them, and keeps lists of them.
//!
//! While edges are measured, cells are marked in which a triangle may be obtuse. Only these are searched, on
//! first use. Splitting the triangles is in `unfold.rs`.

use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

use super::chart::{Chart, ring};
use super::edges::EdgeLengths;
use super::real::Real;
use crate::constants::OBTUSE;
use crate::lanes::{Instructions, Loop};

/// Returns whether a triangle with an area is obtuse at x0, given the squares of its sides at x0 divided by
/// the square of the base. A margin excludes triangles that are right-angled but for rounding.
#[inline(always)]
pub(crate) fn is_obtuse<R: Real>(side_squared: R, other_squared: R) -> bool {
    side_squared + other_squared < R::of(OBTUSE)
}

/// The obtuse triangles of a surface. They are computed on first use; `None` inside means that there are
/// none.
#[derive(Clone, Debug, Default)]
pub(super) struct ObtuseTriangles {
    found: OnceLock<Option<Found>>,
    /// The cells to search, if they are known.
    marked: Option<MarkedCells>,
}

/// Number of adjacent cells of a row that are marked together.
const CELLS: usize = 32;

/// Marks of the cells in which a triangle may be obtuse. They are set while edges are measured, which costs
/// less than to read all edges again.
#[derive(Clone, Debug)]
pub(super) struct MarkedCells {
    /// Number of marks in a row of cells. Row r of cells lies between the points of rows r - 1 and r.
    in_row: usize,
    marks: Vec<bool>,
}

impl MarkedCells {
    pub(super) fn none(chart: Chart) -> Self {
        let in_row = chart.cols.div_ceil(CELLS);
        Self { in_row, marks: vec![false; chart.rows * in_row] }
    }

    /// Returns the marks of each row of cells.
    pub(super) fn rows_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [bool]> {
        self.marks.par_chunks_mut(self.in_row)
    }

    pub(super) fn any(&self) -> bool {
        self.marks.contains(&true)
    }

    /// Returns the ranges of a row's `points` points that are corners of marked cells.
    fn ranges(&self, row: usize, points: usize) -> Vec<Range<usize>> {
        let of_cells = |row: usize| self.marks.get(row * self.in_row..(row + 1) * self.in_row);
        let rows = [of_cells(row), of_cells(row + 1)];
        let is_marked = |at: usize| rows.iter().flatten().any(|marks| marks[at]);
        let mut ranges: Vec<Range<usize>> = Vec::new();
        for at in (0..self.in_row).filter(|&at| is_marked(at)) {
            // The last of these cells has a corner beyond them.
            let range = at * CELLS..((at + 1) * CELLS + 1).min(points);
            match ranges.last_mut() {
                Some(last) if last.end >= range.start => last.end = range.end,
                _ => ranges.push(range),
            }
        }
        ranges
    }
}

/// Obtuse triangles that were found.
#[derive(Clone, Debug)]
struct Found {
    /// Obtuse triangles of each point of the bordered array. Bit q stands for the triangle between the
    /// neighbours in directions q and q + 1 of [`Direction::ALL`].
    bits: Vec<u8>,
    /// Points that have obtuse triangles, by row and by column.
    lines: [Lines; 2],
    triangles: usize,
}

/// A list of points, line by line: for each point its place in the line.
#[derive(Clone, Debug)]
struct Lines {
    /// Start of each line in `places`.
    starts: Vec<u32>,
    places: Vec<u32>,
}

impl Lines {
    /// Returns the lists of `lines`, in their order, and empty ones for two border lines before and after
    /// them.
    fn of(lines: &[Vec<u32>]) -> Self {
        let (mut starts, mut places) = (vec![0, 0], Vec::new());
        for line in lines {
            places.extend(line);
            starts.push(places.len() as u32);
        }
        starts.push(places.len() as u32);
        Self { starts, places }
    }

    /// Returns these points by the lines across, of which there are `lines`.
    fn turned(&self, lines: usize) -> Self {
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

    fn within(&self, line: usize, range: Range<usize>) -> &[u32] {
        let places = &self.places[self.starts[line] as usize..self.starts[line + 1] as usize];
        let before = |end: usize| places.partition_point(|&place| (place as usize) < end);
        &places[before(range.start)..before(range.end)]
    }
}

impl ObtuseTriangles {
    pub(super) fn none() -> Self {
        Self { found: OnceLock::from(None), marked: None }
    }

    /// Returns obtuse triangles that lie in marked cells only.
    pub(super) fn within(marked: MarkedCells) -> Self {
        Self { found: OnceLock::new(), marked: Some(marked) }
    }

    /// Returns the number of bytes held.
    pub(super) fn bytes(&self) -> usize {
        let marks = self.marked.as_ref().map_or(0, |cells| cells.marks.len());
        marks
            + self.found.get().and_then(Option::as_ref).map_or(0, |found| {
                let numbers: usize =
                    found.lines.iter().map(|lines| lines.starts.len() + lines.places.len()).sum();
                found.bits.len() + numbers * size_of::<u32>()
            })
    }
}

impl<R: Real> EdgeLengths<R> {
    /// Returns the obtuse triangles of each point of the bordered array, as bits in the order of
    /// [`Direction::ALL`]. The result is `None` if the surface has no such triangle, which is the common
    /// case.
    pub(crate) fn obtuse_triangles(&self) -> Option<&[u8]> {
        self.found().map(|found| &*found.bits)
    }

    fn found(&self) -> Option<&Found> {
        if let Some(found) = self.shared.obtuse.found.get() {
            return found.as_ref();
        }
        // Computed outside the lock: a thread that waits for others here may take up work that needs the
        // result too.
        let found = obtuse_triangles(self);
        self.shared.obtuse.found.get_or_init(|| found).as_ref()
    }

    /// Returns the points with obtuse triangles in part of a row or column of the bordered array, by their
    /// places in it.
    pub(crate) fn obtuse_points(&self, by_rows: bool, line: usize, range: Range<usize>) -> &[u32] {
        self.found().map_or(&[], |found| found.lines[usize::from(!by_rows)].within(line, range))
    }

    /// Returns whether any of a row's points in `cols` has obtuse triangles.
    pub(crate) fn has_obtuse_points(&self, row: usize, cols: Range<usize>) -> bool {
        !self.obtuse_points(true, row + 1, cols.start + 1..cols.end + 1).is_empty()
    }

    /// Returns the number of points with obtuse triangles.
    pub(super) fn obtuse_count(&self) -> usize {
        self.found().map_or(0, |found| found.lines[0].places.len())
    }

    /// Returns the number of obtuse triangles.
    pub(super) fn obtuse_triangles_count(&self) -> usize {
        self.found().map_or(0, |found| found.triangles)
    }

    /// Returns whether the surface has triangles that are obtuse at the point that is updated from them.
    /// Steep surfaces and sheared grids have some.
    pub fn has_obtuse_triangles(&self) -> bool {
        self.obtuse_triangles().is_some()
    }
}

/// A search for obtuse triangles while rows are measured one after another.
pub(super) struct RowAbove<R> {
    /// Edges along the row above.
    east: Vec<R>,
    /// Marks of the cells between the last two rows, as in [`MarkedCells`].
    pub(super) marks: Vec<bool>,
}

impl<R: Real> RowAbove<R> {
    /// Returns the state before the first row.
    pub(super) fn none(cols: usize) -> Self {
        Self { east: vec![R::FAR; cols], marks: vec![false; cols.div_ceil(CELLS)] }
    }

    /// Checks the triangles above the next row, given the edges stored at its points.
    pub(super) fn next(&mut self, [east, north, north_east, north_west]: &[Vec<R>; 4]) {
        let Self { east: above, marks } = self;
        Instructions::best().run(Cells { above, east, north, north_east, north_west, marks });
        above.copy_from_slice(east);
    }
}

/// The cells between two rows of points. The lower row stores the edges between both.
struct Cells<'a, R> {
    above: &'a [R],
    east: &'a [R],
    north: &'a [R],
    north_east: &'a [R],
    north_west: &'a [R],
    marks: &'a mut [bool],
}

impl<R: Real> Loop for Cells<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let cells = self.east.len().saturating_sub(1);
        let (above, east) = (&self.above[..cells], &self.east[..cells]);
        let (left, right) = (&self.north[..cells], &self.north[1..][..cells]);
        let (rising, falling) = (&self.north_east[..cells], &self.north_west[1..][..cells]);
        // The limit errs towards too many triangles, since shaders would find a missed one.
        let (limit, missing) = (R::of(1.001 * OBTUSE), R::FAR * R::FAR);
        for (at, mark) in self.marks.iter_mut().enumerate() {
            let mut found = false;
            for col in at * CELLS..((at + 1) * CELLS).min(cells) {
                let square = |edges: &[R]| edges[col] * edges[col];
                let (above, east) = (square(above), square(east));
                let (left, right) = (square(left), square(right));
                // The angle at an end of a diagonal: the base joins the other end to another corner.
                let at_end = |diagonal: R, a: R, b: R| (diagonal + a < limit * b) & (b < missing);
                let at_ends = |d: R, a: R, b: R| at_end(d, a, b) | at_end(d, b, a);
                let (rising, falling) = (square(rising), square(falling));
                found |= at_ends(rising, east, right) | at_ends(rising, left, above);
                found |= at_ends(falling, east, left) | at_ends(falling, right, above);
            }
            *mark = found;
        }
    }
}

fn obtuse_triangles<R: Real>(edges: &EdgeLengths<R>) -> Option<Found> {
    let chart = edges.chart();
    let mut triangles = vec![0; chart.bordered_points()];
    let is_slowed = edges.slowness().is_some();
    let in_row = |(row, line): (usize, &mut [u8])| {
        let ranges = match &edges.shared.obtuse.marked {
            Some(cells) => cells.ranges(row, line.len()),
            None => std::iter::once(0..line.len()).collect(),
        };
        let mut places = Vec::new();
        for cols in ranges {
            let (first, line) = (cols.start, &mut line[cols.clone()]);
            match is_slowed {
                true => Instructions::best().run(SlowedRowOfTriangles { edges, row, first, line }),
                false => {
                    Instructions::best().run(RowOfTriangles { edges, row, first, line });
                    edges.leave_obtuse((row, first), line);
                }
            }
            places.extend(marked(line).map(|col| (first + col) as u32 + 1));
        }
        places
    };
    let rows: Vec<Vec<u32>> = chart.rows_mut(&mut triangles).enumerate().map(in_row).collect();
    rows.iter().any(|row| !row.is_empty()).then(|| {
        let by_row = Lines::of(&rows);
        let by_col = by_row.turned(chart.stride());
        let of_row = |(row, places): (usize, &Vec<u32>)| -> u32 {
            let bits = |&place: &u32| triangles[chart.entry_index(row + 1, place as usize)];
            places.iter().map(|place| bits(place).count_ones()).sum()
        };
        let count = rows.iter().enumerate().map(|row| of_row(row) as usize).sum();
        Found { bits: triangles, lines: [by_row, by_col], triangles: count }
    })
}

impl<R: Real> EdgeLengths<R> {
    /// Clears the marks of triangles of some points of a row that are not obtuse by the computation that
    /// updates use.
    fn leave_obtuse(&self, (row, first): (usize, usize), line: &mut [u8]) {
        let [fan, bases] = self.fans(row, first..first + line.len());
        for col in marked(line).collect::<Vec<_>>() {
            let bits = &mut line[col];
            for to in 0..8 {
                if *bits >> to & 1 == 0 {
                    continue;
                }
                let per_base = bases[to][col].recip();
                let [side, other] = [fan[to][col], fan[ring::next(to)][col]].map(|l| l * per_base);
                if !is_obtuse(side * side, other * other) {
                    *bits &= !(1 << to);
                }
            }
        }
    }
}

/// Returns the places in a line where a bit is set. There are usually few.
fn marked(line: &[u8]) -> impl Iterator<Item = usize> {
    const TOGETHER: usize = 16;
    let some = line.chunks(TOGETHER).enumerate().filter(|(_, of)| any_bit(of) != 0);
    some.flat_map(|(chunk, of)| {
        let set = (chunk * TOGETHER..).zip(of).filter(|(_, bits)| **bits != 0);
        set.map(|(at, _)| at)
    })
}

fn any_bit(of: &[u8]) -> u8 {
    of.iter().fold(0, |all, bits| all | bits)
}

/// The loop that marks the triangles of points of a row, from `first` on, that may be obtuse. Its limit errs
/// towards too many triangles, to allow for rounding.
struct RowOfTriangles<'a, R> {
    edges: &'a EdgeLengths<R>,
    row: usize,
    first: usize,
    line: &'a mut [u8],
}

impl<R: Real> Loop for RowOfTriangles<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { edges, row, first, line } = self;
        let points = line.len();
        let [fan, bases] = edges.fans(row, first..first + points);
        let limit = R::of(1.001 * OBTUSE);
        line.fill(0);
        // One direction after another, so that points become SIMD lanes.
        for to in 0..8 {
            let [a, b, c] = [fan[to], fan[ring::next(to)], bases[to]].map(|of| &of[..points]);
            for (col, bits) in line.iter_mut().enumerate() {
                let (a, b, c) = (a[col], b[col], c[col]);
                let obtuse = (c < R::FAR) & (a * a + b * b < limit * (c * c));
                *bits |= u8::from(obtuse) << to;
            }
        }
    }
}

/// The loop that finds the obtuse triangles of points of a row, from `first` on, where edges are weighted by
/// a slowness. It is a separate loop so that both are vectorized.
struct SlowedRowOfTriangles<'a, R> {
    edges: &'a EdgeLengths<R>,
    row: usize,
    first: usize,
    line: &'a mut [u8],
}

impl<R: Real> Loop for SlowedRowOfTriangles<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { edges, row, first, line } = self;
        let cols = first..first + line.len();
        let [fan, bases] = edges.fans(row, cols.clone());
        let Some((own, around)) = edges.fan_slowness(row, cols) else { return };
        for (col, bits) in line.iter_mut().enumerate() {
            let mut found = 0;
            for to in 0..8 {
                let next = ring::next(to);
                let (own, first, second) = (own[col], around[to][col], around[next][col]);
                // Half of each length on the surface.
                let (a, b) = (fan[to][col] / (own + first), fan[next][col] / (own + second));
                let c = bases[to][col] / (first + second);
                let is_there = bases[to][col] < R::FAR;
                let obtuse = is_there & (a * a + b * b < R::of(OBTUSE) * (c * c));
                found |= u8::from(obtuse) << to;
            }
            *bits = found;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::builtin::Builtin;
    use crate::surface::{Spacing, Surface};

    /// Returns a surface that steps up and down by `height`, with a hole.
    fn steps(height: f64) -> Surface {
        let (rows, cols) = (40, 7);
        let heights = (0..rows * cols).map(|k| height * f64::from((k * k / 3 % 5) as u8)).collect();
        let mut mask = vec![true; rows * cols];
        mask[3 * cols + 2] = false;
        let surface = Surface::from_heights(rows, cols, heights, Spacing::square(1.0)).unwrap();
        surface.with_mask(&mask).unwrap()
    }

    #[test]
    fn obtuse_triangles_are_found_while_edges_are_measured() {
        let sheared = |degrees| Builtin::ShearedPlane { degrees }.surface(35, 9).unwrap();
        let flat = Builtin::Plane.surface(40, 9).unwrap();
        for (surface, expected) in
            [(flat, false), (steps(0.0), false), (sheared(30.0), true), (steps(3.0), true)]
        {
            let edges = EdgeLengths::<f32>::new(&surface).unwrap();
            let mut texels = vec![[0.0; 4]; surface.rows() * surface.cols()];
            let told =
                surface.write_edges(0..surface.rows(), surface.origin(), &mut texels).unwrap();
            assert_eq!((edges.has_obtuse_triangles(), told), (expected, expected));
            // The full search agrees with the one during measurement.
            assert_eq!(obtuse_triangles(&edges).is_some(), expected);
        }
    }

    #[test]
    fn marked_cells_have_all_obtuse_triangles() {
        // Steps that cross the border between cells that are marked together, and steps at the border.
        for places in [[(5, CELLS), (20, 2 * CELLS - 1)], [(0, 0), (39, 2 * CELLS + 6)]] {
            let (rows, cols) = (40, 2 * CELLS + 7);
            let mut heights = vec![0.0; rows * cols];
            for (row, col) in places {
                // The base between both is longer than a right angle beside them allows.
                let beside = if row == 0 { 1 } else { row - 1 };
                heights[row * cols + col] = 2.0;
                heights[beside * cols + col] = -2.0;
            }
            let surface = Surface::from_heights(rows, cols, heights, Spacing::square(1.0)).unwrap();
            let edges = EdgeLengths::<f32>::new(&surface).unwrap();
            let marked = edges.shared.obtuse.marked.as_ref().unwrap();
            assert!(marked.marks.contains(&false));
            let found = edges.found().unwrap();
            let mut unmarked = EdgeLengths::<f32>::new(&surface).unwrap();
            let shared = std::sync::Arc::get_mut(&mut unmarked.shared).unwrap();
            shared.obtuse = ObtuseTriangles::default();
            let expected = unmarked.found().unwrap();
            assert_eq!((&found.bits, found.triangles), (&expected.bits, expected.triangles));
            let all: u32 = found.bits.iter().map(|bits| bits.count_ones()).sum();
            assert!(all > 0 && found.triangles == all as usize);
        }
    }

    #[test]
    fn points_with_obtuse_triangles_are_listed_by_row_and_column() {
        let edges = EdgeLengths::<f64>::new(&steps(3.0)).unwrap();
        let (chart, bits) = (edges.chart(), edges.obtuse_triangles().unwrap());
        let lines =
            [(true, chart.rows + 2, chart.cols + 2), (false, chart.cols + 2, chart.rows + 2)];
        for (by_rows, count, length) in lines {
            for line in 0..count {
                let is_listed = |&at: &usize| {
                    let at = if by_rows { (line, at) } else { (at, line) };
                    bits[chart.entry_index(at.0, at.1)] != 0
                };
                let expected: Vec<_> = (2..length - 1).filter(is_listed).collect();
                let listed = edges.obtuse_points(by_rows, line, 2..length - 1);
                assert_eq!(listed.iter().map(|&at| at as usize).collect::<Vec<_>>(), expected);
            }
        }
    }
}
