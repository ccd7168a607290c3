#version 450
#extension GL_GOOGLE_include_directive : require
// After the rounds of a recording, brings all fronts back to image 0 and forgets when tiles were
// visited. One workgroup is one tile, one invocation some of its texels; the first of all also
// counts the rounds and decides whether more follow.
// Twin: Tiles::settle in src/cpu/twins/tile_rounds.rs.

#include "constants.glsl"
#include "texel.glsl"
#include "progress.glsl"
#include "tiles.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts_1;
layout(set = 0, binding = 4, rgba32f) uniform writeonly restrict image2DArray new_fronts_0;

layout(push_constant) uniform Recording {
    ivec2 texels; // columns and rows of texels, without the border
    uint count;   // of rounds
};

void count_rounds() {
    uint visited = 0u;
    while (visited < count && rounds[3 * visited] > 0u) visited += 1u;
    iterations += visited;
    if (visited > 0u) last_residual = unsettled[visited - 1u];
    since_reached = reached != 0u ? 0u : since_reached + visited;
    if (since_reached >= PATIENCE) renews = 0u;
    if (visited < count || rounds[3 * count] == 0u) done = 1u;
    if (iterations >= most) done = 1u;
    // A recording that goes on takes its first list from here.
    if (done != 0u) rounds[3 * count] = 0u;
}

void main() {
    ivec2 tile_grid = tiles_of(texels);
    uint number = gl_WorkGroupID.x;
    if (number == 0u && gl_LocalInvocationIndex == 0u && done == 0u) count_rounds();
    if ((tiles[number] & 1u) != 0u) {
        ivec2 corner = TEXELS * ivec2(int(number) % tile_grid.x, int(number) / tile_grid.x);
        if (gl_LocalInvocationIndex == 0u) {
            ivec2 size = min(ivec2(TEXELS), texels - corner);
            atomicAdd(settled, uint(size.x * size.y));
        }
        for (uint i = gl_LocalInvocationIndex; i < TEXELS * TEXELS; i += WORKGROUP) {
            ivec2 texel = corner + ivec2(int(i) % TEXELS, int(i) / TEXELS);
            if (any(greaterThanEqual(texel, texels))) continue;
            ivec2 at = texel + BORDER;
            for (int layer = 0; layer < LAYERS; layer++) {
                imageStore(new_fronts_0, ivec3(at, layer), imageLoad(fronts_1, ivec3(at, layer)));
            }
        }
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) tiles[number] = 0u;
}
