//! The update of one line of points from the line behind it: what rotated scans are made of.
//!
//! The loop has no branch, so that the compiler turns points into lanes; see [`Work`].

use super::settled::{Visited, is_settled, stays};
use super::state::{accept, is_from};
use super::tiles::{Scan, TILE};
use super::{Instructions, bend_units};
use crate::lanes::{Work, prefetch};
use crate::surface::{Real, min};
use crate::update::{
    Across, Bends, Front, Triangle, Wavefront, are_two_arcs, curved, is_of_either, planar,
    point_source, two_arcs,
};

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
    /// What lies behind these; nothing beyond the border.
    pub across: Option<Beyond<'a, R>>,
    /// From here to the line that is updated next.
    pub next: isize,
}

/// The line of points two lines back, n + 2 of each, as the points behind in [`Times`].
#[derive(Clone, Copy)]
pub(super) struct Beyond<'a, R> {
    pub times: &'a [R],
    pub curvatures: &'a [R],
    /// Lengths of the edges to them from the points behind: to the one before, this one, the one after.
    pub edges: [&'a [R]; 3],
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
            Wavefront::Curved => each_tile::<R, Curved<false>>(line, how, changed),
            Wavefront::Arcs => each_tile::<R, Curved<true>>(line, how, changed),
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
    let (mut changes, mut updated) = (Changes::default(), 0);
    for (tile, changed) in changed.iter_mut().enumerate() {
        line.prefetch_next(tile * TILE);
        // Two calls, since a number of points that is known when this is compiled needs no loop.
        let any = match points.checked_sub(TILE) {
            Some(last) => K::update(&mut line, (tile * TILE).min(last), TILE, how, &mut changes),
            None => K::update(&mut line, 0, points, how, &mut changes),
        };
        let Some(any) = any else { continue };
        *changed |= any;
        updated += (points - tile * TILE).min(TILE) as u64;
    }
    Updated { largest: changes.largest(), points: updated }
}

/// The update of a stretch of a line by a scan, which may renew fronts: whether it has changed anything
/// at all, tags included; `None` if all its points are settled.
trait Kernel {
    fn update<R: Real>(
        line: &mut Line<R>,
        start: usize,
        points: usize,
        how: How,
        changes: &mut Changes<R>,
    ) -> Option<bool>;
}

/// The largest changes at the points of all stretches of a line, kept apart by their place in the
/// stretch for the sake of lanes.
struct Changes<R: Real> {
    /// Of arrival times ([`Real::units_between`]).
    times: [R::Bits; TILE],
    /// Of curvatures, times the arrival time, as numbers above zero.
    bends: [R::Bits; TILE],
}

impl<R: Real> Default for Changes<R> {
    #[inline(always)]
    fn default() -> Self {
        let none = [R::Bits::default(); TILE];
        Self { times: none, bends: none }
    }
}

impl<R: Real> Changes<R> {
    #[inline(always)]
    fn largest(&self) -> R::Bits {
        let largest = |of: [R::Bits; TILE]| of.into_iter().max().unwrap_or_default();
        largest(self.times).max(bend_units(R::from_zero(largest(self.bends))))
    }
}

/// Fronts that need no curvature: circular or straight.
struct Straight<const CIRCULAR: bool>;

impl<const CIRCULAR: bool> Straight<CIRCULAR> {
    const WAVEFRONT: Wavefront = if CIRCULAR { Wavefront::PointSource } else { Wavefront::Planar };

    /// The arrival times at points, or those through one of their two triangles where these are
    /// earlier. In an array of its own: compilers do not keep in registers what they write to a line.
    #[inline(always)]
    fn earlier<R: Real, const LEFT: bool>(
        line: &Stretch<R>,
        now: &[R; TILE],
        points: usize,
    ) -> [R; TILE] {
        let mut times = [R::zero(); TILE];
        for i in 0..points {
            let triangle = line.triangle::<LEFT>(i);
            let time = if CIRCULAR { point_source(triangle) } else { planar(triangle) };
            times[i] = min(now[i], time);
        }
        times
    }

