//! Splits obtuse triangles by grid points beyond their bases (paper, end of section 3, after Kimmel and
//! Sethian). The twin of `glsl/update/splits.glsl`.
//!
//! A front that runs through a triangle with an obtuse angle at x0 may reach x0 before it reaches one end of
//! the base. Then points depend on one another in a cycle. The result depends on the order of updates, and
//! where fronts meet, they pass on arrival times that are too early. So an obtuse triangle is not used for
//! updates; only its edges are. Instead, the triangles beyond its base are unfolded into its plane, one after
//! another, until a grid point lies between both edges. That point splits the triangle in two. At most one
//! part is obtuse, and it is split again. Where a hole or the border ends the unfolding first, no path from
//! any grid point comes through the remaining part, and it is not used either.

use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

use super::chart::{Chart, Direction, EdgeSlot, STORED, ring};
use super::edges::EdgeLengths;
use super::real::{Real, max, min};
use crate::constants::{EVEN_SLOWNESS, OBTUSE, SPLIT_MARGIN, SPLIT_REACH, SPLIT_STEPS};
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
    /// Where to search, if that is known.
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
    /// Returns the lists of `lines`, in their order, and empty ones for two border lines before and after them.
    fn of(lines: &[Vec<u32>]) -> Self {
        let (mut starts, mut places) = (vec![0, 0], Vec::new());
        for line in lines {
            places.extend(line);
            starts.push(places.len() as u32);
        }
        starts.push(places.len() as u32);
        Self { starts, places }
    }

    /// Returns the same points by the lines across, of which there are `lines`.
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
        if let Some(found) = self.obtuse.found.get() {
            return found.as_ref();
        }
        // Computed outside the lock: a thread that waits for others here may take up work that needs the
        // result too.
        let found = obtuse_triangles(self);
        self.obtuse.found.get_or_init(|| found).as_ref()
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

    /// Returns the length on the surface of the edge from a point of the bordered array to the neighbour at a
    /// step of rows and columns.
    #[inline(always)]
    fn along(&self, point: usize, (down, right): Step) -> R {
        if down.unsigned_abs().max(right.unsigned_abs()) > 1 {
            return R::FAR;
        }
        let Some((stored, is_of_neighbour)) = STORED_AT[(3 * down + right + 4) as usize] else {
            return R::FAR;
        };
        let step = down * self.chart().stride() as isize + right;
        let length =
            self.at(point, EdgeSlot { stored, offset: if is_of_neighbour { step } else { 0 } });
        let Some(slowness) = self.slowness().filter(|_| length < R::FAR) else { return length };
        let there = point.wrapping_add_signed(step);
        (length + length) / (slowness[point] + slowness[there])
    }

    /// Splits a point's triangle between two neighbours in successive directions, if it is obtuse. Calls
    /// `part` for each part with three arguments: the indices of its two other corners in the bordered array;
    /// the lengths of x0 x1, x0 x2 and x1 x2 in the plane; and the slowness by which they are weighted at x0,
    /// x1 and x2.
    ///
    /// A part may cover several cells, whose slowness may differ from that at its corners. If the slowness
    /// jumps there, the largest slowness seen in the search for the part counts, so that no front walks
    /// through slow regions.
    pub(crate) fn split(
        &self,
        x0: usize,
        directions: [Direction; 2],
        mut part: impl FnMut([usize; 2], [R; 3], [R; 3]),
    ) {
        let chart = self.chart();
        // The first direction is the same whichever scan asks.
        let [first, second] = directions;
        let [a, b] = if first.next() == second { directions } else { [second, first] };
        let base = (b.step().0 - a.step().0, b.step().1 - a.step().1);
        let point_at =
            |(down, right): Step| x0.wrapping_add_signed(down * chart.stride() as isize + right);
        let [la, lb, c] = [
            self.along(x0, a.step()),
            self.along(x0, b.step()),
            self.along(point_at(a.step()), base),
        ];
        if max(la, max(lb, c)) >= R::FAR {
            return;
        }
        // x0 is the origin, and x1 lies on the first axis.
        let x = R::of(0.5) * (la * la + lb * lb - c * c) / la;
        let height_squared = lb * lb - x * x;
        if !(height_squared > R::zero() && is_obtuse(la * la / (c * c), lb * lb / (c * c))) {
            return;
        }
        let mut wedge = [
            Unfolded { step: a.step(), place: [la, R::zero()] },
            Unfolded { step: b.step(), place: [x, height_squared.sqrt()] },
        ];
        let slowness_at = |point: usize| self.slowness().map_or(R::one(), |of| of[point]);
        let ends =
            [slowness_at(x0), slowness_at(point_at(a.step())), slowness_at(point_at(b.step()))];
        let mut range = [min(ends[0], min(ends[1], ends[2])), max(ends[0], max(ends[1], ends[2]))];
        let mut tell = |[a, b]: [Unfolded<R>; 2], [least, largest]: [R; 2]| {
            let corners = [a, b].map(|end| point_at(end.step));
            let squares = [a.squared(), b.squared(), a.squared_to(&b)];
            let lengths = squares.map(|square| square.sqrt());
            if self.slowness().is_none() {
                return part(corners, lengths, [R::one(); 3]);
            }
            let jumps = largest > R::of(EVEN_SLOWNESS) * least;
            let known = [x0, corners[0], corners[1]].map(slowness_at);
            let [s0, s1, s2] = if jumps { [largest; 3] } else { known };
            let half = R::of(0.5);
            let [l1, l2, c] = lengths;
            let weighted = [half * (s0 + s1) * l1, half * (s0 + s2) * l2, half * (s1 + s2) * c];
            part(corners, weighted, [s0, s1, s2]);
        };
        // The edge beyond which the next point is searched. As seen from x0, its first end is to the right.
        let mut edge = wedge;
        // The sense of the quarter turn that turns an edge to point away from x0.
        let turn = if base.1 * a.step().0 - base.0 * a.step().1 > 0 { 1 } else { -1 };
        for _ in 0..SPLIT_STEPS {
            let Some(apex) = self.beyond(edge, turn, wedge, point_at) else { return };
            let of_apex = slowness_at(point_at(apex.step));
            range = [min(range[0], of_apex), max(range[1], of_apex)];
            if !apex.follows(&wedge[0]) {
                edge[0] = apex;
                continue;
            }
            if !wedge[1].follows(&apex) {
                edge[1] = apex;
                continue;
            }
            let halves = [[wedge[0], apex], [apex, wedge[1]]];
            let obtuse = halves.map(|[a, b]| {
                let base = a.squared_to(&b);
                is_obtuse(a.squared() / base, b.squared() / base)
            });
            if !obtuse[0] {
                tell(halves[0], range);
            }
            if !obtuse[1] {
                tell(halves[1], range);
            }
            match obtuse {
                [true, _] => (wedge[1], edge[1]) = (apex, apex),
                [_, true] => (wedge[0], edge[0]) = (apex, apex),
                _ => return,
            }
        }
    }

    /// Returns the next point beyond an edge of the grid, in x0's plane. Beyond an edge along an axis there
    /// are two candidates. A candidate within the wedge is preferred, then the nearer one, then the one with
    /// the shorter sides. This choice does not depend on how the grid is numbered. Where rounding would
    /// decide, the first candidate is taken.
    fn beyond(
        &self,
        [u, w]: [Unfolded<R>; 2],
        turn: isize,
        [right, left]: [Unfolded<R>; 2],
        point_at: impl Fn(Step) -> usize,
    ) -> Option<Unfolded<R>> {
        let along = (w.step.0 - u.step.0, w.step.1 - u.step.1);
        let away = (turn * along.1, -turn * along.0);
        let is_diagonal = along.0 != 0 && along.1 != 0;
        // Beyond a diagonal, the point is halfway between both steps.
        let first =
            if is_diagonal { ((along.0 + away.0) / 2, (along.1 + away.1) / 2) } else { away };
        let second = (along.0 + away.0, along.1 + away.1);
        let base = self.along(point_at(u.step), along);
        let clearly = R::of(1.0 - SPLIT_MARGIN);
        // A candidate, whether it lies within the wedge, and the length of its sides.
        let candidate = |step: Step| {
            let from_w = (step.0 - along.0, step.1 - along.1);
            let from_x0 = (u.step.0 + step.0, u.step.1 + step.1);
            if from_x0.0.abs().max(from_x0.1.abs()) > SPLIT_REACH as isize {
                return None;
            }
            let sides = [self.along(point_at(u.step), step), self.along(point_at(w.step), from_w)];
            let place = unfolded([u.place, w.place], base, sides)?;
            let apex = Unfolded { step: from_x0, place };
            Some((apex, apex.follows(&right) && left.follows(&apex), sides[0] + sides[1]))
        };
        let best = candidate(first);
        if is_diagonal {
            return best.map(|(apex, ..)| apex);
        }
        let Some((apex, inside, around)) = candidate(second) else {
            return best.map(|(apex, ..)| apex);
        };
        let is_better = best.is_none_or(|(other, was_inside, other_around)| {
            let (squared, other) = (apex.squared(), other.squared());
            let as_near = (squared >= other * clearly) & (other >= squared * clearly);
            let nearer = if as_near { around < other_around * clearly } else { squared < other };
            if inside == was_inside { nearer } else { inside }
        });
        if is_better { Some(apex) } else { best.map(|(apex, ..)| apex) }
    }
}

