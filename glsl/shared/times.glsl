// Reads the arrival times of single grid points from the fronts. Up to two points beyond the grid may be
// read; these are never reached.

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts;

float time_at(ivec2 at) {
    ivec2 point = point_at(at);
    return imageLoad(fronts, ivec3(texel_of(point), TIME))[component_of(point)];
}

// Returns the times at the corners of a cell.
vec4 times_at_corners(ivec2 first) {
    return vec4(time_at(first), time_at(first + to_corner(1)), time_at(first + to_corner(2)),
                time_at(first + to_corner(3)));
}

bool is_reached(float time) {
    return time < FAR;
}
