#version 450
#extension GL_GOOGLE_include_directive : require
// Edge lengths of a surface given by its metric, averaged over an edge's two ends by their slowness. One
// invocation is one grid point.

#include "constants.glsl"
#include "chart.glsl"
#include "band.glsl"

layout(local_size_x = WORKGROUP) in;

struct Point {
    vec3 metric; // rr, rc, cc
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

#include "edges.glsl"

void look_at_turns(ivec2 at) {} // Nobody knows.

// Of two points that differ in slowness, such that times their mean it is the mean of the products: what is
// given may be the products alone.
float separation(ivec2 at, ivec2 step) {
    Point a = load(at);
    Point b = load(at + step);
    float sum = a.slowness * step_length(a.metric, step) + b.slowness * step_length(b.metric, step);
    return sum / (a.slowness + b.slowness);
}
