// Reads the lengths of edges and finds points beyond sides where the grid goes on.

#include "shared/edge_image.glsl"
#include "shared/lattice.glsl"

// Returns the length of the edge from a point to a neighbour. Either of them may lie beyond a side.
float edge_over_seams(ivec2 point, ivec2 step) {
    ivec2 at = at_point(point);
    continue_grid(at, step);
    return edge_length(point_at(at), step);
}

// Returns the point of the grid that coincides with a point beyond a side.
ivec2 point_over_seams(ivec2 point) {
    return point_at(on_grid(at_point(point)));
}
