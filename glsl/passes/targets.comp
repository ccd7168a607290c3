// Ends a map once fronts have reached the number of targets that is needed. The end is the arrival time at
// the last of these nearest targets. On maps solved by tiles, this pass also lowers the limit, so that later
// fronts are not followed. Scans bring early and late fronts in any order, so with them the whole map is
// computed. One workgroup runs between two rounds of tiles, or between two iterations.
// Twin: Limit::lower in crates/cpu/src/limit.rs.

layout(push_constant) uniform Ends {
    ivec2 texels; // columns and rows of texels, without the border
    int tile_texels; // number of texels on a side of a tile
    uint follows; // TILES_FOLLOW if the map is solved by rounds of tiles
};
#define TEXELS tile_texels
#include "passes/tiles.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts_1;
layout(set = 2, binding = 0, rgba32f) uniform readonly restrict image2DArray fronts_0;

// Ranks of the times at the targets, and how many of them are not above a bound.
shared uint ranks[MOST_TARGETS];
shared uint within;

float time_at_target(uint index) {
    ivec2 point = point_at(ivec2(targets[2u * index + 1u], targets[2u * index]));
    ivec2 texel = texel_of(point);
    vec4 times = imageLoad(fronts_0, ivec3(texel, TIME));
    if (follows == uint(TILES_FOLLOW)) {
        ivec2 tile_grid = tiles_of(texels);
        uint state = tiles[row_major(tile_with(texel, tile_grid), tile_grid.x)];
        if ((state & 1u) != 0u) times = imageLoad(fronts_1, ivec3(texel, TIME));
    }
    return times[component_of(point)];
}

// Returns the `needed`-th smallest rank, found from its first binary digit to its last.
uint last_needed(uint count, uint needed) {
    uint last = 0u;
    for (int bit = 31; bit >= 0; bit--) {
        uint bound = last | ((1u << bit) - 1u);
        barrier();
        if (gl_LocalInvocationIndex == 0u) within = 0u;
        barrier();
        for (uint i = gl_LocalInvocationIndex; i < count; i += WORKGROUP) {
            if (ranks[i] <= bound) atomicAdd(within, 1u);
        }
        barrier();
        if (within < needed) last |= 1u << bit;
    }
    return last;
}

void main() {
    // The layers that check shaders on the device cannot read buffers in the conditions of loops.
    uint count = target_count;
    for (uint i = gl_LocalInvocationIndex; i < count; i += WORKGROUP) ranks[i] = rank_of(time_at_target(i));
    float last = time_of(last_needed(count, targets_needed));
    if (gl_LocalInvocationIndex > 0u || last >= FAR) return;
    if (follows == uint(TILES_FOLLOW)) limit = min(limit, last + abs(last) * TARGET_MARGIN);
    end = min(limit, last);
}
