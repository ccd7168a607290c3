// Tiles of TILE x TILE points, of which those are visited whose surroundings have changed, about in the order in which
// fronts arrive: what is brought early is not replaced later. A tile is due at the earliest time that has changed beside
// it, and waits while the first of all is due much earlier. How much decides in which order tiles are visited, and not
// what comes of it.
// Include after progress.glsl.

#include "start.glsl"
#include "processor.glsl"

// Points on a side of a tile.
layout(constant_id = 5) const int TILE = 16;

layout(set = 2, binding = 1) restrict buffer Tiles {
    // For each tile its state, then the round it waits for, then two lists of tiles, then how urgent each tile is in
    // even rounds and in odd ones: rounds set what the next one reads, which no tile of theirs takes away.
    uint tiles[];
};

// Texels on a side of a tile.
const int TEXELS = TILE / 2;

// The tiles of a grid, in columns and rows, whose texels these are.
ivec2 tiles_of(ivec2 texels) {
    return (texels + TEXELS - 1) / TEXELS;
}

// A tile's first texel.
ivec2 first_texel_of(ivec2 tile) {
    return with_border(TEXELS * tile);
}

// The tile that a texel belongs to; of the border's, the tile beside it.
ivec2 tile_with(ivec2 texel, ivec2 tile_grid) {
    return clamp(without_border(texel) / TEXELS, ivec2(0), tile_grid - 1);
}

// The state of a tile is twice the last round that visited it, counted from 1, plus one if its
// fronts are in image 1 after it. During a round both states of a tile that is visited tell a
// neighbour the same: where its fronts were before.
uint image_before(uint state, uint round) {
    uint image = state & 1u;
    return (state >> 1) == round + 1u ? 1u - image : image;
}

// Workgroups of one tile each, of up to so many tiles, are dispatched in columns as short as leave no more of them
// than every device takes. Twin: column_of in src/vulkan/record/commands.rs.
uint column_of(uint count) {
    return (count + MOST_GROUPS - 1u) / MOST_GROUPS;
}

// The place of a workgroup in such a dispatch; the last column may go beyond the tiles.
uint place_in_dispatch(uint count) {
    return gl_WorkGroupID.x * column_of(count) + gl_WorkGroupID.y;
}

// The more, the earlier something is due; 0 if it is not.
uint urgency_of(float time) {
    return ~rank_of(time);
}

float due_at(uint urgency) {
    return time_of(~urgency);
}

// Where a tile, of so many, has its urgency in a round.
uint urgency_at(uint tile, uint for_round, uint count) {
    return (4u + (for_round & 1u)) * count + tile;
}

// Puts a tile, of so many, on the list for a round unless it is there.
void enlist(uint tile, uint urgency, uint for_round, uint count) {
    atomicMax(tiles[urgency_at(tile, for_round, count)], urgency);
    uint of_round = ROUND_WORDS * for_round;
    atomicMax(rounds[of_round + 5u], urgency);
    if (atomicExchange(tiles[count + tile], for_round + 1u) == for_round + 1u) return;
    uint place = atomicAdd(rounds[of_round + 3u], 1u);
    tiles[(2u + (for_round & 1u)) * count + place] = tile;
    if (place % column_of(count) == 0u) atomicAdd(rounds[of_round], 1u);
}

// Whether a tile is to wait for the next round. Few tiles take a GPU no longer than one.
bool waits(uint urgency, uint round) {
    if (ON_PROCESSOR == 0 && rounds[ROUND_WORDS * round + 3u] <= uint(FEW_TILES)) return false;
    float band = BAND_SIDES * float(TILE) * typical_edge;
    return band > 0.0 && due_at(urgency) > due_at(rounds[ROUND_WORDS * round + 5u]) + band;
}
