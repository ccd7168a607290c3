//! Lets all copies of a point on a glued surface take the earliest front of theirs. The twin of
//! `glsl/passes/exchange.comp`.

use super::FrontKind;
use crate::constants::COPIES_TOGETHER;
use crate::surface::{EdgeLengths, Groups, Real};
use crate::update::{Carried, EXACT, EXCHANGED, Kept};

/// Returns the earliest front that a scan has brought to any point of a group of copies. Fronts that an earlier
/// exchange has brought do not count: those from which they were copied may have been renewed since.
fn earliest<R: Real, K: FrontKind<R>>(
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
fn after_arrival<R: Real, K: FrontKind<R>>(
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

/// Lets all copies of each point take the earliest front of theirs. `at` returns the front at a point of the bordered
/// arrays and whether it may be renewed. `set` takes the front before and after at each point where it changes.
pub(in crate::cpu) fn exchange<R: Real, K: FrontKind<R>, T>(
    edges: &EdgeLengths<R>,
    map: &mut T,
    at: impl Fn(&T, usize) -> (Kept<R, K::Carried>, bool),
    mut set: impl FnMut(&mut T, usize, [Kept<R, K::Carried>; 2]),
) {
    for group in edges.copies().into_iter().flat_map(Groups::iter) {
        let first = earliest::<R, K>(group, |point| at(map, point).0);
        let Some(first) = first else { continue };
        for point in group.iter().map(|&point| point as usize) {
            let (before, renews) = at(map, point);
            if let Some(after) = after_arrival::<R, K>(first, before, renews) {
                set(map, point, [before, after]);
            }
        }
    }
}
