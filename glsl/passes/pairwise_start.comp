// Initializes the maps of a batch before the first iteration: only the sources are reached. One invocation is
// one texel of one map, including texels of the border.
// Twin: the start of a map in src/cpu.

#include "passes/pairwise_progress.glsl"
#include "passes/pairwise_layers.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform writeonly restrict image2DArray fronts_1;
layout(set = 2, binding = 0, rgba32f) uniform writeonly restrict image2DArray fronts_0;

layout(push_constant) uniform Size {
    ivec2 grid; // columns and rows of points
};

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    uint map = gl_WorkGroupID.z;
    if (is_beyond(texel, all_texels(texels_of(grid))) || maps[map].done != 0u) return;
    ivec2 point = point_at(source_of(map));
    bvec4 here = equal(ivec4(0, 1, 2, 3), ivec4(component_of(point)));
    here = both(here, bvec4(texel == texel_of(point)));
    vec4 time = mix(vec4(FAR), vec4(0.0), here);
    imageStore(fronts_0, ivec3(texel, layer_of(map, TIME)), time);
    imageStore(fronts_1, ivec3(texel, layer_of(map, TIME)), time);
    if (CARRIES) {
        vec4 carried = mix(vec4(0.0), vec4(with_tag(SOURCE_CURVATURE, SOURCE_TAG)), here);
        imageStore(fronts_0, ivec3(texel, layer_of(map, CARRIED)), carried);
        imageStore(fronts_1, ivec3(texel, layer_of(map, CARRIED)), carried);
    }
}
