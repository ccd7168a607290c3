// Computes the direction in which the way back leaves each grid point, as a unit vector in columns and rows.
// Copies of a point of a glued surface have the same direction, each in the columns and rows of its own side, except at
// poles and at the corners of octahedral maps. One invocation is one point.
// Twin: crates/geometry/src/directions, in double precision.

layout(local_size_x = WORKGROUP) in;

#include "passes/way.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(at, grid)) return;
    vec2 way = is_reached(time_at(at)) ? way_from(at) : vec2(0.0);
    ways[word_of(1, index_of(at))] = packHalf2x16(way);
}
