#version 450
#extension GL_GOOGLE_include_directive : require
// Unpacks arrival times into an image with one distance a texel. One invocation is one texel of the
// fronts.

#include "constants.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts;
layout(set = 1, binding = 3, r32f) uniform writeonly restrict image2D distances;

layout(push_constant) uniform Size {
    ivec2 grid;      // columns and rows of the whole grid
    float unreached; // what stands for points that are not reached
};

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (2 * texel.x >= grid.x || 2 * texel.y >= grid.y) return;
    vec4 times = imageLoad(fronts, ivec3(texel + BORDER, TIME));
    for (int i = 0; i < 4; i++) {
        ivec2 point = 2 * texel + ivec2(i & 1, i >> 1);
        if (point.x >= grid.x || point.y >= grid.y) continue;
        imageStore(distances, point, vec4(times[i] < FAR ? times[i] : unreached));
    }
}
