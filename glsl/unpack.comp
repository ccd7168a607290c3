#version 450
#extension GL_GOOGLE_include_directive : require
// Unpacks arrival times into rows of distances. One invocation is one texel of a band of rows; the
// third dimension of the dispatch is the map.
// Twin: Solution::distances in src/cpu/state.rs.

#include "constants.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts; // times first
layout(set = 0, binding = 8) writeonly restrict buffer Distances {
    uint distances[]; // bits of floats, row-major: GLSL does not promise infinities
};

layout(push_constant) uniform Band {
    ivec2 grid;     // columns and rows of the whole grid
    int first_row;  // the band's first row, even
    int band_rows;
};

const uint INFINITY = 0x7f800000u;

void write(ivec2 point, float time) {
    if (point.x >= grid.x || point.y >= first_row + band_rows) return;
    int row = int(gl_WorkGroupID.z) * band_rows + point.y - first_row;
    distances[row * grid.x + point.x] =
        time < FAR ? floatBitsToUint(time) : INFINITY;
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row / 2);
    ivec2 point = 2 * texel;
    if (point.x >= grid.x || point.y >= first_row + band_rows) return;
    vec4 packed = imageLoad(fronts, ivec3(texel + BORDER, gl_WorkGroupID.z));
    write(point, packed.x);
    write(point + ivec2(1, 0), packed.y);
    write(point + ivec2(0, 1), packed.z);
    write(point + ivec2(1, 1), packed.w);
}
