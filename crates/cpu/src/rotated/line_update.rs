//! Updates one line of points from the line behind it. Rotated scans consist of such updates.
//!
//! The loops have no branches, so that the compiler maps points to SIMD lanes; see [`Loop`]. The update of a
//! span of points depends on the kind of front (`fronts/`).

use std::ops::Range;

use super::changed::Changed;
use crate::fronts::LaneKind;
use crate::lines::line::{GridLines, ScanLine};
use crate::lines::span::{LargestChanges, TILE};
use crate::scan::UpdateOptions;
use geosweep_surface::lanes::Loop;
use geosweep_surface::update::Carried;
use geosweep_surface::{Real, min};

/// Result of updating one or more lines: the largest change ([`Real::units_between`]), the number of updated points,
/// and the number of points beyond the limit, which are skipped. Settled points are skipped too, and not counted.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Updated<B> {
    pub largest: B,
    pub points: u64,
    pub beyond: u64,
}

impl<B: Ord> Updated<B> {
    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            largest: self.largest.max(other.largest),
            points: self.points + other.points,
            beyond: self.beyond + other.beyond,
        }
    }
}

/// Updates points of a line from the line behind, and marks each changed span of [`TILE`] points.
pub(crate) fn update_line<R: Real, K: LaneKind<R>>(
    kind: &K,
    lines: &mut GridLines<'_, R, K::Carried, K::SurfaceData>,
    line: usize,
    points: &Range<usize>,
    options: UpdateOptions,
    changed: &mut [Changed],
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
    /// The points with obtuse triangles, and the fronts that arrive through parts of these triangles.
    splits: &'l [(usize, Option<K::Arrival>)],
    options: UpdateOptions,
    /// Marks of the spans that the update changes.
    changed: &'l mut [Changed],
}

/// Updates each span of [`TILE`] points. If the number of points is no multiple of [`TILE`], the last span overlaps the
/// span before it. A second update leaves the points in both spans as they are.
impl<R: Real, K: LaneKind<R>, const SPLIT: bool> Loop for LineUpdate<'_, '_, R, K, SPLIT> {
    type Output = Updated<R::Bits>;
    const AVX512: bool = K::AVX512;

    #[inline(always)]
    fn run(self) -> Updated<R::Bits> {
        // Compilers keep locals in registers, but not the fields of an argument.
        let Self { of_line, mut line, splits, options, changed } = self;
        let (points, is_limited) = (line.points, options.limit < f64::INFINITY);
        let (mut changes, mut updated, mut beyond) = (LargestChanges::default(), 0, 0);
        for (tile, changed) in changed.iter_mut().enumerate() {
            line.prefetch_next(tile * TILE, K::NEEDS_EDGES);
            let in_tile = (points - tile * TILE).min(TILE) as u64;
            let mut before = None;
            if is_limited {
                let in_span = points.min(TILE);
                let start = (tile * TILE).min(points - in_span);
                if line.span_without_edges(start, in_span).is_beyond(in_span, options.limit) {
                    beyond += in_tile;
                    continue;
                }
                before = Some(FrontsBefore::new(&line, start, in_span));
            }
            // There is a separate call for full spans, whose number of points is known at compile time.
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
            let any = match before {
                _ if !any => Changed::No,
                Some(before) if !before.changes_within(&line, options.limit) => Changed::Beyond,
                _ => Changed::Within,
            };
            *changed = any.max(*changed);
            updated += in_tile;
        }
        Updated { largest: changes.largest(K::TELLS_BENDS), points: updated, beyond }
    }
}

/// The fronts at a span of points before its update.
struct FrontsBefore<R, C> {
    times: [R; TILE],
    carried: [C; TILE],
    start: usize,
    points: usize,
}

impl<R: Real, C: Carried> FrontsBefore<R, C> {
    #[inline(never)]
    fn new<G>(line: &ScanLine<'_, '_, R, C, G>, start: usize, points: usize) -> Self {
        let (mut times, mut carried) = ([R::zero(); TILE], [C::default(); TILE]);
        let span = line.span_without_edges(start, points);
        times[..points].copy_from_slice(span.times);
        carried[..points].copy_from_slice(&span.carried[..points]);
        Self { times, carried, start, points }
    }

    /// Returns whether the update has changed a front that is or was no later than the limit.
    #[inline(never)]
    fn changes_within<G>(&self, line: &ScanLine<'_, '_, R, C, G>, limit: f64) -> bool {
        let span = line.span_without_edges(self.start, self.points);
        (0..self.points).any(|i| {
            let differs = span.times[i] != self.times[i] || span.carried[i] != self.carried[i];
            differs && min(span.times[i], self.times[i]).wide() <= limit
        })
    }
}

/// Returns the entries for `points` points of a line from `start` on. `found` is sorted by points.
#[inline(always)]
fn in_span<A>(found: &[(usize, A)], [start, points]: [usize; 2]) -> &[(usize, A)] {
    let before = |end: usize| found.partition_point(|&(place, _)| place < end);
    if found.is_empty() { found } else { &found[before(start)..before(start + points)] }
}
