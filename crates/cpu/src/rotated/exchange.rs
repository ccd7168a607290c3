//! Exchanges fronts between a glued point's copies, in both copies of a map.

use super::scan_copy::ScanCopy;
use super::tiles::Tiles;
use crate::fronts::exchange;
use crate::fronts::{FrontKind, Fronts};
use geosweep_surface::update::StoredFront;
use geosweep_surface::{EdgeLengths, Real, min};

/// Gives all copies of each point the earliest front among them, and returns the largest change. `copies` are two
/// copies of the map, which are equal before and after this call. Scans do not continue changes later than `limit`.
pub(crate) fn exchange<R: Real, K: FrontKind<R>>(
    edges: &EdgeLengths<R>,
    copies: &mut [ScanCopy<R, K::Carried>; 2],
    tiles: &mut Tiles,
    renews: bool,
    limit: f64,
) -> R::Bits {
    let mut largest = R::Bits::default();
    let at = |copies: &[ScanCopy<R, K::Carried>; 2], point: usize| {
        let ScanCopy { times, carried, .. } = &copies[0];
        (StoredFront { time: times[point], carried: carried[point] }, renews)
    };
    exchange::exchange::<R, K, _>(edges, copies, at, |copies, point, [before, after]| {
        for copy in copies {
            copy.times[point] = after.time;
            copy.carried[point] = after.carried;
        }
        largest = largest.max(K::Carried::change(before, after));
        let (row, col) = edges.chart().bordered_position(point);
        match min(before.time, after.time).wide() <= limit {
            true => tiles.touch(row, col),
            false => tiles.note(row, col),
        }
    });
    largest
}
