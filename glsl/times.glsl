// Arrival times of single grid points, out of the fronts. Two points beside the grid may be asked
// for, which are never reached.

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts;

float time_at(ivec2 point) {
    ivec2 at = point + 2 * BORDER;
    return imageLoad(fronts, ivec3(at / 2, TIME))[(at.x & 1) + 2 * (at.y & 1)];
}

bool is_reached(float time) {
    return time < FAR;
}
