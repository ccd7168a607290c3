//! Finds the triangles that are obtuse at the point that is updated from them, on first use. The search covers only the
//! marked cells, if these are known.

use std::ops::Range;

use rayon::prelude::*;

use super::lists::{Found, Lines};
use super::reach::{of_updates, reach};
use crate::chart::{Direction, ring};
use crate::constants::{OBTUSE, SPLIT_REACH};
use crate::edges::EdgeLengths;
use crate::kept;
use crate::lanes::{Instructions, Loop};
use crate::precision::{OfEdges, of_edges};
use crate::real::Real;

/// Returns whether a triangle with an area is obtuse at x0, given the squares of its sides at x0 divided by
/// the square of the base. A margin excludes triangles whose angle exceeds a right angle only by rounding.
#[inline(always)]
pub fn is_obtuse<R: Real>(side_squared: R, other_squared: R) -> bool {
    side_squared + other_squared < R::of(OBTUSE)
}

impl<R: Real> EdgeLengths<R> {
    /// Returns the obtuse triangles of each point of the bordered array, as bits in the order of
    /// [`Direction::ALL`]. The result is `None` if the surface has no such triangle, which is the common
    /// case.
    #[doc(hidden)]
    pub fn obtuse_triangles(&self) -> Option<&[u8]> {
        self.found().map(|found| &*found.bits)
    }

    fn found(&self) -> Option<&Found> {
        static FOUND: OfEdges<Option<Found>, Option<Found>> = (obtuse_triangles, obtuse_triangles);
        kept(&self.shared.obtuse.found, || of_edges(self, FOUND)).as_ref()
    }

    /// Returns the points with obtuse triangles in part of a row or column of the bordered array, by their places in
    /// this row or column.
    #[doc(hidden)]
    pub fn obtuse_points(&self, by_rows: bool, line: usize, range: Range<usize>) -> &[u32] {
        self.found().map_or(&[], |found| found.lines[usize::from(!by_rows)].within(line, range))
    }

    /// Returns whether any of a row's points in `cols` has obtuse triangles.
    #[doc(hidden)]
    pub fn has_obtuse_points(&self, row: usize, cols: Range<usize>) -> bool {
        !self.obtuse_points(true, row + 1, cols.start + 1..cols.end + 1).is_empty()
    }

    /// Returns the number of points with obtuse triangles.
    pub(super) fn obtuse_count(&self) -> usize {
        self.found().map_or(0, |found| found.lines[0].places.len())
    }

    /// Returns the largest distance, in rows and columns, from which an update reads a point. It is 1 on surfaces without
    /// obtuse triangles.
    #[doc(hidden)]
    pub fn reach(&self) -> usize {
        let Some(Found { needed, .. }) = self.found() else { return 1 };
        // Beyond its seams, the grid of a glued surface goes on by as many lines as splits usually need.
        if self.shared.of_glued { SPLIT_REACH as usize } else { of_updates(*needed) }
    }

    /// Returns whether the surface has triangles that are obtuse at the point that is updated from them.
    /// Steep surfaces and sheared grids have some.
    pub fn has_obtuse_triangles(&self) -> bool {
        self.obtuse_triangles().is_some()
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
            let triangles = RowOfTriangles { edges, row, first, line: &mut *line };
            if is_slowed {
                Instructions::best().run(Slowed(triangles));
            } else {
                Instructions::best().run(Plain(triangles));
                edges.leave_obtuse((row, first), line);
            }
            places.extend(marked(line).map(|col| (first + col) as u32 + 1));
        }
        places
    };
    let rows: Vec<Vec<u32>> = chart.rows_mut(&mut triangles).enumerate().map(in_row).collect();
    rows.iter().any(|row| !row.is_empty()).then(|| {
        let needed = rows.par_iter().enumerate().map(|(row, places)| {
            let places = places.iter().map(|&place| chart.bordered(row, place as usize - 1));
            places.map(|point| edges.reach_of(point, triangles[point])).max().unwrap_or(1)
        });
        let needed = needed.max().unwrap_or(1);
        let by_row = Lines::of(&rows);
        let by_col = by_row.turned(chart.stride());
        Found { bits: triangles, lines: [by_row, by_col], needed }
    })
}

impl<R: Real> EdgeLengths<R> {
    /// Returns the largest reach of the splits of a point's obtuse triangles.
    fn reach_of(&self, point: usize, obtuse: u8) -> usize {
        let around = |to: Direction| {
            let at = self.chart().offset(to).from(point);
            let lengths = [(point, to), (point, to.next()), (at, to.base())]
                .map(|(from, to)| self.along(from, to.step()));
            let squares = lengths.map(|length| length * length);
            reach([to, to.next()].map(Direction::vector), squares)
        };
        let is_obtuse = |to: &Direction| obtuse >> *to as u8 & 1 != 0;
        Direction::ALL.into_iter().filter(is_obtuse).map(around).max().unwrap_or(1)
    }
}

impl<R: Real> EdgeLengths<R> {
    /// Clears, for some points of a row, the marks of triangles that are not obtuse by the computation that updates
    /// use.
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

/// The triangles of points of a row, from `first` on, and the line in which obtuse ones are marked.
struct RowOfTriangles<'a, R> {
    edges: &'a EdgeLengths<R>,
    row: usize,
    first: usize,
    line: &'a mut [u8],
}

/// The loop that marks the triangles that may be obtuse. Its limit errs towards too many triangles, to allow for
/// rounding.
struct Plain<'a, R>(RowOfTriangles<'a, R>);

impl<R: Real> Loop for Plain<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let RowOfTriangles { edges, row, first, line } = self.0;
        let points = line.len();
        let [fan, bases] = edges.fans(row, first..first + points);
        let limit = R::of(1.001 * OBTUSE);
        line.fill(0);
        // Directions are taken one after another, so that points become SIMD lanes.
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

/// The loop that finds the obtuse triangles where edges are weighted by a slowness. It is a separate loop so that both
/// are vectorized.
struct Slowed<'a, R>(RowOfTriangles<'a, R>);

impl<R: Real> Loop for Slowed<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let RowOfTriangles { edges, row, first, line } = self.0;
        let cols = first..first + line.len();
        let [fan, bases] = edges.fans(row, cols.clone());
        let Some((own, around)) = edges.fan_slowness(row, cols) else { return };
        for (col, bits) in line.iter_mut().enumerate() {
            let mut found = 0;
            for to in 0..8 {
                let next = ring::next(to);
                let (own, first, second) = (own[col], around[to][col], around[next][col]);
                // These are halves of the lengths on the surface.
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
    use crate::builtin::Builtin;
    use crate::obtuse::cells::CELLS;
    use crate::obtuse::lists::ObtuseTriangles;
    use crate::{Spacing, Surface};

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
            assert_eq!(edges.has_obtuse_triangles(), expected);
            assert_eq!(told, expected.then(|| edges.reach()));
            // The full search agrees with the search during measurement.
            assert_eq!(obtuse_triangles(&edges).is_some(), expected);
        }
    }

    #[test]
    fn marked_cells_have_all_obtuse_triangles() {
        // Steps across the border between two groups of cells that are marked together, and steps at the grid's border.
        for places in [[(5, CELLS), (20, 2 * CELLS - 1)], [(0, 0), (39, 2 * CELLS + 6)]] {
            let (rows, cols) = (40, 2 * CELLS + 7);
            let mut heights = vec![0.0; rows * cols];
            for (row, col) in places {
                // The edge between both points is so long that the angles opposite to it are obtuse.
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
            assert_eq!(found.bits, expected.bits);
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
