#version 450
#extension GL_GOOGLE_include_directive : require
// Puts the fans of a surface into the order in which one of the scans passes them. One invocation
// is one pair of points of a line.
// Twin: FanSlots in src/cpu/pairwise/kernel.rs.

#include "constants.glsl"
#include "texel.glsl"
#include "update.glsl"
#include "fan.glsl"
#include "pairwise_fans.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2D gaussians;
layout(set = 0, binding = 7) writeonly restrict buffer Fans {
    float fans[];
};

layout(push_constant) uniform Size {
    ivec2 grid; // columns and rows of points
    int scan;   // from 0 in the order of an iteration
};

float gaussian_at(ivec2 point) {
    return imageLoad(gaussians, point / 2)[2 * (point.y & 1) + (point.x & 1)];
}

void main() {
    bool by_rows = scan < 2;
    int way = 1 - 2 * (scan & 1);
    ivec2 ahead = by_rows ? ivec2(0, way) : ivec2(way, 0);
    ivec2 along = by_rows ? ivec2(1, 0) : ivec2(0, 1);
    int pairs = ((by_rows ? grid.x : grid.y) + 1) / 2;
    int line = int(gl_GlobalInvocationID.y);
    int pair = int(gl_GlobalInvocationID.x);
    if (pair >= pairs) return;

    ivec2 a = line * abs(ahead) + 2 * pair * along + 2 * BORDER;
    int place = fan_place(grid, scan, line, pair, pairs);
    for (int i = 0; i < 3; i++) {
        ivec2 step = (i - 1) * along - ahead;
        fans[place + i * pairs] = edge_length(a, step);
        fans[place + (3 + i) * pairs] = edge_length(a + along, step);
        fans[place + (6 + i) * pairs] = edge_length(a + step, along);
    }
    if (WAVEFRONT >= 2) {
        for (int i = 0; i < 4; i++) {
            fans[place + (9 + i) * pairs] = gaussian_at(a + (i - 1) * along - ahead);
        }
        fans[place + 13 * pairs] = gaussian_at(a);
        fans[place + 14 * pairs] = gaussian_at(a + along);
    }
}
