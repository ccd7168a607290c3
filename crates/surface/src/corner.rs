//! Finds the corners of holes: the grid points at which a shortest path can bend.

use super::chart::{Direction, ring};

/// Presence of each neighbour of a grid point, in the order of [`Direction::ALL`].
type There = [bool; Direction::ALL.len()];

/// Returns whether a path can leave a grid point between the direction `eighth` and the next one. This holds if the
/// point's triangle with its neighbours in both directions is present. It also holds if the cell's corners on the row
/// and on the column of the point are present, since their triangle with the point covers the beginning of this eighth.
pub fn is_open(there: There, eighth: usize) -> bool {
    let first = eighth / 2 * 2;
    let diagonal = ring::next(first);
    // The point's three neighbours in the cell.
    match [first, diagonal, ring::next(diagonal)].map(|to| there[to]) {
        [true, _, true] => true,
        [a, true, b] => {
            if eighth.is_multiple_of(2) {
                a
            } else {
                b
            }
        }
        _ => false,
    }
}

/// Returns whether a shortest path can bend at a grid point: whether two directions open to paths enclose a blocked
/// range of less than half a turn.
pub fn is_corner(there: There) -> bool {
    let at = |index: usize| there[index % 8];
    let open = |eighth: usize| is_open(there, eighth % 8);
    // An edge with no triangle beside it also ends a blocked range.
    let passable = |k: usize| {
        let diagonal = k % 2 == 1;
        at(k) && (!diagonal || open(k) || open(k + 7))
    };
    (0..8).filter(|&k| passable(k) || open(k) || open(k + 7)).any(|start| {
        let blocked =
            (start..start + 8).take_while(|&k| !open(k) && (k == start || !passable(k))).count();
        (1..4).contains(&blocked)
    })
}