/// Stored edges of the steps to neighbours, three per row: the index of the edge, and whether the neighbour
/// stores it.
const STORED_AT: [Option<(usize, bool)>; 9] = {
    let mut found = [None; 9];
    let mut stored = 0;
    while stored < STORED.len() {
        let (down, right) = STORED[stored].step();
        let along = 3 * down + right;
        found[(4 + along) as usize] = Some((stored, false));
        found[(4 - along) as usize] = Some((stored, true));
        stored += 1;
    }
    found
};

/// A step in rows and columns.
type Step = (isize, isize);

/// A grid point unfolded into the plane of x0's triangle.
#[derive(Clone, Copy, Debug)]
struct Unfolded<R> {
    /// Step from x0, in rows and columns.
    step: Step,
    place: [R; 2],
}

impl<R: Real> Unfolded<R> {
    /// Returns whether this point lies to the left of another one, seen from x0, by more than rounding can
    /// cause.
    fn follows(&self, other: &Self) -> bool {
        let across = other.place[0] * self.place[1] - other.place[1] * self.place[0];
        across > R::of(SPLIT_MARGIN) * (self.squared() + other.squared())
    }

    /// Returns the squared distance from x0.
    fn squared(&self) -> R {
        let [x, y] = self.place;
        x * x + y * y
    }

