//! The update of one line of points from the line behind it: what rotated scans are made of.
//!
//! The loop has no branch, so that the compiler turns points into lanes; see [`Work`].

use super::line::{Bent, Line, Stretch};
use super::settled::{is_settled, stays};
use super::state::{accept, is_from};
use super::tiles::{Scan, TILE};
use super::{Instructions, bend_units};
use crate::lanes::Work;
use crate::surface::{Real, min};
use crate::update::{Front, Wavefront, curved, planar, point_source};

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
            Wavefront::Anchored => unreachable!("see anchored_scan.rs"),
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
            if CIRCULAR {
                // By more than rounding: a last digit would be passed on from point to point, and all of
                // them visited anew.
                let time = point_source(triangle);
                let is_earlier = time < now[i] * (R::one() - R::epsilon());
                times[i] = if is_earlier { time } else { now[i] };
            } else {
                times[i] = min(now[i], planar(triangle));
            }
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

/// Fronts that carry their curvature.
struct Curved;

impl Kernel for Curved {
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
        let first = if line.comes_from_left(points) {
            first_fronts::<R, true, false>(&line, &bent, curvatures, how)
        } else {
            first_fronts::<R, false, true>(&line, &bent, curvatures, how)
        };
        let [mut times, mut bents] = [[R::zero(); TILE]; 2];
        let mut any = false;
        for i in 0..points {
            let (time, curvature) = (line.times[i], curvatures[i]);
            (times[i], bents[i]) = accept(time, curvature, first.get(i), how.scan.0, how.renews);
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
fn first_fronts<R: Real, const FIRST_LEFT: bool, const SECOND_LEFT: bool>(
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
            first.set(i, Front::first(first.get(i), other));
        }
    }
    first
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
