// Takes the earliest front of each point where the surroundings of several sources meet. One invocation is
// one texel of the surroundings of one source. The first source that has the texel keeps it, and writes the
// earliest fronts of all sources to it.
// Twin: crates/cpu/src/twins/surroundings.rs.

#include "update/tag.glsl"
#include "shared/seed_texel.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 3) restrict buffer Seeds {
    SeedTexel seeds[];
};

layout(push_constant) uniform Count {
    int count; // number of sources
};

const int TEXELS = SURROUNDINGS_TEXELS;
const int OWN_TEXELS = TEXELS * TEXELS;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= count * OWN_TEXELS) return;
    int own = index / OWN_TEXELS;
    ivec2 texel = seeds[index].texel;
    if (texel.x < 0) return;
    vec4 times = seeds[index].times;
    vec4 curvatures = seeds[index].curvatures;
    for (int other = 0; other < count; other++) {
        // No invocation writes `window`, so it can be read here.
        ivec2 at = texel - seeds[other * OWN_TEXELS].window;
        if (other == own || !in_grid(at, ivec2(TEXELS))) continue;
        if (other < own) {
            seeds[index].texel = ivec2(-1);
            return;
        }
        // The invocation of the other texel finds that its source is not the first, and does not write these
        // values.
        int there = other * OWN_TEXELS + row_major(at, TEXELS);
        bvec4 first = lessThan(seeds[there].times, times);
        times = mix(times, seeds[there].times, first);
        curvatures = mix(curvatures, seeds[there].curvatures, first);
    }
    // If the earliest front is not exact, a later front of another source is not exact either.
    times = mix(times, vec4(FAR), equal(floatBitsToUint(curvatures) & SCAN_OF_TAG, uvec4(NOT_EXACT)));
    if (all(greaterThanEqual(times, vec4(FAR)))) seeds[index].texel = ivec2(-1);
    seeds[index].times = times;
    seeds[index].curvatures = curvatures;
}
