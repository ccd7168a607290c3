//! A line of points and what its update needs of it and of the lines behind: of all its points, and
//! of stretches of them.

use super::settled::Visited;
use crate::lanes::prefetch;
use crate::surface::{Real, min};
use crate::update::{Bends, Triangle};

/// A stretch of n points of a row or column and what their update needs. Curvatures are empty
/// unless the wavefront is curved.
pub(super) struct Line<'a, R> {
    pub times: Times<'a, R>,
    /// Curvature of the fronts, n of them.
    pub curvatures: &'a mut [R],
    /// Gaussian curvature of the surface.
    pub gaussian: &'a [R],
    /// Both at the points behind, n + 2 of them, as in [`Times`].
    pub curvatures_behind: &'a [R],
    pub gaussian_behind: &'a [R],
    /// From here to the line that is updated next.
    pub next: isize,
}

/// Arrival times along a line and behind it, and the triangles between them.
pub(super) struct Times<'a, R> {
    /// Arrival times, n of them.
    pub here: &'a mut [R],
    /// Those of the line that the scan has just passed, from the point before the first to the one
    /// after the last: n + 2 of them.
    pub behind: &'a [R],
    /// Lengths of the edges to the neighbours behind: the one before, this one, the one after.
    pub edges: [&'a [R]; 3],
    /// Lengths of the edges between the points behind, n + 1 of them.
    pub bases: &'a [R],
}

/// Curvatures around part of a line: of the surface, and of fronts and surface behind, as in [`Line`].
pub(super) struct Bent<'a, R> {
    pub gaussian: &'a [R],
    pub fronts_behind: &'a [R],
    pub gaussian_behind: &'a [R],
}

impl<R: Real> Bent<'_, R> {
    /// Those of one of the two triangles of point i.
    #[inline(always)]
    pub(super) fn around<const LEFT: bool>(&self, i: usize, alone: bool) -> Bends<R> {
        let (k, g) = (self.fronts_behind, self.gaussian_behind);
        let x1 = if LEFT { i } else { i + 1 };
        let surface = [self.gaussian[i], g[x1], g[x1 + 1]];
        Bends { fronts: [k[x1], k[x1 + 1]], surface, alone }
    }
}

impl<R: Real> Line<'_, R> {
    /// Asks for what the next line's update needs from some point on. The machine foresees only what
    /// follows within a page, and a line is about as long as that.
    #[inline(always)]
    pub(super) fn prefetch_next(&self, start: usize) {
        let place = self.next + start as isize;
        let Times { here, edges, bases, .. } = &self.times;
        prefetch(here, place);
        edges.iter().for_each(|edges| prefetch(edges, place));
        prefetch(bases, place);
        if !self.curvatures.is_empty() {
            prefetch(self.curvatures, place);
            prefetch(self.gaussian, place);
        }
    }
}

/// Part of a line, cut so that the compiler sees that all indices are within bounds.
pub(super) struct Stretch<'a, R> {
    pub times: &'a mut [R],
    pub behind: &'a [R],
    pub before: &'a [R],
    pub middle: &'a [R],
    pub after: &'a [R],
    pub bases: &'a [R],
}

impl<R: Real> Times<'_, R> {
    #[inline(always)]
    pub(super) fn stretch(&mut self, start: usize, points: usize) -> Stretch<'_, R> {
        Stretch {
            times: &mut self.here[start..][..points],
            behind: &self.behind[start..][..points + 2],
            before: &self.edges[0][start..][..points],
            middle: &self.edges[1][start..][..points],
            after: &self.edges[2][start..][..points],
            bases: &self.bases[start..][..points + 1],
        }
    }
}

impl<R: Real> Stretch<'_, R> {
    /// Whether there is no point beside point i behind; see [`Bends`].
    #[inline(always)]
    pub(super) fn is_alone(&self, i: usize) -> bool {
        self.middle[i] >= R::FAR
    }

    /// The triangle with the points behind before and beside point i.
    #[inline(always)]
    pub(super) fn left(&self, i: usize) -> Triangle<R> {
        Triangle {
            t1: self.behind[i],
            t2: self.behind[i + 1],
            l1: self.before[i],
            l2: self.middle[i],
            c: self.bases[i],
        }
    }

    /// The triangle with the points behind beside and after point i.
    #[inline(always)]
    pub(super) fn right(&self, i: usize) -> Triangle<R> {
        Triangle {
            t1: self.behind[i + 1],
            t2: self.behind[i + 2],
            l1: self.middle[i],
            l2: self.after[i],
            c: self.bases[i + 1],
        }
    }

    /// One of both.
    #[inline(always)]
    pub(super) fn triangle<const LEFT: bool>(&self, i: usize) -> Triangle<R> {
        if LEFT { self.left(i) } else { self.right(i) }
    }

    /// The same, x1 being the point behind beside point i.
    #[inline(always)]
    pub(super) fn turned<const LEFT: bool>(&self, i: usize) -> Triangle<R> {
        if !LEFT {
            return self.right(i);
        }
        let Triangle { t1, t2, l1, l2, c } = self.left(i);
        Triangle { t1: t2, t2: t1, l1: l2, l2: l1, c }
    }

    /// Whether nothing behind is earlier than any point.
    #[inline(always)]
    pub(super) fn leads(&self, points: usize) -> bool {
        let mut leads = true;
        for i in 0..points {
            let behind = min(self.behind[i], min(self.behind[i + 1], self.behind[i + 2]));
            leads &= behind >= self.times[i];
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

    /// Whether fronts arrive behind first before the first of some points, not after the last.
    #[inline(always)]
    pub(super) fn comes_from_left(&self, points: usize) -> bool {
        self.behind[0] <= self.behind[points + 1]
    }

    /// Point i before its update, with the curvatures of the fronts behind it.
    #[inline(always)]
    pub(super) fn visited(&self, i: usize, [before, beside, after]: [R; 3]) -> Visited<R> {
        let Triangle { t1, t2, l1, l2, c } = self.right(i);
        Visited {
            now: self.times[i],
            triangles: [self.left(i), Triangle { t1: t2, t2: t1, l1: l2, l2: l1, c }],
            curvatures: [[before, beside], [after, beside]],
        }
    }
}
