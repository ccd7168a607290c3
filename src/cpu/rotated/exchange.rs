//! Lets all copies of a point of a glued surface take the earliest front of theirs.

use super::scan_copy::ScanCopy;
use super::tiles::Tiles;
use crate::cpu::fronts::FrontKind;
use crate::surface::{EdgeLengths, Real, min};
use crate::update::{Carried, EXACT, EXCHANGED, Kept};

/// Gives each copy of a point the first front that a scan has brought to any of them, and returns the largest
/// change. Fronts that an earlier exchange has brought do not count: those from which they were copied may
/// have been renewed since. The fronts before and after are the same in both `copies` of the map. Changes after
/// `limit` are not passed on.
pub(in crate::cpu) fn exchange<R: Real, K: FrontKind<R>>(
    edges: &EdgeLengths<R>,
    copies: &mut [ScanCopy<R, K::Carried>; 2],
    tiles: &mut Tiles,
    renews: bool,
    limit: f64,
) -> R::Bits {
    let mut largest = R::Bits::default();
    let Some(groups) = edges.copies() else { return largest };
    for group in groups.iter() {
        let front = |point: u32, copy: &ScanCopy<R, K::Carried>| {
            let point = point as usize;
            Kept { time: copy.times[point], carried: copy.carried[point] }
        };
        let of_scans = group
            .iter()
            .map(|&point| front(point, &copies[0]))
            .filter(|front| front.time < R::FAR && !front.carried.is_from(EXCHANGED));
        let Some(first) = of_scans.reduce(K::first) else { continue };
        let scan = if first.carried.is_from(EXACT) { EXACT } else { EXCHANGED };
        let arrival = K::arrival_of_front(first);
        for &point in group {
            let before = front(point, &copies[0]);
            if before == first {
                continue;
            }
            let after = K::accept(before, arrival, scan, renews);
            if after == before {
                continue;
            }
            for copy in copies.iter_mut() {
                copy.times[point as usize] = after.time;
                copy.carried[point as usize] = after.carried;
            }
            largest = largest.max(K::change(before, after));
            let (row, col) = edges.chart().bordered_position(point as usize);
            match min(before.time, after.time).wide() <= limit {
                true => tiles.touch(row, col),
                false => tiles.note(row, col),
            }
        }
    }
    largest
}
