//! Points side by side as an update sees them: what is known of them and of what lies behind.

use super::behind::Behind;
use super::settled::Visited;
use crate::lanes::prefetch;
use crate::surface::{EdgeLengths, Real, min};
use crate::update::{Carried, Triangle};

/// A stretch of points in a row or column, what lies behind each of them and the triangles between.
///
/// All slices have as many entries as there are points, or nothing in them, so that the compiler sees that indices are within
/// bounds. `C` is what fronts carry beside their arrival times, `G` what is known of the surface.
#[derive(Clone, Copy)]
pub(super) struct Stretch<'a, R, C, G> {
    pub times: &'a [R],
    pub carried: &'a [C],
    pub ground: &'a [G],
    /// At the neighbours behind: the one before, the one beside, the one after.
    pub times_behind: [&'a [R]; 3],
    pub carried_behind: [&'a [C]; 3],
    /// Lengths of the edges to them, and of those between them.
    pub edges: [&'a [R]; 3],
    pub bases: [&'a [R]; 2],
}

impl<'a, R: Real, C: Carried, G> Stretch<'a, R, C, G> {
    /// Part of it.
    #[inline(always)]
    pub(super) fn part(&self, start: usize, points: usize) -> Self {
        Self {
            times: part(self.times, start, points),
            carried: part(self.carried, start, points),
            ground: part(self.ground, start, points),
            times_behind: parts(self.times_behind, start, points),
            carried_behind: parts(self.carried_behind, start, points),
            edges: parts(self.edges, start, points),
            bases: [part(self.bases[0], start, points), part(self.bases[1], start, points)],
        }
    }

    /// Whether there is no point beside point i behind; see [`crate::update::Bends`].
    #[inline(always)]
    pub(super) fn is_alone(&self, i: usize) -> bool {
        self.edges[1][i] >= R::FAR
    }

    /// One of the two triangles of point i: with the points behind before and beside it, or with those
    /// beside and after it. Of an obtuse one the edges, if any of the stretch may be obtuse (`SPLIT`).
    #[inline(always)]
    pub(super) fn triangle<const LEFT: bool, const SPLIT: bool>(&self, i: usize) -> Triangle<R> {
        let triangle = self.weighted_triangle::<LEFT>(i);
        if SPLIT { triangle.without_obtuse_face() } else { triangle }
    }

    /// The same, obtuse or not.
    #[inline(always)]
    pub(super) fn weighted_triangle<const LEFT: bool>(&self, i: usize) -> Triangle<R> {
        let x1 = if LEFT { 0 } else { 1 };
        Triangle {
            t1: self.times_behind[x1][i],
            t2: self.times_behind[x1 + 1][i],
            l1: self.edges[x1][i],
            l2: self.edges[x1 + 1][i],
            c: self.bases[x1][i],
        }
    }

    /// The same, x1 being the point behind beside point i.
    #[inline(always)]
    pub(super) fn seen_from_beside<const LEFT: bool, const SPLIT: bool>(
        &self,
        i: usize,
    ) -> Triangle<R> {
        let triangle = self.triangle::<LEFT, SPLIT>(i);
        if LEFT { triangle.mirrored() } else { triangle }
    }

    /// Point i before its update.
    #[inline(always)]
    pub(super) fn visited<const SPLIT: bool>(&self, i: usize) -> Visited<R> {
        let triangles =
            [self.triangle::<true, SPLIT>(i), self.triangle::<false, SPLIT>(i).mirrored()];
        Visited { now: self.times[i], triangles }
    }

    /// Whether nothing behind is earlier than any point.
    #[inline(always)]
    pub(super) fn leads(&self, points: usize) -> bool {
        let [before, beside, after] = self.times_behind;
        let mut leads = true;
        for i in 0..points {
            leads &= min(before[i], min(beside[i], after[i])) >= self.times[i];
        }
        leads
    }

    /// Whether none of the points has been reached.
    #[inline(always)]
    pub(super) fn is_unreached(&self, points: usize) -> bool {
        let mut unreached = true;
        for i in 0..points {
            unreached &= self.times[i] >= R::FAR;
        }
        unreached
    }

    /// Whether a scan that renews its fronts has brought one of these.
    #[inline(always)]
    pub(super) fn is_renewed(&self, points: usize, scan: u8, renews: bool) -> bool {
        let mut renewed = false;
        for i in 0..points {
            renewed |= renews & self.carried[i].is_from(scan);
        }
        renewed
    }

    /// Whether fronts arrive behind first before the first of some points, not after the last.
    #[inline(always)]
    pub(super) fn comes_from_left(&self, points: usize) -> bool {
        self.times_behind[0][0] <= self.times_behind[2][points - 1]
    }
}

/// Part of an array, or all of it where there is nothing in it to read, which saves the checks.
#[inline(always)]
pub(super) fn part<T>(array: &[T], start: usize, points: usize) -> &[T] {
    if size_of::<T>() == 0 { array } else { &array[start..][..points] }
}

#[inline(always)]
fn parts<T>([a, b, c]: [&[T]; 3], start: usize, points: usize) -> [&[T]; 3] {
    [part(a, start, points), part(b, start, points), part(c, start, points)]
}

/// The fronts at all points that two scans start from.
#[derive(Clone, Copy)]
pub(super) struct Before<'a, R, C, G> {
    pub edges: &'a EdgeLengths<R>,
    pub times: &'a [R],
    pub carried: &'a [C],
    pub ground: &'a [G],
}

impl<'a, R: Real, C: Carried, G> Before<'a, R, C, G> {
    /// What updates of so many points in a row see, from one of the bordered array on.
    pub(super) fn stretch(
        &self,
        behind: &Behind,
        first: usize,
        points: usize,
    ) -> Stretch<'a, R, C, G> {
        let at = behind.points().map(|offset| first.wrapping_add_signed(offset));
        Stretch {
            times: part(self.times, first, points),
            carried: part(self.carried, first, points),
            ground: part(self.ground, first, points),
            times_behind: at.map(|at| part(self.times, at, points)),
            carried_behind: at.map(|at| part(self.carried, at, points)),
            edges: behind.edges().map(|slot| self.edges.row(first, slot, points)),
            bases: behind.bases().map(|slot| self.edges.row(first, slot, points)),
        }
    }
}

/// Asks for what a look at the next row of a stretch needs from some point on: the times of the row after
/// that, since those before it have been needed here.
#[inline(always)]
pub(super) fn prefetch_next_row<R: Real, C: Carried, G>(
    stretch: &Stretch<R, C, G>,
    stride: isize,
    start: usize,
    looks_at_edges: bool,
) {
    let place = stride + start as isize;
    prefetch(stretch.times, place + stride);
    prefetch(stretch.carried, place + stride);
    if looks_at_edges {
        stretch.edges.iter().for_each(|edges| prefetch(edges, place));
        prefetch(stretch.bases[1], place);
    } else {
        prefetch(stretch.ground, place);
    }
}
