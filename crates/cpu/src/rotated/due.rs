//! Finds the tiles in which scans have work, before the scans start.
//!
//! A scan has to examine every tile beside a change. In most of them it only confirms that the change has no
//! effect. If all points of a tile are settled (`lines/settled.rs`) before a scan, the scan changes nothing there
//! until it brings a change itself. This module finds such tiles for up to four scans at once. It examines points row
//! by row, in the order of memory, with any number of threads. So scans to the right and left have to transpose the
//! columns of few tiles only.

use std::ops::Range;

use rayon::prelude::*;

use super::tiles::Tiles;
use crate::behind::Behind;
use crate::fronts::LaneKind;
use crate::lines::span::{Before, Span, TILE, prefetch_next_row};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::Real;
use geosweep_surface::lanes::Loop;

/// Finds the tiles in which any of up to four scans has work. All scans start from the same fronts. Returns the number
/// of examined points. A point that is examined for two scans counts twice. Without a limit, the points of tiles that
/// are due anyway are included, although they are not examined. Rows of tiles are examined in parallel if the tiles are
/// those of the whole grid.
pub(crate) fn find_due<R: Real, K: LaneKind<R>>(
    kind: &K,
    before: Before<R, K::Carried, K::SurfaceData>,
    tiles: &mut Tiles,
    scans: &[UpdateOptions],
) -> u64 {
    let (chart, window, place) = (before.edges.chart(), before.fronts.window, tiles.place());
    let strides = [window.own(), chart].map(|chart| chart.stride() as isize);
    let seen: [Option<_>; 4] = std::array::from_fn(|scan| {
        let options = *scans.get(scan)?;
        Some((options, Behind::of(chart, options.scan), window.behind(options.scan)))
    });
    let obtuse = before.edges.obtuse_triangles().filter(|_| K::NEEDS_EDGES);
    let in_band = |(band, (beside, due)): (usize, (&[u8], &mut [u8]))| {
        let mut looked = 0;
        for row in place.rows(band..band + 1) {
            for &(options, ref behind, in_window) in seen.iter().flatten() {
                for run in runs(beside, options.scan) {
                    let due = &mut due[run.clone()];
                    let cols = place.cols(run);
                    let points = cols.len() as u64;
                    let first = chart.bordered(row, cols.start);
                    let behinds = (behind, in_window);
                    let span = before.span(behinds, [row, cols.start], cols.len());
                    let before = &before;
                    let obtuse =
                        obtuse.filter(|_| before.edges.has_obtuse_points(row, cols.clone()));
                    let obtuse = obtuse.map(|bits| (&bits[first..][..cols.len()], behind.bits()));
                    let look =
                        Look::<R, K> { kind, before, first, span, obtuse, strides, options, due };
                    looked += points - options.instructions.run(look);
                }
            }
        }
        looked
    };
    let least = if place.chart() == chart { 1 } else { usize::MAX };
    tiles.rows_beside_changes(scans).enumerate().with_min_len(least).map(in_band).sum()
}

/// Returns the runs of adjacent tiles that a scan has to examine in a row of tiles.
fn runs(beside: &[u8], scan: Scan) -> impl Iterator<Item = Range<usize>> {
    let mut end = 0;
    std::iter::from_fn(move || {
        let start = end + beside[end..].iter().position(|scans| scans & scan.bit() != 0)?;
        let count = beside[start..].iter().take_while(|&scans| scans & scan.bit() != 0).count();
        end = start + count;
        Some(start..end)
    })
}

/// Check that finds the tiles along a row of points in which a scan has work, and adds the scan to their `due`. With a
/// limit, it returns the number of points not examined: points beyond the limit, and points of tiles that are due
/// anyway. Without a limit it returns 0.
struct Look<'l, R: Real, K: LaneKind<R>> {
    kind: &'l K,
    before: &'l Before<'l, R, K::Carried, K::SurfaceData>,
    /// The first point, as an index into bordered arrays of the grid.
    first: usize,
    span: Span<'l, R, K::Carried, K::SurfaceData>,
    /// Bits of each point's obtuse triangles, and the bits of the triangles that the scan uses; `None` if no triangle
    /// is obtuse.
    obtuse: Option<(&'l [u8], u8)>,
    /// Offsets from a row to the next, in the arrays of fronts and of surface data.
    strides: [isize; 2],
    options: UpdateOptions,
    due: &'l mut [u8],
}

impl<R: Real, K: LaneKind<R>> Loop for Look<'_, R, K> {
    type Output = u64;
    const AVX512: bool = K::AVX512;

    #[inline(always)]
    fn run(self) -> u64 {
        let Self { kind, before, first, span, obtuse, strides, options, due } = self;
        let (points, mut left_out) = (span.times.len(), 0);
        for (tile, due) in due.iter_mut().enumerate() {
            prefetch_next_row(&span, strides, tile * TILE, K::NEEDS_EDGES);
            let in_span = points.min(TILE);
            let at = (tile * TILE).min(points - in_span);
            let of_tile = (points - tile * TILE).min(TILE) as u64;
            let is_limited = options.limit < f64::INFINITY;
            if is_limited && span.part(at, in_span).is_beyond(in_span, options.limit) {
                left_out += of_tile;
                continue;
            }
            if *due & options.scan.bit() != 0 {
                // The points of a tile that is due anyway are not examined.
                if is_limited {
                    left_out += of_tile;
                }
                continue;
            }
            // This check does not examine fronts through parts of obtuse triangles, so tiles with such triangles are
            // due.
            let is_split = |start: usize, points: usize| {
                obtuse.is_some_and(|(obtuse, of_scan)| {
                    let any = |all, bits: &u8| all | bits;
                    obtuse[start..][..points].iter().fold(0, any) & of_scan != 0
                })
            };
            // Spans are the same as in updates: the last span of a line overlaps the span before it.
            let leaves = match points.checked_sub(TILE) {
                Some(last) => {
                    let start = (tile * TILE).min(last);
                    !is_split(start, TILE)
                        && kind.leaves(before, first + start, span.part(start, TILE), TILE, options)
                }
                None => {
                    !is_split(0, points)
                        && kind.leaves(before, first, span.part(0, points), points, options)
                }
            };
            if !leaves {
                *due |= options.scan.bit();
            }
        }
        left_out
    }
}
