// Reads the lengths of edges from their image.

layout(set = 0, binding = 0, rgba32f) uniform readonly restrict image2D edges;

// Returns the length of the edge from a point to a neighbour.
float edge_length(ivec2 point, ivec2 step) {
    bool here = stored_here(step);
    return stored_length(imageLoad(edges, here ? point : point + step), here ? step : -step);
}

// Returns whether any edge leads from a point.
bool has_edge(ivec2 point) {
    for (int i = 0; i < 8; i++) {
        if (edge_length(point, NEIGHBOURS[i]) < FAR) return true;
    }
    return false;
}

// Returns the lengths of a point's edges that are stored at their other ends: to the west, south, south-west
// and south-east.
vec4 edges_to_point(ivec2 point) {
    return vec4(imageLoad(edges, point + ivec2(-1, 0)).x, imageLoad(edges, point + ivec2(0, 1)).y,
                imageLoad(edges, point + ivec2(-1, 1)).z, imageLoad(edges, point + ivec2(1, 1)).w);
}

// Returns the lengths of the six edges of a cell, in this order: north, west, north-west to south-east,
// south-west to north-east, east, south.
float[6] edges_of_cell(ivec2 first) {
    vec4 from_north_west = imageLoad(edges, first);
    vec4 from_south_west = imageLoad(edges, first + to_corner(2));
    vec4 from_south_east = imageLoad(edges, first + to_corner(3));
    return float[](from_north_west.x, from_south_west.y, from_south_east.w,
                   from_south_west.z, from_south_east.y, from_south_west.x);
}
