// Computes the edge lengths of a surface given by its metric. The lengths at both ends of an edge are
// averaged, weighted by slowness. One invocation is one grid point.
// Twin: crates/surface/src/measure.rs.

#include "passes/band.glsl"

layout(local_size_x = WORKGROUP) in;

struct Point {
    vec3 metric; // entries of the metric: rr, rc, cc
    float slowness;
};

layout(set = 0, binding = 3) readonly restrict buffer Points {
    vec4 points[]; // metric and slowness, row-major
};

Point load(ivec2 at) {
    vec4 point = points[buffer_index(at)];
    return Point(point.xyz, point.w);
}

float step_length(vec3 metric, ivec2 step) {
    vec3 squares = vec3(step.y * step.y, 2 * step.x * step.y, step.x * step.x);
    return sqrt(max((metric.x * squares.x + metric.y * squares.y) + metric.z * squares.z, 0.0));
}

#include "passes/edges.glsl"

void measure_turns(ivec2 at) {} // a metric has no normals that could turn

// Returns the mean of the lengths at both ends, weighted by the slowness there. Multiplied by the mean
// slowness, it gives the mean of the products of slowness and length at both ends. The host's data may
// consist of these products.
float separation(ivec2 at, ivec2 step) {
    Point a = load(at);
    Point b = load(at + step);
    float sum = a.slowness * step_length(a.metric, step) + b.slowness * step_length(b.metric, step);
    return sum / (a.slowness + b.slowness);
}

#include "passes/skew.glsl"
