// Repeats updates from four triangles in registers, to measure the rate of a pass that only computes. One
// invocation is one texel. The texel is written at the end; otherwise a compiler would remove the updates.

#include "update/wavefront.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 2, binding = 0, rgba32f) uniform writeonly restrict image2DArray new_fronts;

layout(push_constant) uniform Work {
    ivec2 texels; // columns and rows of texels
    uint repeats; // number of updates from four triangles
};

void main() {
    ivec2 inner = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(inner, texels)) return;
    vec4 surface = vec4(0.01);
    EndFronts front = EndFronts(1.0 + vec4(0.0, 0.3, 0.6, 0.9) + 1e-4 * inner.x, vec4(0.5), surface, vec4(1.0));
    vec4 lengths = vec4(1.0, 1.1, 1.2, 1.3);
    for (uint i = 0u; i < repeats; i++) {
        EndFronts beside = EndFronts(front.time.yzwx, front.carried.yzwx, surface, vec4(1.0));
        Fronts found = update(front, beside, surface, vec4(1.0), lengths, lengths.yzwx, lengths.zwxy, bvec4(false));
        front = EndFronts(found.time, found.carried, surface, vec4(1.0));
        // Changes the lengths, so that a compiler cannot compute the shapes of triangles before the loop.
        lengths += 1e-9 * found.time;
    }
    imageStore(new_fronts, ivec3(with_border(inner), TIME), front.time + front.carried);
}
