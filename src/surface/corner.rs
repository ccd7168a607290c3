//! Corners of holes: the grid points at which a shortest path can bend.

use super::chart::{Direction, ring};

/// Which of the neighbours of a grid point are there, in the order of [`Direction::ALL`].
type There = [bool; Direction::ALL.len()];

/// Whether one can go from a grid point between two directions that follow one another, `eighth` and the
/// next: if their triangle is there, or that of the cell's half it is cut from.
pub(crate) fn is_open(there: There, eighth: usize) -> bool {
    let first = eighth / 2 * 2;
    let diagonal = ring::next(first);
    // Of a cell.
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

/// Whether less than half a turn around a grid point, between two directions in which one can go, is
/// blocked: where a shortest path can bend.
pub(crate) fn is_corner(there: There) -> bool {
    let at = |index: usize| there[index % 8];
    let open = |eighth: usize| is_open(there, eighth % 8);
    // Edges with no triangle beside them end a blocked range too.
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
