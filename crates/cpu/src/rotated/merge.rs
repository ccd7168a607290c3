//! Merges the two copies of a map's fronts after two opposite scans have each updated one of them.

use std::ops::Range;

use rayon::prelude::*;

use super::changed::Changed;
use super::scan_copy::ScanCopy;
use super::tiles::Tiles;
use crate::Instructions;
use crate::fronts::{FrontKind, Fronts};
use crate::lines::span::TILE;
use crate::scan::Scan;
use geosweep_surface::lanes::Loop;
use geosweep_surface::update::{Carried, StoredFront};
use geosweep_surface::{Chart, Real};

/// Stores at each point, in both copies, the first of the two copies' fronts.
pub(crate) fn merge<R: Real, K: FrontKind<R>>(
    chart: Chart,
    tiles: &Tiles,
    copies: [&mut ScanCopy<R, K::Carried>; 2],
    scans: [Scan; 2],
    instructions: Instructions,
) {
    let [a, b] = copies;
    let changed = [a.changed.as_slice(), b.changed.as_slice()];
    let bands = (
        chart.bands_mut(&mut a.times, TILE).zip(chart.bands_mut(&mut a.carried, TILE)),
        chart.bands_mut(&mut b.times, TILE).zip(chart.bands_mut(&mut b.carried, TILE)),
    );
    bands.into_par_iter().enumerate().for_each(|(band, ((a, a_carried), (b, b_carried)))| {
        merge_band(chart, tiles, band, changed, |points, changed| {
            let a = (&mut a[points.clone()], &mut a_carried[points.clone()]);
            let b = (&mut b[points.clone()], &mut b_carried[points]);
            // If only one scan has changed a tile, its copy replaces the other one, which is unchanged.
            match changed {
                [true, true] => instructions.run(Merge::<R, K> { a, b, scans }),
                [true, false] => copy(a, b),
                _ => copy(b, a),
            }
        });
    });
}

fn copy<R: Copy, C: Copy>(from: (&mut [R], &mut [C]), to: (&mut [R], &mut [C])) {
    to.0.copy_from_slice(from.0);
    to.1.copy_from_slice(from.1);
}

/// Calls `merge` for each line of the tiles in a band that either of two scans has changed. Passes the points of the
/// line in adjacent tiles, and flags of the scans that have changed these tiles.
fn merge_band(
    chart: Chart,
    tiles: &Tiles,
    band: usize,
    changed: [&[Changed]; 2],
    mut merge: impl FnMut(Range<usize>, [bool; 2]),
) {
    let places = tiles.in_band(Scan::DOWN);
    let changed =
        |place| changed.map(|changed| changed[tiles.index(Scan::DOWN, band, place)] > Changed::No);
    let mut place = 0;
    while place < places {
        let (start, of_run) = (place, changed(place));
        while place < places && changed(place) == of_run {
            place += 1;
        }
        if of_run == [false; 2] {
            continue;
        }
        let points = tiles.lines(Scan::DOWN, band, start..place);
        for row in 0..points.rows.len() {
            merge(chart.in_band(row, &points.cols), of_run);
        }
    }
}

/// Merge that selects the first of two fronts. A front in one copy may stem from the other copy's scan in an earlier
/// iteration. The copy's own scan has then not changed it, so the other copy's front is taken.
struct Merge<'l, R: Real, K: FrontKind<R>> {
    a: (&'l mut [R], &'l mut [K::Carried]),
    b: (&'l mut [R], &'l mut [K::Carried]),
    scans: [Scan; 2],
}

impl<R: Real, K: FrontKind<R>> Loop for Merge<'_, R, K> {
    type Output = ();
    const AVX512: bool = K::AVX512;

    #[inline(always)]
    fn run(self) {
        let Self { a, b, scans } = self;
        let (of_a, of_b) = (a.0.iter_mut().zip(a.1), b.0.iter_mut().zip(b.1));
        for ((a, a_carried), (b, b_carried)) in of_a.zip(of_b) {
            let of_a = StoredFront { time: *a, carried: *a_carried };
            let of_b = StoredFront { time: *b, carried: *b_carried };
            let a_is_old = of_a.carried.is_from(scans[1].0);
            let b_is_old = of_b.carried.is_from(scans[0].0);
            let StoredFront { time, carried } = K::Carried::first(of_a, of_b);
            let (time, carried) = (
                if b_is_old { of_a.time } else { time },
                if b_is_old { of_a.carried } else { carried },
            );
            let (time, carried) = (
                if a_is_old { of_b.time } else { time },
                if a_is_old { of_b.carried } else { carried },
            );
            (*a, *a_carried) = (time, carried);
            (*b, *b_carried) = (time, carried);
        }
    }
}
