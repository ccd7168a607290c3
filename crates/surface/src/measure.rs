//! Measures the edges of a row of points in SIMD lanes. The twin of `glsl/passes/edges.glsl`.
//!
//! The loops have no branches, so that the compiler vectorizes them; see [`Loop`].

use super::Surface;
use super::arc::{arc, bends, end_bend, normal};
use super::chart::{Direction, STORED};
use super::geometry::{Geometry, Heights, Metric, Positions, Space};
use super::points::Row;
use super::real::{LONGEST_EDGE, Real, SHORTEST_EDGE, max};
use crate::lanes::{Instructions, Loop};

/// Index of the current row among the four rows of bends.
const HERE: usize = 2;

/// Number of points that are measured together, in local arrays that the compiler knows not to overlap.
const SPAN: usize = 32;

/// The bends of a surface at the points of a row, with an additional point at each end.
pub(super) struct RowBends<R> {
    /// Bends along the lines of [`STORED`]; [`Real::FAR`] where a neighbour on the line is missing.
    along: [Vec<R>; 4],
    /// Unit normals; zero where there is none.
    normals: [Vec<R>; 3],
}

impl<R: Real> RowBends<R> {
    /// Returns bends and normals of zero for a row of `points` points. With them edges are measured as chords.
    pub(super) fn none(points: usize) -> Self {
        let zeros = || vec![R::zero(); points + 2];
        Self { along: [(); 4].map(|_| zeros()), normals: [(); 3].map(|_| zeros()) }
    }

    /// Returns the bends along a line and the normals of `points` points. The index `first` counts from the
    /// point before the row's first one.
    #[inline(always)]
    fn part(&self, line: usize, first: usize, points: usize) -> [&[R]; 4] {
        let [x, y, z] = &self.normals;
        [&self.along[line], x, y, z].map(|values| &values[first..][..points])
    }
}

/// Runs a loop in the space in which the points of a surface lie.
macro_rules! run_in_space {
    ($surface:expr, |$space:ident| $loop:expr) => {{
        macro_rules! run {
            ($in:expr) => {{
                let $space = $in;
                Instructions::best().run($loop)
            }};
        }
        match $surface.geometry() {
            Geometry::Positions(_) if $surface.has_corners() => run!(Positions::<true>),
            Geometry::Positions(_) => run!(Positions::<false>),
            Geometry::Heights { spacing, .. } => {
                run!(Heights { dx: R::of(spacing.dx), dy: R::of(spacing.dy) })
            }
            Geometry::Metric(_) => run!(Metric),
        }
    }};
}

impl Surface {
    /// Computes the bends at the points of a row, from the row before, the row itself and the row after.
    pub(super) fn bend_row<R: Real>(&self, rows: [&Row<R>; 3], bends: &mut RowBends<R>) {
        run_in_space!(self, |space| Bend { space, rows, bends });
    }

    /// Computes the lengths of the edges stored at the points of a row. `rows` are the row before and the row
    /// itself. `bends` are the bends of four rows: the row before these two, these two, and the row after.
    /// Returns whether a length may be too short or too long.
    pub(super) fn measure_row<R: Real>(
        &self,
        rows: [&Row<R>; 2],
        bends: [&RowBends<R>; 4],
        lengths: &mut [Vec<R>; 4],
    ) -> bool {
        run_in_space!(self, |space| Measure { space, rows, bends, lengths })
    }
}

/// Returns the values of point `i` in four arrays.
#[inline(always)]
fn at<R: Real>([a, b, c, d]: [&[R]; 4], i: usize) -> [R; 4] {
    [a[i], b[i], c[i], d[i]]
}

/// Returns whether a length is within the limits and not zero.
#[inline(always)]
fn is_usual<R: Real>(length: R) -> bool {
    (length > R::of(SHORTEST_EDGE)) & (length < R::of(LONGEST_EDGE))
}

