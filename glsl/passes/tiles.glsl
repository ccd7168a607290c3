// Manages tiles of TEXELS x TEXELS texels. A tile is due if a front in it or beside it has changed since its last
// visit. Tiles are visited approximately in the order of the earliest arrival times that have changed, so that most
// fronts do not have to be replaced later. A tile waits while the first tile is due much earlier (see waits()). Waiting
// affects the order of visits, but not the map. The including shader defines TEXELS.

#include "shared/progress.glsl"
#include "shared/start.glsl"
#include "shared/processor.glsl"
#include "shared/groups.glsl"

layout(set = 2, binding = 1) restrict buffer Tiles {
    // Six arrays with an element for each tile of the grid: the tiles' states (see image_before()); the rounds for
    // which they are listed, counted from 1; the lists of even rounds and of odd rounds; and the urgencies in even
    // rounds and in odd rounds. A round sets urgencies for the next round while its own tiles clear theirs, so even and
    // odd rounds have separate arrays.
    uint tiles[];
};

// Returns the number of tiles of a grid, in columns and rows, given its size in texels.
ivec2 tiles_of(ivec2 texels) {
    return (texels + TEXELS - 1) / TEXELS;
}

// Returns a tile's first texel.
ivec2 first_texel_of(ivec2 tile) {
    return with_border(TEXELS * tile);
}

// Returns the tile to which a texel belongs. A texel of the border belongs to the tile beside it.
ivec2 tile_with(ivec2 texel, ivec2 tile_grid) {
    return clamp(without_border(texel) / TEXELS, ivec2(0), tile_grid - 1);
}

// Returns the image that held a tile's fronts before a round. The state of a tile is twice the number of the
// last round that visited it, counted from 1, plus one if its fronts are in image 1 after that round. During
// a round, the old and the new state of a visited tile give the same result.
uint image_before(uint state, uint round) {
    uint image = state & 1u;
    return (state >> 1) == round + 1u ? 1u - image : image;
}

// Returns the number of workgroups in a column of a dispatch of up to `count` tiles, with one workgroup for each tile.
// There are at most MOST_GROUPS columns, which every device supports, and columns are as short as this allows.
// Twin: column_of in src/vulkan/device/limits.rs.
uint column_of(uint count) {
    return (count + MOST_GROUPS - 1u) / MOST_GROUPS;
}

// Returns the index of this workgroup in such a dispatch. In the last column the index may exceed the number of tiles.
uint place_in_dispatch(uint count) {
    return group_number().x * column_of(count) + group_number().y;
}

// Returns the urgency of a tile that is due at a time: larger for earlier times. An urgency of 0 means not due.
uint urgency_of(float time) {
    return ~rank_of(time);
}

float due_at(uint urgency) {
    return time_of(~urgency);
}

// Returns where the urgency of a tile in a round is stored. `count` is the number of tiles.
uint urgency_at(uint tile, uint for_round, uint count) {
    return (4u + (for_round & 1u)) * count + tile;
}

// Puts a tile on the list for a round, unless it is on it already, and raises its urgency to `urgency` if that is
// larger. `count` is the number of tiles.
void enlist(uint tile, uint urgency, uint for_round, uint count) {
    atomicMax(tiles[urgency_at(tile, for_round, count)], urgency);
    uint of_round = ROUND_WORDS * for_round;
    atomicMax(rounds[of_round + 5u], urgency);
    if (atomicExchange(tiles[count + tile], for_round + 1u) == for_round + 1u) return;
    uint place = atomicAdd(rounds[of_round + 3u], 1u);
    tiles[(2u + (for_round & 1u)) * count + place] = tile;
    if (place % column_of(count) == 0u) atomicAdd(rounds[of_round], 1u);
}

// Puts all tiles with texels from `low` to `high` on the list for a round.
void enlist_around(ivec2 low, ivec2 high, uint urgency, uint for_round, ivec2 tile_grid) {
    ivec2 first = tile_with(low, tile_grid);
    ivec2 last = tile_with(high, tile_grid);
    for (int row = first.y; row <= last.y; row++) {
        for (int col = first.x; col <= last.x; col++) {
            uint tile = uint(row_major(ivec2(col, row), tile_grid.x));
            enlist(tile, urgency, for_round, uint(tile_grid.x * tile_grid.y));
        }
    }
}

// Returns whether a tile must wait for the next round. On a GPU no tile waits on a short list, since a few tiles take
// no longer than one.
bool waits(uint urgency, uint round) {
    if (ON_PROCESSOR == 0 && rounds[ROUND_WORDS * round + 3u] <= uint(FEW_TILES)) return false;
    float band = BAND_SIDES * float(2 * TEXELS) * typical_edge;
    return band > 0.0 && due_at(urgency) > due_at(rounds[ROUND_WORDS * round + 5u]) + band;
}
