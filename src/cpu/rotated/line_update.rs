//! Updates one line of points from the line behind it. Rotated scans consist of such updates.
//!
//! The loops have no branches, so that the compiler maps points to SIMD lanes; see [`Loop`]. The update of a
//! span of points depends on the kind of front (`fronts/`).

use std::ops::Range;

use super::line::{GridLines, ScanLine};
use super::span::LargestChanges;
use super::tiles::TILE;
use crate::cpu::fronts::LaneKind;
use crate::cpu::scan::UpdateOptions;
use crate::lanes::Loop;
use crate::surface::Real;

/// Result of updating one or more lines: the largest change ([`Real::units_between`]) and the number of
/// updated points. Settled points are skipped and not counted.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cpu) struct Updated<B> {
    pub largest: B,
    pub points: u64,
}

impl<B: Ord> Updated<B> {
    #[inline(always)]
    pub(in crate::cpu) fn and(self, other: Self) -> Self {
        Self { largest: self.largest.max(other.largest), points: self.points + other.points }
    }
}

/// Updates points of a line from the line behind, and marks the spans of [`TILE`] points that have changed.
pub(in crate::cpu) fn update_line<R: Real, K: LaneKind<R>>(
    kind: &K,
    lines: &mut GridLines<'_, R, K::Carried, K::SurfaceData>,
    line: usize,
    points: &Range<usize>,
    options: UpdateOptions,
    changed: &mut [bool],
) -> Updated<R::Bits> {
    let splits = kind.splits(lines, line, points);
    let line = lines.line(line, points, K::NEEDS_EDGES);
    let of_line = kind.of_line(line.first, options.scan);
    match &splits {
        None => {
            let update = LineUpdate::<R, K, false> { of_line, line, splits: &[], options, changed };
            options.instructions.run(update)
        }
        Some(splits) => {
            let update = LineUpdate::<R, K, true> { of_line, line, splits, options, changed };
            options.instructions.run(update)
        }
    }
}

/// The update of a line by a scan. `SPLIT` tells whether some of its triangles are obtuse.
struct LineUpdate<'l, 'g, R: Real, K: LaneKind<R>, const SPLIT: bool> {
    of_line: K::OfLine<'l>,
    line: ScanLine<'l, 'g, R, K::Carried, K::SurfaceData>,
    /// The points with obtuse triangles, and the fronts that arrive through parts of these.
    splits: &'l [(usize, Option<K::Arrival>)],
    options: UpdateOptions,
    /// Marks of the spans that the update changes.
    changed: &'l mut [bool],
}

/// Updates each span of [`TILE`] points. If the line has a remainder, the last span overlaps the one
/// before. This does no harm: updated points stay as they are.
impl<R: Real, K: LaneKind<R>, const SPLIT: bool> Loop for LineUpdate<'_, '_, R, K, SPLIT> {
    type Output = Updated<R::Bits>;

    #[inline(always)]
    fn run(self) -> Updated<R::Bits> {
        // Locals may stay in registers, and fields of an argument may not.
        let Self { of_line, mut line, splits, options, changed } = self;
        let points = line.points;
        let (mut changes, mut updated) = (LargestChanges::default(), 0);
        for (tile, changed) in changed.iter_mut().enumerate() {
            line.prefetch_next(tile * TILE, K::NEEDS_EDGES);
            // Two calls, since a number of points that is known at compile time needs no loop.
            let any = match points.checked_sub(TILE) {
                Some(last) => {
                    let span = [(tile * TILE).min(last), TILE];
                    let splits = if SPLIT { in_span(splits, span) } else { &[] };
                    K::update_span(&of_line, &mut line, span, splits, options, &mut changes)
                }
                None => {
                    let span = [0, points];
                    K::update_span(&of_line, &mut line, span, splits, options, &mut changes)
                }
            };
            let Some(any) = any else { continue };
            *changed |= any;
            updated += (points - tile * TILE).min(TILE) as u64;
        }
        Updated { largest: changes.largest(K::TELLS_BENDS), points: updated }
    }
}

/// Returns the entries for `points` points from `start` on, out of entries for points of a line in order.
#[inline(always)]
fn in_span<A>(found: &[(usize, A)], [start, points]: [usize; 2]) -> &[(usize, A)] {
    let before = |end: usize| found.partition_point(|&(place, _)| place < end);
    if found.is_empty() { found } else { &found[before(start)..before(start + points)] }
}
