// Writes the initial values of sources where they are earlier than the present fronts. One invocation is one
// texel with sources in it. It does nothing if the column of the texel is negative. If tiles follow, the
// tiles around the texel are put on the first list. If scans follow, the blocks with the texel become due in
// all scans.
// Twin: the start of a map in src/cpu.

#include "update/tag.glsl"

layout(local_size_x = WORKGROUP) in;

layout(push_constant) uniform Count {
    ivec2 texels; // columns and rows of texels, without the border
    int count;
    uint follows; // SCANS_FOLLOW or TILES_FOLLOW
    int tile_texels; // number of texels on a side of a tile
};
#define TEXELS tile_texels
#include "passes/tiles.glsl"
#include "passes/blocks.glsl"
#include "shared/seed_texel.glsl"

layout(set = 2, binding = 0, rgba32f) uniform restrict image2DArray new_fronts;
layout(set = 0, binding = 3) readonly restrict buffer Seeds {
    SeedTexel seeds[];
};

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= count) return;
    ivec2 texel = seeds[index].texel;
    if (texel.x < 0) return;
    vec4 time = imageLoad(new_fronts, ivec3(texel, TIME));
    vec4 carried = imageLoad(new_fronts, ivec3(texel, CARRIED));
    vec4 times = seeds[index].times;
    // An exact seed replaces a front that arrives at the same time.
    bvec4 exact = equal(floatBitsToUint(seeds[index].curvatures) & SCAN_OF_TAG, uvec4(EXACT));
    bvec4 first = mix(lessThan(times, time), lessThanEqual(times, time), exact);
    // Sources may start after the limit.
    first = mix(first, bvec4(false), greaterThan(times, vec4(limit)));
    imageStore(new_fronts, ivec3(texel, TIME), mix(time, times, first));
    imageStore(new_fronts, ivec3(texel, CARRIED), mix(carried, seeds[index].curvatures, first));
    ivec2 inner = without_border(texel);
    note_place(inner);
    if (follows == uint(SCANS_FOLLOW)) {
        int pitch = pitch_of(texels);
        make_both_due(DOWN, inner.y, pitch);
        make_both_due(RIGHT, inner.x, pitch);
        return;
    }
    uint urgency = urgency_of(min(min(times.x, times.y), min(times.z, times.w)));
    enlist_around(texel - 1, texel + 1, urgency, 0u, tiles_of(texels));
}
