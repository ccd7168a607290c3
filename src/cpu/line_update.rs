//! The update of one line of points from the line behind it: what rotated scans are made of.
//!
//! The loops have no branch, so that the compiler turns points into lanes; see [`Loop`]. What happens at a point
//! is a matter of the front (`fronts/`).

use super::Instructions;
use super::scan::Scan;
use super::tiles::TILE;
use crate::lanes::Loop;

/// How points are updated: a scan `renews` fronts that it has brought before, or not.
#[derive(Clone, Copy, Debug)]
pub(super) struct How {
    pub scan: Scan,
    pub renews: bool,
    pub instructions: Instructions,
}

/// What updates have come to: the largest change ([`crate::surface::Real::units_between`]), and how many points
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

/// A line whose points are updated stretch by stretch. All methods are to be inlined into [`Loop::run`].
pub(super) trait Stretches {
    /// The largest changes so far, maybe kept apart by their place in the stretch for the sake of lanes.
    type Changes: Default;
    type Bits: Ord + Default;

    /// Number of points.
    fn points(&self) -> usize;

    /// Asks for what the next line's update needs from some point on.
    fn prefetch_next(&self, start: usize);

    /// Updates some points: whether it has changed anything at all, tags included; `None` if all of them
    /// are settled.
    fn update(
        &mut self,
        start: usize,
        points: usize,
        how: How,
        changes: &mut Self::Changes,
    ) -> Option<bool>;

    fn largest(changes: Self::Changes) -> Self::Bits;
}

/// The update of a line by a scan, and where to mark which stretches of [`TILE`] points it has
/// changed.
pub(super) struct LineUpdate<'a, L> {
    pub line: L,
    pub how: How,
    pub changed: &'a mut [bool],
}

/// Updates each stretch of [`TILE`] points; the last one overlaps the one before if the line has a
/// remainder, which does no harm: what has been updated stays as it is.
impl<L: Stretches> Loop for LineUpdate<'_, L> {
    type Output = Updated<L::Bits>;

    #[inline(always)]
    fn run(self) -> Updated<L::Bits> {
        let Self { mut line, how, changed } = self;
        let points = line.points();
        let (mut changes, mut updated) = (L::Changes::default(), 0);
        for (tile, changed) in changed.iter_mut().enumerate() {
            line.prefetch_next(tile * TILE);
            // Two calls, since a number of points that is known when this is compiled needs no loop.
            let any = match points.checked_sub(TILE) {
                Some(last) => line.update((tile * TILE).min(last), TILE, how, &mut changes),
                None => line.update(0, points, how, &mut changes),
            };
            let Some(any) = any else { continue };
            *changed |= any;
            updated += (points - tile * TILE).min(TILE) as u64;
        }
        Updated { largest: L::largest(changes), points: updated }
    }
}
