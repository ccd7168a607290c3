// Removes the fronts that are later than the end of a map. Such fronts arrived before the limit was lowered,
// or were renewed and then came later. An unfinished map keeps them, since further iterations would bring
// them again. One invocation is one texel.
// Twin: the end of a map in src/solve.rs.

#include "shared/progress.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 2, binding = 0, rgba32f) uniform restrict image2DArray new_fronts;

layout(push_constant) uniform Size {
    ivec2 texels; // columns and rows of texels, without the border
};

void main() {
    ivec2 inner = ivec2(gl_GlobalInvocationID.xy);
    if (done == 0u || is_beyond(inner, texels)) return;
    ivec2 texel = with_border(inner);
    vec4 times = imageLoad(new_fronts, ivec3(texel, TIME));
    bvec4 late = greaterThan(times, vec4(end));
    late = mix(late, bvec4(false), greaterThanEqual(times, vec4(FAR)));
    if (!any(late)) return;
    vec4 carried = imageLoad(new_fronts, ivec3(texel, CARRIED));
    imageStore(new_fronts, ivec3(texel, TIME), mix(times, vec4(FAR), late));
    imageStore(new_fronts, ivec3(texel, CARRIED), mix(carried, vec4(0.0), late));
}
