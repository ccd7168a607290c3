//! Gives all copies of each point of a glued surface the earliest front among them. The twin of
//! `glsl/passes/exchange.comp`.

use super::{FrontKind, Fronts};
use geosweep_surface::constants::COPIES_TOGETHER;
use geosweep_surface::update::{Carried, EXACT, EXCHANGED, StoredFront};
use geosweep_surface::{EdgeLengths, Groups, Real};

/// Returns the earliest front that a scan has brought to any point of a group of copies. Fronts from an earlier
/// exchange do not count, since the fronts from which they were copied may have been renewed.
fn earliest<R: Real, K: FrontKind<R>>(
    group: &[u32],
    front: impl Fn(usize) -> StoredFront<R, K::Carried>,
) -> Option<StoredFront<R, K::Carried>> {
    let counts = |front: &StoredFront<R, K::Carried>| {
        front.time < R::FAR && !front.carried.is_from(EXCHANGED)
    };
    // The shader has an invocation for each part of a group.
    let of_part = |part: &[u32]| {
        part.iter().map(|&point| front(point as usize)).filter(counts).reduce(K::Carried::first)
    };
    group.chunks(COPIES_TOGETHER as usize).filter_map(of_part).reduce(K::Carried::first)
}

/// Returns the front at a copy after it receives the earliest front of all copies, or `None` if its front stays.
fn after_arrival<R: Real, K: FrontKind<R>>(
    first: StoredFront<R, K::Carried>,
    before: StoredFront<R, K::Carried>,
    renews: bool,
) -> Option<StoredFront<R, K::Carried>> {
    if before == first {
        return None;
    }
    let scan = if first.carried.is_from(EXACT) { EXACT } else { EXCHANGED };
    let after = K::Carried::accept(before, K::Carried::arrival_of_front(first), scan, renews);
    Some(after).filter(|&after| after != before)
}

/// Gives all copies of each point the earliest front among them. `at` returns the front at a point of the bordered
/// arrays, and whether it may be renewed. `set` is called for each point where the front changes, with the front before
/// and after the change.
pub(crate) fn exchange<R: Real, K: FrontKind<R>, T>(
    edges: &EdgeLengths<R>,
    map: &mut T,
    at: impl Fn(&T, usize) -> (StoredFront<R, K::Carried>, bool),
    mut set: impl FnMut(&mut T, usize, [StoredFront<R, K::Carried>; 2]),
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
