#version 450
#extension GL_GOOGLE_include_directive : require
// Initial values of the sources. One invocation is one texel with sources in it.
// Twin: Fronts::start in src/cpu/state.rs.

#include "constants.glsl"

layout(local_size_x = WORKGROUP) in;

struct SeedTexel {
    ivec2 texel;
    ivec2 unused; // vec4 follows on a multiple of 16 bytes
    vec4 times;
    vec4 curvatures;
};

layout(set = 0, binding = 3, rgba32f) uniform writeonly restrict image2DArray fronts;
layout(set = 0, binding = 5) readonly restrict buffer Seeds {
    SeedTexel seeds[];
};

layout(push_constant) uniform Count {
    int count;
};

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= count) return;
    imageStore(fronts, ivec3(seeds[index].texel, TIME), seeds[index].times);
    imageStore(fronts, ivec3(seeds[index].texel, CURVATURE), seeds[index].curvatures);
}
