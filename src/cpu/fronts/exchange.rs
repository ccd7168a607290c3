//! Finds the earliest front of all copies of a point on a glued surface, and what each copy makes of it. The twin
//! of `glsl/passes/exchange.comp`.

use super::FrontKind;
use crate::constants::COPIES_TOGETHER;
use crate::surface::Real;
use crate::update::{Carried, EXACT, EXCHANGED, Kept};

/// Returns the earliest front that a scan has brought to any point of a group of copies. Fronts that an earlier
/// exchange has brought do not count: those from which they were copied may have been renewed since.
pub(in crate::cpu) fn earliest<R: Real, K: FrontKind<R>>(
    group: &[u32],
    front: impl Fn(usize) -> Kept<R, K::Carried>,
) -> Option<Kept<R, K::Carried>> {
    let counts =
        |front: &Kept<R, K::Carried>| front.time < R::FAR && !front.carried.is_from(EXCHANGED);
    // The shader has an invocation for each part of a group.
    let of_part = |part: &[u32]| {
        part.iter().map(|&point| front(point as usize)).filter(counts).reduce(K::first)
    };
    group.chunks(COPIES_TOGETHER as usize).filter_map(of_part).reduce(K::first)
}

/// Returns the front at a copy after the earliest front of all copies has come, or `None` if it stays.
pub(in crate::cpu) fn after_arrival<R: Real, K: FrontKind<R>>(
    first: Kept<R, K::Carried>,
    before: Kept<R, K::Carried>,
    renews: bool,
) -> Option<Kept<R, K::Carried>> {
    if before == first {
        return None;
    }
    let scan = if first.carried.is_from(EXACT) { EXACT } else { EXCHANGED };
    let after = K::accept(before, K::arrival_of_front(first), scan, renews);
    Some(after).filter(|&after| after != before)
}
