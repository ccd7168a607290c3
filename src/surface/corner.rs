//! Corners of holes: the grid points at which a shortest path can bend.

use super::chart::Direction;

/// Whether less than half a turn around a grid point, between two directions in which one can go, is
/// blocked: where a shortest path can bend. Told by which of its neighbours are there, in the order of
/// [`Direction::ALL`].
pub(crate) fn is_corner(there: [bool; Direction::ALL.len()]) -> bool {
    let at = |index: usize| there[index % 8];
    // Eighth k lies between directions k and k + 1, of which the odd ones are diagonals. It
    // is open if its triangle is there, or that of the cell's half it is cut from.
    let cell = |k: usize| {
        let first = k / 2 * 2;
        [at(first), at(first + 1), at(first + 2)]
    };
    let open = |k: usize| match cell(k) {
        [true, _, true] => true,
        [a, true, b] => {
            if k.is_multiple_of(2) {
                a
            } else {
                b
            }
        }
        _ => false,
    };
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