    fn squared_to(&self, other: &Self) -> R {
        let [x, y] = [self.place[0] - other.place[0], self.place[1] - other.place[1]];
        x * x + y * y
    }
}

/// Returns the place at the given distances from both ends of an edge, to the right of the edge. Returns
/// `None` if the three lengths do not make a triangle.
fn unfolded<R: Real>([u, w]: [[R; 2]; 2], base: R, [to_u, to_w]: [R; 2]) -> Option<[R; 2]> {
    if max(base, max(to_u, to_w)) >= R::FAR {
        return None;
    }
    let (per_base, half) = (R::one() / base, R::of(0.5));
    let (to_u, to_w) = (to_u * per_base, to_w * per_base);
    let foot = half * ((to_u * to_u - to_w * to_w) + R::one());
    let height_squared = (to_u - foot) * (to_u + foot);
    // The value is NaN where lengths are NaN.
    if height_squared.is_nan() || height_squared <= R::zero() {
        return None;
    }
    let (height, along) = (height_squared.sqrt(), [w[0] - u[0], w[1] - u[1]]);
    Some([u[0] + foot * along[0] + height * along[1], u[1] + foot * along[1] - height * along[0]])
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
        let ranges = match &edges.obtuse.marked {
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

/// The loop that marks the triangles of points of a row, from `first` on, that may be obtuse. Its limit errs towards too many
/// triangles, to allow for rounding.
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

/// The loop that finds the obtuse triangles of points of a row, from `first` on, where edges are weighted by a slowness. It is
/// a separate loop so that both are vectorized.
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
            let marked = edges.obtuse.marked.as_ref().unwrap();
            assert!(marked.marks.contains(&false));
            let found = edges.found().unwrap();
            let mut unmarked = edges.clone();
            unmarked.obtuse = ObtuseTriangles::default();
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
