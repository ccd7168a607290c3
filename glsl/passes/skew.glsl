// Measures how skewed cells are, at a sample of the points: how far away the points lie that split the obtuse triangles
// in them, if the metric around the point were that of the triangle. So a renderer knows whether updates see all points
// from which fronts arrive.
// Twin: crates/surface/src/skewed_cells.rs, and crates/surface/src/obtuse/reach.rs for the reduced basis.

#include "update/reduced_basis.glsl"

// Returns the number of a point among the points of the sample, or -1 if it is not among them.
int number_in_sample(ivec2 at) {
    ivec2 every = (grid + (LOOKS - 1)) / LOOKS;
    // The points lie at other columns in each row, so that they meet features along columns too.
    int col = at.x - at.y / every.y % every.x;
    if (col < 0 || any(notEqual(ivec2(col, at.y) % every, ivec2(0)))) return -1;
    return row_major(ivec2(col, at.y) / every, LOOKS);
}

// Returns the square of the length of an edge on the surface, or FAR if there is none.
float squared_edge(ivec2 at, ivec2 step) {
    if (!has_edge(at, step)) return FAR;
    float apart = separation(at, step);
    return apart < sqrt(FAR) ? apart * apart : FAR;
}

void measure_skew(ivec2 at) {
    int number = number_in_sample(at);
    int most = 0;
    // CPU drivers pass over a loop in which no invocation takes part.
    for (int i = number < 0 ? 4 : 0; i < 4; i++) {
        ivec2 a = NEIGHBOURS[i];
        ivec2 b = NEIGHBOURS[i + 1];
        if (!has_edge(at, a)) continue;
        vec3 squares = vec3(squared_edge(at, a), squared_edge(at, b), squared_edge(at + a, b - a));
        most = max(most, splits_within(a, b, squares));
    }
    if (most > SPLIT_REACH) atomicMax(skew, uint(most << SAMPLE_BITS) + uint((1 << SAMPLE_BITS) - 1 - number));
}