/// Returns the first point of each span of a row. If the row has a remainder, the last span overlaps
/// the one before it.
#[inline(always)]
fn spans(points: usize) -> impl Iterator<Item = usize> {
    let last = points.saturating_sub(SPAN);
    (0..points.div_ceil(SPAN)).map(move |k| (k * SPAN).min(last))
}

/// The loop that computes the bends at a row of points.
struct Bend<'a, R, S> {
    space: S,
    rows: [&'a Row<R>; 3],
    bends: &'a mut RowBends<R>,
}

impl<R: Real, S: Space<R>> Loop for Bend<'_, R, S> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let points = self.rows[1].len();
        for start in spans(points) {
            if points < SPAN {
                self.span(start, points);
            } else {
                self.span(start, SPAN);
            }
        }
    }
}

impl<R: Real, S: Space<R>> Bend<'_, R, S> {
    #[inline(always)]
    fn span(&mut self, start: usize, points: usize) {
        let rows = [
            self.rows[0].window(start, points),
            self.rows[1].window(start, points),
            self.rows[2].window(start, points),
        ];
        let mut found = [[R::zero(); SPAN]; 4];
        let mut normals = [[R::zero(); SPAN]; 3];
        for i in 0..points.min(SPAN) {
            let here = rows[1].at(i + 1);
            let mut ways = [[R::zero(); 3]; 8];
            let mut there = [false; 8];
            for k in 0..8 {
                let step = Direction::ALL[k].step();
                let point = rows[1usize.wrapping_add_signed(step.0)]
                    .at((i + 1).wrapping_add_signed(step.1));
                let way = self.space.difference(here, point, step);
                there[k] = point[3] > R::zero();
                for axis in 0..3 {
                    ways[k][axis] = if there[k] { way[axis] } else { R::zero() };
                }
            }
            let normal = normal::<R, S>(ways);
            let bends = bends::<R, S>(ways, there, normal);
            for k in 0..4 {
                found[k][i] = bends[k];
            }
            for axis in 0..3 {
                normals[axis][i] = normal[axis];
            }
        }
        let RowBends { along, normals: kept } = &mut *self.bends;
        let pairs = along.iter_mut().zip(&found).chain(kept.iter_mut().zip(&normals));
        for (row, found) in pairs {
            row[start + 1..][..points].copy_from_slice(&found[..points]);
        }
    }
}

/// The loop that computes the lengths of the edges stored at a row of points.
struct Measure<'a, R, S> {
    space: S,
    /// The row before and the row itself.
    rows: [&'a Row<R>; 2],
    /// The bends of the second row before, the row before, the row itself and the row after.
    bends: [&'a RowBends<R>; 4],
    lengths: &'a mut [Vec<R>; 4],
}

impl<R: Real, S: Space<R>> Loop for Measure<'_, R, S> {
    /// Whether an edge may be too short or too long.
    type Output = bool;

    #[inline(always)]
    fn run(mut self) -> bool {
        let points = self.rows[1].len();
        let mut suspicious = false;
        for start in spans(points) {
            suspicious |=
                if points < SPAN { self.span(start, points) } else { self.span(start, SPAN) };
        }
        suspicious
    }
}

