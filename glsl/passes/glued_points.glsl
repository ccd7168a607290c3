// Writes the points of a glued grid as the passes of edges read them, and adds points beyond sides where the grid
// goes on. Include after points.glsl.
//
// All copies of a point take the values of the first, and are holes if any of them is.
// Twin: Surface::agree() in src/surface/gluing/compile.rs.

#include "shared/lattice.glsl"

// The list is bound in place of an output buffer, which this pass does not need. src/vulkan/copies.rs writes it.
layout(set = 1, binding = 1) readonly restrict buffer CopiesByRow {
    // The number of groups. Then for each row its first copy, and the number of copies at the end. Then for each
    // copy its column, and for each the number of its group. Then for each group its first member, and their
    // number at the end. Then the members of groups, by their row-major indices.
    uint copies[];
};

const int ROWS = 1;

// Returns the number of copies, and where the columns of copies and the first members of groups are.
int all_copies() {
    return int(copies[ROWS + grid.y]);
}

int first_col() {
    return ROWS + grid.y + 1;
}

int first_group() {
    return first_col() + 2 * all_copies();
}

// Returns the members of a point's group: the first of them, and the one after the last. Points without copies
// have none.
ivec2 members_of(ivec2 at) {
    int low = int(copies[ROWS + at.y]);
    int end = int(copies[ROWS + at.y + 1]);
    int high = end;
    while (low < high) {
        int middle = (low + high) / 2;
        if (int(copies[first_col() + middle]) < at.x) low = middle + 1; else high = middle;
    }
    if (low == end || int(copies[first_col() + low]) != at.x) return ivec2(0);
    int group = first_group() + int(copies[first_col() + all_copies() + low]);
    return ivec2(copies[group], copies[group + 1]);
}

// Returns the point with this number among the members of groups.
ivec2 member(int number) {
    int members = first_group() + int(copies[0]) + 1;
    return from_row_major(int(copies[members + number]), grid.x);
}

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
