//! The update of one line of points from the line behind it: what rotated scans are made of.
//!
//! The loop has no branch, so that the compiler turns points into lanes; see [`Work`].

use super::settled::{Visited, stays};
use super::state::accept;
use super::tiles::{Scan, TILE};
use super::{Instructions, bend_units};
use crate::lanes::Work;
use crate::surface::{Real, min};
use crate::update::{Bends, Front, Triangle, Wavefront, curved, planar, point_source};

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

/// How points are updated: `renews` curved fronts that the scan has brought before, or not.
#[derive(Clone, Copy, Debug)]
pub(super) struct How {
    pub wavefront: Wavefront,
    pub scan: Scan,
    pub renews: bool,
    pub instructions: Instructions,
}

/// The update of a line by a scan, and where to mark which stretches of [`TILE`] points it has
/// changed.
pub(super) struct Update<'a, R> {
    pub line: Line<'a, R>,
    pub how: How,
    pub changed: &'a mut [bool],
}

/// What updates have come to: the largest change ([`Real::units_between`]), and how many points
/// have been updated. Those that are settled have not.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Updated<B> {
    pub largest: B,
    pub points: u64,
}

impl<B: Ord> Updated<B> {
    #[inline(always)]
    pub(super) fn and(self, other: Self) -> Self {
        Self { largest: self.largest.max(other.largest), points: self.points + other.points }
    }
}

impl<R: Real> Work for Update<'_, R> {
    type Output = Updated<R::Bits>;

    #[inline(always)]
    fn run(self) -> Updated<R::Bits> {
        let Self { line, how, changed } = self;
        match how.wavefront {
            Wavefront::Planar => each_tile::<R, Straight<false>>(line, how, changed),
            Wavefront::PointSource => each_tile::<R, Straight<true>>(line, how, changed),
            Wavefront::Curved => each_tile::<R, Curved>(line, how, changed),
        }
    }
}

/// Updates each stretch of [`TILE`] points; the last one overlaps the one before if the line has a
/// remainder, which does no harm: what has been updated stays as it is.
#[inline(always)]
fn each_tile<R: Real, K: Kernel>(
    mut line: Line<R>,
    how: How,
    changed: &mut [bool],
) -> Updated<R::Bits> {
    let points = line.times.here.len();
    let mut updated = Updated::default();
    for (tile, changed) in changed.iter_mut().enumerate() {
        let (start, count) = match points.checked_sub(TILE) {
            Some(last) => ((tile * TILE).min(last), TILE),
            None => (0, points),
        };
        let Some(change) = K::update(&mut line, start, count, how) else { continue };
        *changed |= change.any;
        let of_tile = (points - tile * TILE).min(TILE) as u64;
        updated = updated.and(Updated { largest: change.largest, points: of_tile });
    }
    updated
}

/// The update of a stretch of a line by a scan, which may renew fronts; `None` if all its points are
/// settled.
trait Kernel {
    fn update<R: Real>(
        line: &mut Line<R>,
        start: usize,
        points: usize,
        how: How,
    ) -> Option<Change<R>>;
}

/// What an update has changed: anything at all, tags included, and how much
/// ([`Real::units_between`]).
struct Change<R: Real> {
    any: bool,
    largest: R::Bits,
}

/// Fronts that need no curvature: circular or straight.
struct Straight<const CIRCULAR: bool>;

impl<const CIRCULAR: bool> Kernel for Straight<CIRCULAR> {
    #[inline(always)]
    fn update<R: Real>(
        line: &mut Line<R>,
        start: usize,
        points: usize,
        _: How,
    ) -> Option<Change<R>> {
        let line = line.times.stretch(start, points);
        let mut settled = true;
        for i in 0..points {
            let wavefront = if CIRCULAR { Wavefront::PointSource } else { Wavefront::Planar };
            settled &= stays(wavefront, line.visited(i, [R::zero(); 3]));
        }
        if settled {
            return None;
        }
        let mut largest = R::Bits::default();
        for i in 0..points {
            let (left, right) = (line.left(i), line.right(i));
            let (a, b) = if CIRCULAR {
                (point_source(left), point_source(right))
            } else {
                (planar(left), planar(right))
            };
            let old = line.times[i];
            line.times[i] = min(old, min(a, b));
            largest = largest.max(old.units_between(line.times[i]));
        }
        Some(Change { any: largest > R::Bits::default(), largest })
    }
}

struct Curved;

impl Kernel for Curved {
    #[inline(always)]
    fn update<R: Real>(
        line: &mut Line<R>,
        start: usize,
        points: usize,
        how: How,
    ) -> Option<Change<R>> {
        let curvatures = &mut line.curvatures[start..][..points];
        let gaussian = &line.gaussian[start..][..points];
        let k = &line.curvatures_behind[start..][..points + 2];
        let g = &line.gaussian_behind[start..][..points + 2];
        let line = line.times.stretch(start, points);
        let mut settled = true;
        for i in 0..points {
            let renewed = how.renews & (curvatures[i].tag() == how.scan.0);
            let visited = line.visited(i, [k[i], k[i + 1], k[i + 2]]);
            settled &= stays(Wavefront::Curved, visited) & !renewed;
        }
        if settled {
            return None;
        }
        let [mut largest, mut bent, mut tagged] = [R::Bits::default(); 3];
        for i in 0..points {
            let left = Bends { fronts: [k[i], k[i + 1]], surface: [gaussian[i], g[i], g[i + 1]] };
            let right =
                Bends { fronts: [k[i + 1], k[i + 2]], surface: [gaussian[i], g[i + 1], g[i + 2]] };
            let first = Front::first(curved(line.left(i), left), curved(line.right(i), right));
            let (time, curvature) = (line.times[i], curvatures[i]);
            (line.times[i], curvatures[i]) = accept(time, curvature, first, how.scan.0, how.renews);
            largest = largest.max(time.units_between(line.times[i]));
            // As whole numbers, whose maximum compilers find in lanes.
            let bend = (curvatures[i] - curvature).abs() * line.times[i];
            bent = bent.max(R::zero().units_between(bend));
            tagged = tagged.max(curvature.units_between(curvatures[i]));
        }
        let any = largest.max(tagged) > R::Bits::default();
        Some(Change { any, largest: largest.max(bend_units(R::from_zero(bent))) })
    }
}

/// Part of a line, cut so that the compiler sees that all indices are within bounds.
struct Stretch<'a, R> {
    times: &'a mut [R],
    behind: &'a [R],
    before: &'a [R],
    middle: &'a [R],
    after: &'a [R],
    bases: &'a [R],
}

impl<R: Real> Times<'_, R> {
    #[inline(always)]
    fn stretch(&mut self, start: usize, points: usize) -> Stretch<'_, R> {
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
    /// The triangle with the points behind before and beside point i.
    #[inline(always)]
    fn left(&self, i: usize) -> Triangle<R> {
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
    fn right(&self, i: usize) -> Triangle<R> {
        Triangle {
            t1: self.behind[i + 1],
            t2: self.behind[i + 2],
            l1: self.middle[i],
            l2: self.after[i],
            c: self.bases[i + 1],
        }
    }

    /// Point i before its update, with the curvatures of the fronts behind it.
    #[inline(always)]
    fn visited(&self, i: usize, [before, beside, after]: [R; 3]) -> Visited<R> {
        let Triangle { t1, t2, l1, l2, c } = self.right(i);
        Visited {
            now: self.times[i],
            triangles: [self.left(i), Triangle { t1: t2, t2: t1, l1: l2, l2: l1, c }],
            curvatures: [[before, beside], [after, beside]],
        }
    }
}
