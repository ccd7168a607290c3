// Computes the metric at points of seams, and carries steps from a point to its copies.
// Twins: turn_at_copy() in crates/surface/src/gluing/places.rs; at_copy() in crates/geometry/src/directions/ways.rs, where positions
// are known.

#include "shared/seams.glsl"
#include "passes/over_seams.glsl"
#include "passes/local_metric.glsl"

// Returns the metric at a grid point, from edges on both sides of a seam where the grid goes on.
Metric metric_over_seams(ivec2 at, float unit) {
    if (SEAMS == 0) return metric_of_point(at, unit);
    ivec2 point = point_at(at);
    float sizes[8];
    for (int i = 0; i < 8; i++) sizes[i] = edge_over_seams(point, NEIGHBOURS[i]);
    return metric_of_edges(vec4(sizes[0], sizes[2], sizes[1], sizes[3]), vec4(sizes[4], sizes[6], sizes[5], sizes[7]), unit);
}

const int OVER_COLS = 0;
const int OVER_ROWS = 1;

// Moves a point of the first or last column (OVER_COLS) or row to its copy in the other of these, and converts a step at
// the point to the same step at the copy. Returns false if the grid does not go on there.
bool cross_side(int across, inout ivec2 at, inout vec2 step) {
    int along = 1 - across;
    ivec2 last = grid - 1;
    if (lattice[across] == GRID_ENDS || (at[across] != 0 && at[across] != last[across])) return false;
    at[across] = last[across] - at[across];
    if (lattice[across] == REVERSES) {
        at[along] = last[along] - at[along];
        step[along] = -step[along];
    }
    return true;
}

// Returns whether an edge along a row or a column leads from a point.
bool has_edge_along(ivec2 at, ivec2 step) {
    return edge_length(point_at(at), step) < FAR;
}

// Carries a step over a seam at which columns and rows do not go on, as at a fold. Its part along the seam and its part
// across keep their lengths. The step begins in a cell of `from`, and so it leads away from the cells of the copy. Returns
// zero where no edge of the seam leads from both copies, as at poles and between opposite corners of an octahedral map.
vec2 step_over_fold(ivec2 from, ivec2 copy, vec2 step) {
    float unit = longest_edge(from);
    Metric here = metric_of_point(from, unit);
    Metric there = metric_of_point(copy, unit);
    if (!is_usable(here) || !is_usable(there)) return vec2(0.0);
    for (int i = 0; i < 16; i++) {
        ivec2 along = NEIGHBOURS[2 * (i / 4)];
        ivec2 other = NEIGHBOURS[2 * (i % 4)];
        // There may be holes beside a seam, as between the faces of a cube.
        if (!has_edge_along(from, along) || !has_edge_along(copy, other)) continue;
        if (first_copy(from + along) != first_copy(copy + other)) continue;
        vec2 unit_along = vec2(along) / sqrt(product(here, vec2(along), vec2(along)));
        vec2 unit_other = vec2(other) / sqrt(product(there, vec2(other), vec2(other)));
        float part = product(here, step, unit_along);
        float across = sqrt(max(product(here, step, step) - part * part, 0.0));
        ivec2 inward = other.yx;
        if (!has_edge_along(copy, inward)) inward = -inward;
        vec2 outward = product(there, vec2(inward), unit_other) * unit_other - vec2(inward);
        return part * unit_other + across / sqrt(product(there, outward, outward)) * outward;
    }
    return vec2(0.0);
}

// Returns the step at `copy`, a copy of the point `from`, that is the same as `step` at that point.
vec2 step_at_copy(ivec2 from, ivec2 copy, vec2 step) {
    if (SEAMS == 0 || from == copy) return step;
    ivec2 at = from;
    vec2 turned = step;
    if (cross_side(OVER_COLS, at, turned) && at == copy) return turned;
    if (cross_side(OVER_ROWS, at, turned) && at == copy) return turned;
    at = from;
    turned = step;
    if (cross_side(OVER_ROWS, at, turned) && at == copy) return turned;
    return step_over_fold(from, copy, step);
}
