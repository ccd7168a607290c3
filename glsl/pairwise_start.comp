#version 450
#extension GL_GOOGLE_include_directive : require
// The maps of a batch before the first iteration: no point reached but their sources. One
// invocation is one texel, the border's too, of one map.
// Twin: Fronts::start in src/cpu/state.rs.

#include "constants.glsl"
#include "texel.glsl"
#include "update.glsl"
#include "pairwise_progress.glsl"
#include "pairwise_layers.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 4, rgba32f) uniform writeonly restrict image2DArray new_fronts_0;
layout(set = 0, binding = 5, rgba32f) uniform writeonly restrict image2DArray new_fronts_1;

layout(push_constant) uniform Size {
    ivec2 grid; // columns and rows of points
};

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    uint map = gl_WorkGroupID.z;
    if (texel.x >= (grid.x + 1) / 2 + 2 * BORDER || maps[map].done != 0u) return;
    int source = int(maps[map].source);
    ivec2 point = ivec2(source % grid.x, source / grid.x) + 2 * BORDER;
    bvec4 here = equal(ivec4(0, 1, 2, 3), ivec4(2 * (point.y & 1) + (point.x & 1)));
    here = bvec4(uvec4(here) & uvec4(texel == point / 2));
    vec4 time = mix(vec4(FAR), vec4(0.0), here);
    imageStore(new_fronts_0, ivec3(texel, layer_of(map, TIME)), time);
    imageStore(new_fronts_1, ivec3(texel, layer_of(map, TIME)), time);
    if (HAS_TWO_LAYERS) {
        vec4 curvature = mix(vec4(0.0), vec4(with_tag(SOURCE_CURVATURE, 0u)), here);
        imageStore(new_fronts_0, ivec3(texel, layer_of(map, CURVATURE)), curvature);
        imageStore(new_fronts_1, ivec3(texel, layer_of(map, CURVATURE)), curvature);
    }
}
