//! Exchanges fronts between the copies of a point of a glued surface, in both arrays of a map.

use super::scan_copy::ScanCopy;
use super::tiles::Tiles;
use crate::cpu::fronts::FrontKind;
use crate::cpu::fronts::exchange::{after_arrival, earliest};
use crate::surface::{EdgeLengths, Real, min};
use crate::update::Kept;

/// Gives all copies of each point the earliest front among them, and returns the largest change. Both arrays in
/// `copies` hold the same map, before and after. Changes after `limit` are not passed on.
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
        let front = |point: usize, copy: &ScanCopy<R, K::Carried>| Kept {
            time: copy.times[point],
            carried: copy.carried[point],
        };
        let first = earliest::<R, K>(group, |point| front(point, &copies[0]));
        let Some(first) = first else { continue };
        for point in group.iter().map(|&point| point as usize) {
            let before = front(point, &copies[0]);
            let Some(after) = after_arrival::<R, K>(first, before, renews) else { continue };
            for copy in copies.iter_mut() {
                copy.times[point] = after.time;
                copy.carried[point] = after.carried;
            }
            largest = largest.max(K::change(before, after));
            let (row, col) = edges.chart().bordered_position(point);
            match min(before.time, after.time).wide() <= limit {
                true => tiles.touch(row, col),
                false => tiles.note(row, col),
            }
        }
    }
    largest
}