    /// Updates points from the triangle that most of them should be reached through, and from the
    /// other unless nothing comes earlier through it.
    #[inline(always)]
    fn updated<R: Real, const FIRST_LEFT: bool, const SECOND_LEFT: bool>(
        line: &Stretch<R>,
        now: &[R; TILE],
        points: usize,
    ) -> [R; TILE] {
        let first = Self::earlier::<R, FIRST_LEFT>(line, now, points);
        let mut settled = true;
        for (i, &time) in first[..points].iter().enumerate() {
            let other = line.turned::<SECOND_LEFT>(i);
            settled &= is_settled(Self::WAVEFRONT, other, [R::zero(); 2], time);
        }
        if settled { first } else { Self::earlier::<R, SECOND_LEFT>(line, &first, points) }
    }
}

impl<const CIRCULAR: bool> Kernel for Straight<CIRCULAR> {
    #[inline(always)]
    fn update<R: Real>(
        line: &mut Line<R>,
        start: usize,
        points: usize,
        _: How,
        changes: &mut Changes<R>,
    ) -> Option<bool> {
        let line = line.times.stretch(start, points);
        if line.leads(points) {
            return None;
        }
        // Where none has been reached, something comes, and the test would be in vain.
        if !line.is_unreached(points) {
            let mut settled = true;
            for i in 0..points {
                settled &= stays(Self::WAVEFRONT, line.visited(i, [R::zero(); 3]));
            }
            if settled {
                return None;
            }
        }
        let mut now = [R::zero(); TILE];
        now[..points].copy_from_slice(line.times);
        let after = if line.comes_from_left(points) {
            Self::updated::<R, true, false>(&line, &now, points)
        } else {
            Self::updated::<R, false, true>(&line, &now, points)
        };
        let mut any = false;
        for (i, largest) in changes.times[..points].iter_mut().enumerate() {
            let change = now[i].units_between(after[i]);
            any |= change > R::Bits::default();
            *largest = change.max(*largest);
        }
        line.times.copy_from_slice(&after[..points]);
        Some(any)
    }
}

/// Fronts that carry their curvature, maybe as two arcs.
struct Curved<const ARCS: bool>;

impl<const ARCS: bool> Kernel for Curved<ARCS> {
    #[inline(always)]
    fn update<R: Real>(
        line: &mut Line<R>,
        start: usize,
        points: usize,
        how: How,
        changes: &mut Changes<R>,
    ) -> Option<bool> {
        let curvatures = &mut line.curvatures[start..][..points];
        let bent = Bent {
            gaussian: &line.gaussian[start..][..points],
            fronts_behind: &line.curvatures_behind[start..][..points + 2],
            gaussian_behind: &line.gaussian_behind[start..][..points + 2],
        };
        let across = line.across.map(|across| across.stretch(start, points));
        let line = line.times.stretch(start, points);
        let mut renewed = false;
        for curvature in curvatures.iter() {
            renewed |= how.renews & is_from(*curvature, how.scan.0);
        }
        if !renewed {
            if line.leads(points) {
                return None;
            }
            let k = bent.fronts_behind;
            let mut settled = true;
            for i in 0..points {
                let visited = line.visited(i, [k[i], k[i + 1], k[i + 2]]);
                settled &= stays(Wavefront::Curved, visited);
            }
            if settled {
                return None;
            }
        }
        let mut first = if line.comes_from_left(points) {
            first_fronts::<R, ARCS, true, false>(&line, &bent, curvatures, how)
        } else {
            first_fronts::<R, ARCS, false, true>(&line, &bent, curvatures, how)
        };
        if ARCS && let Some(across) = across {
            part_fronts(&line, &bent, across, &mut first, points);
        }
        let [mut times, mut bents] = [[R::zero(); TILE]; 2];
        let mut any = false;
        for i in 0..points {
            let (time, curvature) = (line.times[i], curvatures[i]);
            (times[i], bents[i]) =
                accept(time, curvature, first.get(i), how.scan.0, how.renews, ARCS);
            let change = time.units_between(times[i]);
            any |= change.max(curvature.units_between(bents[i])) > R::Bits::default();
            changes.times[i] = change.max(changes.times[i]);
            // As whole numbers, whose maximum compilers find in lanes.
            let bend = (bents[i] - curvature).abs() * times[i];
            changes.bends[i] = R::zero().units_between(bend).max(changes.bends[i]);
        }
        line.times.copy_from_slice(&times[..points]);
        curvatures.copy_from_slice(&bents[..points]);
        Some(any)
    }
}

