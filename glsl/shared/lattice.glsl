// Continues the grid beyond its sides, where opposite sides are glued.
// Counterpart: Lattice::at in crates/surface/src/gluing/lattice.rs, which moves points only and allows for repeated lines.
//
// The including shader declares
//     ivec2 grid;       columns and rows of the whole grid
//     ivec2 lattice;    GRID_ENDS, GOES_ON or REVERSES: in x for the first and last column, in y for the first and last
//                       row

// Moves a point, with the step from it, over glued sides until both ends of the step lie on the grid, or beyond sides
// at which the grid ends. A glued side is the same line as the opposite one, so each move is by one less than the
// number of columns or rows. The step is shorter than the grid.
void continue_grid(inout ivec2 at, inout ivec2 step) {
    // Each iteration moves over one side, in columns or in rows.
    for (int turn = 0; turn < 4; turn++) {
        ivec2 low = min(at, at + step);
        ivec2 high = max(at, at + step);
        ivec2 last = grid - 1;
        if (lattice.x != GRID_ENDS && (low.x < 0 || high.x > last.x)) {
            at.x += low.x < 0 ? last.x : -last.x;
            if (lattice.x == REVERSES) {
                at.y = last.y - at.y;
                step.y = -step.y;
            }
        } else if (lattice.y != GRID_ENDS && (low.y < 0 || high.y > last.y)) {
            at.y += low.y < 0 ? last.y : -last.y;
            if (lattice.y == REVERSES) {
                at.x = last.x - at.x;
                step.x = -step.x;
            }
        } else {
            return;
        }
    }
}

// Returns the point of the grid that coincides with a point beyond its glued sides. Beyond sides at which the grid
// ends, the result lies off the grid.
ivec2 on_grid(ivec2 at) {
    ivec2 step = ivec2(0);
    continue_grid(at, step);
    return at;
}
