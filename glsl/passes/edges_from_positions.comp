// Computes the edge lengths of a surface given by 3D points. One invocation is one grid point. Also samples how sharply
// the surface turns, and stores the slowness where it varies (edges.glsl).
// Twin: crates/surface/src/measure.rs.

#include "passes/band.glsl"

layout(local_size_x = WORKGROUP) in;

struct Point {
    vec3 position;
    float slowness;
};

layout(set = 0, binding = 3) readonly restrict buffer Points {
    vec4 points[]; // position and slowness, row-major; slowness 0 in a hole
};

Point load(ivec2 at) {
    vec4 point = points[buffer_index(at)];
    return Point(point.xyz, point.w);
}

#include "passes/edges.glsl"

vec3 difference(Point a, Point b, ivec2 step) {
    return b.position - a.position;
}

#include "update/arc.glsl"
#include "passes/turns.glsl"
#include "passes/skew.glsl"