/// The first fronts through the triangle that most points should be reached through, and through the
/// other unless nothing comes first through it.
#[inline(always)]
fn first_fronts<R: Real, const ARCS: bool, const FIRST_LEFT: bool, const SECOND_LEFT: bool>(
    line: &Stretch<R>,
    bent: &Bent<R>,
    curvatures: &[R],
    how: How,
) -> FrontsOf<R> {
    let points = curvatures.len();
    let mut first = FrontsOf::default();
    for i in 0..points {
        let bends = bent.around::<FIRST_LEFT>(i, line.is_alone(i));
        first.set(i, curved(line.triangle::<FIRST_LEFT>(i), bends));
    }
    let mut settled = true;
    for (i, curvature) in curvatures.iter().enumerate() {
        // A front that is renewed may come later than it did.
        let renewed = how.renews & is_from(*curvature, how.scan.0);
        let now = if renewed { first.times[i] } else { min(line.times[i], first.times[i]) };
        let other = line.turned::<SECOND_LEFT>(i);
        let fronts = bent.around::<SECOND_LEFT>(i, false).fronts;
        settled &= is_settled(Wavefront::Curved, other, fronts, now);
    }
    if !settled {
        for i in 0..points {
            let bends = bent.around::<SECOND_LEFT>(i, line.is_alone(i));
            let other = curved(line.triangle::<SECOND_LEFT>(i), bends);
            first.set(i, Front::first(first.get(i), other, ARCS));
        }
    }
    first
}

/// Replaces the first fronts of points with a base on which two arcs touch.
#[inline(always)]
fn part_fronts<R: Real>(
    line: &Stretch<R>,
    bent: &Bent<R>,
    across: Beyond<R>,
    first: &mut FrontsOf<R>,
    points: usize,
) {
    let (t, k) = (line.behind, bent.fronts_behind);
    // Both points of a stretch's bases are as wide as times for the sake of lanes.
    let mut parts = [R::zero(); TILE + 1];
    let mut any = false;
    for i in 0..points + 1 {
        let are_two = are_two_arcs([t[i], t[i + 1]], [k[i], k[i + 1]]);
        parts[i] = if are_two { R::one() } else { R::zero() };
        any |= are_two;
    }
    if !any {
        return;
    }
    let (t_across, k_across) = (across.times, across.curvatures);
    any = false;
    for i in 0..points + 1 {
        let ends = [[t[i], k[i]], [t[i + 1], k[i + 1]]];
        let [a, b] = [[t_across[i], k_across[i]], [t_across[i + 1], k_across[i + 1]]];
        let touches = is_of_either(ends, a) | is_of_either(ends, b);
        parts[i] = if touches { parts[i] } else { R::zero() };
        any |= parts[i] > R::zero();
    }
    if any {
        part_each(line, bent, across, first, &parts[..points + 1]);
    }
}

/// One after another, since few points have such a base.
#[inline(never)]
fn part_each<R: Real>(
    line: &Stretch<R>,
    bent: &Bent<R>,
    across: Beyond<R>,
    first: &mut FrontsOf<R>,
    parts: &[R],
) {
    for (i, bases) in parts.windows(2).enumerate() {
        let [left, right] = [bases[0] > R::zero(), bases[1] > R::zero()];
        if !(left | right) {
            continue;
        }
        let of_left = (line.left(i), bent.around::<true>(i, false));
        let of_right = (line.right(i), bent.around::<false>(i, false));
        // The point behind the neighbour beside this one comes first.
        let through_left = || {
            let [a, b] = across.around(i);
            two_arcs(of_left.0, of_left.1, [b, a])
        };
        let through_right = || two_arcs(of_right.0, of_right.1, across.around(i + 1));
        let part_left = left.then(through_left).flatten();
        let part_right = right.then(through_right).flatten();
        if part_left.is_some() || part_right.is_some() {
            let [left, right] = [(part_left, of_left), (part_right, of_right)]
                .map(|(part, (triangle, bends))| part.unwrap_or_else(|| curved(triangle, bends)));
            first.set(i, Front::first(left, right, true));
        }
    }
}

