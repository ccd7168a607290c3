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

// Returns how far the host's data of two points are apart: a distance, a difference of heights, or the largest
// difference between entries of a metric.
float apart(ivec2 a, ivec2 b) {
    vec3 of_each = vec3(0.0);
    for (int i = 0; i < components(); i++) of_each[i] = abs(component(a, i) - component(b, i));
    return is_metric != 0 ? max(of_each.x, max(of_each.y, of_each.z)) : length(of_each);
}

// Returns the size with which a gap at a point is compared: the longest edge along rows and columns, or the larger of
// the diagonal entries of a metric.
float cell_size(ivec2 at) {
    if (is_metric != 0) return max(component(at, 0), component(at, 2));
    const ivec2 steps[] = {ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1)};
    float longest = 0.0;
    for (int i = 0; i < 4; i++) {
        ivec2 there = at + steps[i];
        if (!in_grid(there, grid) || !is_given(there)) continue;
        float across = heights != 0 ? dot(abs(vec2(steps[i])), spacing) : 0.0;
        longest = max(longest, length(vec2(across, apart(at, there))));
    }
    return longest;
}

// Notes the gap between a point and the first copy, relative to a cell: the leading bits of a float, and then the
// number of the group, or the largest number that there is room for.
void note_gap(ivec2 at, ivec2 first, int group) {
    float gap = apart(at, first);
    if (!(gap > 0.0)) return;
    float size = max(cell_size(at), cell_size(first));
    uint bits = floatBitsToUint(size > 0.0 ? min(gap / size, FAR) : FAR) >> (GAP_GROUP_BITS - 1);
    atomicMax(seam_gap, bits << GAP_GROUP_BITS | min(uint(group), (1u << GAP_GROUP_BITS) - 1u));
}

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(place, ivec2(grid.x + 2 * halo.x, band_rows))) return;
    ivec2 at = place + ivec2(-halo.x, first_row);
    ivec2 from = on_grid(at);
    bool present = in_grid(from, grid);
    if (!present) from = ivec2(0);
    int group = present ? group_of(from) : -1;
    ivec2 members = group < 0 ? ivec2(0) : members_of_group(group);
    bool has_copies = present && members.x < members.y;
    if (has_copies) from = member(members.x);
    present = present && is_given(from);
    for (int i = members.x + 1; has_copies && present && i < members.y; i++) present = is_given(member(i));
    write_point(row_major(place, grid.x + 2 * halo.x), from, present);
    if (present && has_copies && in_grid(at, grid)) note_gap(at, from, group);
    if (!present && in_grid(at, grid)) count_hole(place.y);
}
