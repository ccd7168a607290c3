//! Updates one line of points from the line behind it. Rotated scans consist of such updates.
//!
//! The loops have no branches, so that the compiler maps points to SIMD lanes; see [`Loop`]. The update of a
//! point depends on the kind of front (`fronts/`).

use super::tiles::TILE;
use crate::cpu::Instructions;
use crate::cpu::scan::Scan;
use crate::lanes::Loop;
use crate::surface::Real;

/// Options of a line update. `renews`: whether a scan may replace a front that the same scan direction
/// brought earlier. `limit`: the time after which fronts do not matter, or +infinity. Points that such fronts
/// alone reach are not updated, and changes of later fronts are not passed on.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct UpdateOptions {
    pub scan: Scan,
    pub renews: bool,
    pub limit: f64,
    pub instructions: Instructions,
}

/// How updates have changed some points. The largest of several counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::cpu) enum Changed {
    #[default]
    No,
    /// Only fronts have changed that are later than the limit.
    Beyond,
    /// Fronts have changed that may reach other points before the limit.
    Within,
}

impl Changed {
    /// Tells how some points have changed, of which `any` has. `first` returns the earlier of the times before
    /// and after the update for a point that has changed.
    #[inline(always)]
    pub(in crate::cpu) fn of<R: Real>(
        any: bool,
        limit: f64,
        points: usize,
        first: impl Fn(usize) -> Option<R>,
    ) -> Self {
        if !any {
            Self::No
        } else if limit == f64::INFINITY || is_any_within(limit, points, first) {
            Self::Within
        } else {
            Self::Beyond
        }
    }
}

/// Returns whether one of the times is no later than a limit.
#[inline(never)]
fn is_any_within<R: Real>(limit: f64, points: usize, time: impl Fn(usize) -> Option<R>) -> bool {
    (0..points).any(|i| time(i).is_some_and(|time| time.wide() <= limit))
}

/// Result of updating one or more lines: the largest change ([`crate::surface::Real::units_between`]), the
/// number of updated points, and the number of those that were left out since they are beyond the limit.
/// Settled points are skipped and not counted.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cpu) struct Updated<B> {
    pub largest: B,
    pub points: u64,
    pub beyond: u64,
}

impl<B: Ord> Updated<B> {
    #[inline(always)]
    pub(in crate::cpu) fn and(self, other: Self) -> Self {
        Self {
            largest: self.largest.max(other.largest),
            points: self.points + other.points,
            beyond: self.beyond + other.beyond,
        }
    }
}

/// A line whose points are updated span by span. All methods must be inlined into [`Loop::run`].
pub(in crate::cpu) trait Spans {
    /// The largest changes so far. They may be kept apart by their place in the span, for the sake of SIMD
    /// lanes.
    type Changes: Default;
    type Bits: Ord + Default;

    /// Returns the number of points.
    fn points(&self) -> usize;

    /// Prefetches the data that the update of the next line needs, from the point `start` on.
    fn prefetch_next(&self, start: usize);

    /// Returns whether the times of `points` points from `start` on, and of those behind them, are all later than
    /// the limit.
    fn is_beyond(&self, start: usize, points: usize, limit: f64) -> bool;

    /// Updates `points` points from `start` on. Returns how they have changed, tags included, or `None` if all
    /// of the points are settled.
    fn update(
        &mut self,
        start: usize,
        points: usize,
        options: UpdateOptions,
        changes: &mut Self::Changes,
    ) -> Option<Changed>;

    fn largest(changes: Self::Changes) -> Self::Bits;
}

/// The update of a line by a scan. `changed` marks the spans of [`TILE`] points that the update changes.
pub(in crate::cpu) struct LineUpdate<'a, L> {
    pub line: L,
    pub options: UpdateOptions,
    pub changed: &'a mut [Changed],
}

/// Updates each span of [`TILE`] points. If the line has a remainder, the last span overlaps the one
/// before. This does no harm: updated points stay as they are.
impl<L: Spans> Loop for LineUpdate<'_, L> {
    type Output = Updated<L::Bits>;

    #[inline(always)]
    fn run(self) -> Updated<L::Bits> {
        let Self { mut line, options, changed } = self;
        let points = line.points();
        let (mut changes, mut updated, mut beyond) = (L::Changes::default(), 0, 0);
        for (tile, changed) in changed.iter_mut().enumerate() {
            line.prefetch_next(tile * TILE);
            let in_span = points.min(TILE);
            if line.is_beyond((tile * TILE).min(points - in_span), in_span, options.limit) {
                beyond += (points - tile * TILE).min(TILE) as u64;
                continue;
            }
            // Two calls, since a number of points that is known at compile time needs no loop.
            let any = match points.checked_sub(TILE) {
                Some(last) => line.update((tile * TILE).min(last), TILE, options, &mut changes),
                None => line.update(0, points, options, &mut changes),
            };
            let Some(any) = any else { continue };
            *changed = any.max(*changed);
            updated += (points - tile * TILE).min(TILE) as u64;
        }
        Updated { largest: L::largest(changes), points: updated, beyond }
    }
}