/// A front for each point of part of a line.
#[derive(Default)]
struct FrontsOf<R> {
    times: [R; TILE],
    curvatures: [R; TILE],
    /// One where it is whole, as wide as the others for the sake of lanes.
    whole: [R; TILE],
}

impl<R: Real> FrontsOf<R> {
    #[inline(always)]
    fn get(&self, i: usize) -> Front<R> {
        let whole = self.whole[i] > R::zero();
        Front { time: self.times[i], curvature: self.curvatures[i], whole }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, front: Front<R>) {
        (self.times[i], self.curvatures[i]) = (front.time, front.curvature);
        self.whole[i] = if front.whole { R::one() } else { R::zero() };
    }
}

/// Curvatures around part of a line: of the surface, and of fronts and surface behind, as in [`Line`].
struct Bent<'a, R> {
    gaussian: &'a [R],
    fronts_behind: &'a [R],
    gaussian_behind: &'a [R],
}

impl<R: Real> Bent<'_, R> {
    /// Those of one of the two triangles of point i.
    #[inline(always)]
    fn around<const LEFT: bool>(&self, i: usize, alone: bool) -> Bends<R> {
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
    fn prefetch_next(&self, start: usize) {
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

impl<'a, R: Real> Beyond<'a, R> {
    #[inline(always)]
    fn stretch(self, start: usize, points: usize) -> Self {
        let cut = |array: &'a [R]| &array[start..][..points + 2];
        let Self { times, curvatures, edges: [before, beside, after] } = self;
        Self {
            times: cut(times),
            curvatures: cut(curvatures),
            edges: [cut(before), cut(beside), cut(after)],
        }
    }

    /// Those across the base from point i of the line behind to the next.
    #[inline(always)]
    fn around(&self, i: usize) -> [Across<R>; 2] {
        let [before, beside, after] = self.edges;
        let point = |at: usize, sides: [R; 2]| Across {
            time: self.times[at],
            curvature: self.curvatures[at],
            sides,
        };
        [point(i, [beside[i], before[i + 1]]), point(i + 1, [after[i], beside[i + 1]])]
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
    /// Whether there is no point beside point i behind; see [`Bends`].
    #[inline(always)]
    fn is_alone(&self, i: usize) -> bool {
        self.middle[i] >= R::FAR
    }

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

    /// One of both.
    #[inline(always)]
    fn triangle<const LEFT: bool>(&self, i: usize) -> Triangle<R> {
        if LEFT { self.left(i) } else { self.right(i) }
    }

    /// The same, x1 being the point behind beside point i.
    #[inline(always)]
    fn turned<const LEFT: bool>(&self, i: usize) -> Triangle<R> {
        if !LEFT {
            return self.right(i);
        }
        let Triangle { t1, t2, l1, l2, c } = self.left(i);
        Triangle { t1: t2, t2: t1, l1: l2, l2: l1, c }
    }

    /// Whether nothing behind is earlier than any point.
    #[inline(always)]
    fn leads(&self, points: usize) -> bool {
        let mut leads = true;
        for i in 0..points {
            let behind = min(self.behind[i], min(self.behind[i + 1], self.behind[i + 2]));
            leads &= behind >= self.times[i];
        }
        leads
    }

    /// Whether none of the points has been reached.
    #[inline(always)]
    fn is_unreached(&self, points: usize) -> bool {
        let mut unreached = true;
        for i in 0..points {
            unreached &= self.times[i] >= R::FAR;
        }
        unreached
    }

    /// Whether fronts arrive behind first before the first of some points, not after the last.
    #[inline(always)]
    fn comes_from_left(&self, points: usize) -> bool {
        self.behind[0] <= self.behind[points + 1]
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
