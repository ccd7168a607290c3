// Writes the points of a glued grid as the passes of edges read them, and adds points beyond sides where the grid
// goes on. Include after points.glsl.
//
// All copies of a point take the values of the first, and are holes if any of them is.
// Twin: Surface::agree() in crates/surface/src/gluing/compile.rs.

#include "shared/lattice.glsl"

// The list of copies is bound in place of an output buffer, which this pass does not need.
layout(set = 1, binding = 1) readonly restrict buffer CopiesByRow {
    uint copies[];
};

#include "shared/copies_by_row.glsl"

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(place, ivec2(grid.x + 2 * halo.x, band_rows))) return;
    ivec2 at = place + ivec2(-halo.x, first_row);
    ivec2 from = on_grid(at);
    bool present = in_grid(from, grid);
    if (!present) from = ivec2(0);
    ivec2 members = members_of(from);
    bool has_copies = present && members.x < members.y;
    if (has_copies) from = member(members.x);
    present = present && is_given(from);
    for (int i = members.x + 1; has_copies && present && i < members.y; i++) present = is_given(member(i));
    write_point(row_major(place, grid.x + 2 * halo.x), from, present);
    if (!present && in_grid(at, grid)) count_hole(place.y);
}