impl<R: Real, S: Space<R>> Measure<'_, R, S> {
    #[inline(always)]
    fn span(&mut self, start: usize, points: usize) -> bool {
        let mut found = [[R::FAR; SPAN]; 4];
        // Constant directions: with steps unknown at compile time, the compiler does not vectorize the loop.
        let mut suspicious = self.line::<0>(start, points, &mut found[0]);
        suspicious |= self.line::<1>(start, points, &mut found[1]);
        suspicious |= self.line::<2>(start, points, &mut found[2]);
        suspicious |= self.line::<3>(start, points, &mut found[3]);
        for (lengths, found) in self.lengths.iter_mut().zip(&found) {
            lengths[start..][..points].copy_from_slice(&found[..points]);
        }
        suspicious
    }

    /// Measures the edges of a span along one of the lines of [`STORED`]. Returns whether a length may be
    /// too short or too long.
    #[inline(always)]
    fn line<const LINE: usize>(&self, start: usize, points: usize, found: &mut [R; SPAN]) -> bool {
        let (step, points) = (STORED[LINE].step(), points.min(SPAN));
        let ((down, right), diagonal) = (step, STORED[LINE].is_diagonal());
        // Indices count from the point before the row's first one.
        let (here, there) = (start + 1, (start + 1).wrapping_add_signed(right));
        let [before, own] = self.rows;
        let [a, b] = [own.part(here, points), self.row(down).part(there, points)];
        let [beside, above] = [own.part(there, points)[3], before.part(here, points)[3]];
        let bent = [self.bends[HERE], self.bends[HERE.wrapping_add_signed(down)]];
        let [of_a, of_b] = [bent[0].part(LINE, here, points), bent[1].part(LINE, there, points)];
        let (mut suspicious, mut ends) = (0, 0);
        for i in 0..points {
            let (from, to) = (at(a, i), at(b, i));
            let third = (beside[i] > R::zero()) | (above[i] > R::zero());
            let exists = (from[3] > R::zero()) & (to[3] > R::zero()) & (!diagonal | third);
            let ([bend_a, normal_a @ ..], [bend_b, normal_b @ ..]) = (at(of_a, i), at(of_b, i));
            let chord = self.space.separation(from, to, step);
            let length = arc::<R, S>(chord, [bend_a, bend_b], [normal_a, normal_b]);
            let length = R::of(0.5) * (from[3] + to[3]) * length;
            found[i] = if exists { length } else { R::FAR };
            suspicious |= u32::from(exists & !is_usual(length));
            ends |= u32::from(exists & (max(bend_a, bend_b) >= R::FAR));
        }
        if ends != 0 {
            suspicious |= u32::from(self.measure_ends(LINE, start, &mut found[..points]));
        }
        suspicious != 0
    }

    /// Returns the row of points that lies `down` rows below this one.
    #[inline(always)]
    fn row(&self, down: isize) -> &Row<R> {
        self.rows[1usize.wrapping_add_signed(down)]
    }

    /// Measures again, one by one, the few edges of a span that lie at an end of their grid line. Returns
    /// whether a length may be too short or too long.
    #[inline(never)]
    fn measure_ends(&self, k: usize, start: usize, found: &mut [R]) -> bool {
        let (down, right) = STORED[k].step();
        let mut suspicious = false;
        for (i, found) in found.iter_mut().enumerate() {
            // The bend `steps` points along the line from this point.
            let bend = |steps: isize| {
                let row = &self.bends[HERE.wrapping_add_signed(steps * down)].along[k];
                row[(start + i + 1).wrapping_add_signed(steps * right)]
            };
            let bends = [bend(0), bend(1)];
            if *found >= R::FAR || max(bends[0], bends[1]) < R::FAR {
                continue;
            }
            // A point that has a bend has another point beyond it.
            let at_end = |next: R, steps: isize| {
                if next < R::FAR { end_bend(next, bend(steps)) } else { R::zero() }
            };
            let a = if bends[0] < R::FAR { bends[0] } else { at_end(bends[1], 2) };
            let b = if bends[1] < R::FAR { bends[1] } else { at_end(bends[0], -1) };
            let (here, there) = (start + i, (start + i).wrapping_add_signed(right));
            let point = |row: isize, col: usize| at(self.row(row).part(col + 1, 1), 0);
            let (from, to) = (point(0, here), point(down, there));
            let normal = |row: usize, col: usize| {
                let [_, normal @ ..] = at(self.bends[row].part(k, col + 1, 1), 0);
                normal
            };
            let normals = [normal(HERE, here), normal(HERE.wrapping_add_signed(down), there)];
            let chord = self.space.separation(from, to, (down, right));
            let length = arc::<R, S>(chord, [a, b], normals);
            *found = R::of(0.5) * (from[3] + to[3]) * length;
            suspicious |= !is_usual(*found);
        }
        suspicious
    }
}
