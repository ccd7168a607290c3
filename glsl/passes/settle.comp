// Copies all fronts back to image 0 after the rounds of a recording, and resets the states of the tiles. One
// workgroup is one tile. One invocation handles some of its texels. The very first invocation also counts the
// rounds and decides whether more follow. It moves the list of the last round to where the first round of the
// next recording reads it.
// Twin: Tiles::settle in crates/cpu/src/twins/tile_round.rs.

layout(local_size_x = WORKGROUP) in;

layout(push_constant) uniform Recording {
    ivec2 texels;    // columns and rows of texels, without the border
    uint count;      // number of rounds
    int tile_texels; // number of texels on a side of a tile
};
#define TEXELS tile_texels
#include "passes/tiles.glsl"

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts_1;
layout(set = 2, binding = 0, rgba32f) uniform writeonly restrict image2DArray fronts_0;

// State of the workgroup's tile.
shared uint state;

// Counts the rounds of the recording, and decides whether more follow.
void count_rounds() {
    uint visited = 0u;
    while (visited < count && rounds[ROUND_WORDS * visited] > 0u) visited += 1u;
    iterations += visited;
    if (visited > 0u) last_residual = unsettled[visited - 1u];
    since_reached = reached != 0u ? 0u : since_reached + visited;
    if (since_reached >= PATIENCE) renews = 0u;
    if (visited < count || rounds[ROUND_WORDS * count] == 0u) done = 1u;
    if (iterations >= most) done = 1u;
    // The next recording takes its first list from the last entry.
    for (uint i = 0u; i < ROUND_WORDS; i++) {
        rounds[ROUND_WORDS * ROUNDS + i] = rounds[ROUND_WORDS * count + i];
    }
    if (done != 0u) rounds[ROUND_WORDS * ROUNDS] = 0u;
}

// Moves an entry of the list of odd rounds to the list of even rounds, and the urgency of the tile with this
// number likewise.
void move_to_even(uint number, uint all) {
    tiles[2u * all + number] = tiles[3u * all + number];
    tiles[urgency_at(number, 0u, all)] = tiles[urgency_at(number, 1u, all)];
    tiles[urgency_at(number, 1u, all)] = 0u;
}

void main() {
    ivec2 tile_grid = tiles_of(texels);
    uint all = uint(tile_grid.x * tile_grid.y);
    uint number = place_in_dispatch(all);
    if (number >= all) return;
    if (gl_LocalInvocationIndex == 0u) {
        if (number == 0u && done == 0u) count_rounds();
        if ((count & 1u) != 0u) move_to_even(number, all);
        state = tiles[number];
        tiles[number] = 0u;
    }
    barrier();
    if ((state & 1u) != 0u) {
        ivec2 first = first_texel_of(from_row_major(int(number), tile_grid.x));
        if (gl_LocalInvocationIndex == 0u) {
            ivec2 size = min(ivec2(TEXELS), texels - without_border(first));
            // The number of copied texels, for profiles.
            atomicAdd(settled, uint(size.x * size.y));
        }
        for (uint i = gl_LocalInvocationIndex; i < TEXELS * TEXELS; i += WORKGROUP) {
            ivec2 texel = first + from_row_major(int(i), TEXELS);
            if (is_beyond(without_border(texel), texels)) continue;
            for (int layer = 0; layer < LAYERS; layer++) {
                imageStore(fronts_0, ivec3(texel, layer), imageLoad(fronts_1, ivec3(texel, layer)));
            }
        }
    }
}
