// Computes the edge lengths of a height field. One invocation is one grid point. Also samples how sharply the surface
// turns, and stores the slowness where it varies (edges.glsl).
// Twin: crates/surface/src/measure.rs.

#include "passes/band.glsl"

layout(local_size_x = WORKGROUP) in;

struct Point {
    float height;
    float slowness;
};

layout(set = 0, binding = 3) readonly restrict buffer Points {
    vec2 points[]; // height and slowness, row-major; slowness 0 in a hole
};

Point load(ivec2 at) {
    vec2 point = points[buffer_index(at)];
    return Point(point.x, point.y);
}

#include "passes/edges.glsl"

vec3 difference(Point a, Point b, ivec2 step) {
    return vec3(step * vec2(dx, dy), b.height - a.height);
}

#include "update/arc.glsl"
#include "passes/turns.glsl"
#include "passes/skew.glsl"
