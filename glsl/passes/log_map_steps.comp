// Takes the first step of the ways of a log map: one cell along the directions from log_map_ways.comp. The
// direction is interpolated half a cell back, between grid points. One invocation is one point.
// Twin: none; tests compare log maps with those of crates/geometry/src/directions.

layout(local_size_x = WORKGROUP) in;

#include "passes/log_map.glsl"

// Least cosine of the angle between the ways of neighbours that follow the same front.
const float SAME_FRONT = 0.85;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(at, grid)) return;
    int index = index_of(at);
    vec2 way = read_pair(1, index);
    vec2 place = way;
    if (is_way(way)) {
        vec2 half_way = back_on_grid(vec2(at) + 0.5 * way, grid);
        Around near = around(half_way, 1);
        vec2 sum = vec2(0.0);
        for (int i = 0; i < 4; i++) {
            vec2 other = read_pair(1, near.points[i]);
            if (near.weights[i] > 0.0 && dot(other, way) > SAME_FRONT) sum += near.weights[i] * other;
        }
        float size = length(sum);
        place = back_on_grid(vec2(at) + (size > 0.0 ? sum / size : way), grid);
    }
    write_pair(2, index, place);
}
