// Gives all copies of a point of a glued surface the earliest front among them. It runs after the seeds, each scan
// and each round of tiles.
// A single workgroup is dispatched; see exchange.glsl.
// Twin: src/cpu/fronts/exchange.rs.

#include "update/wavefront.glsl"
#include "shared/progress.glsl"

layout(push_constant) uniform Push {
    ivec2 texels; // columns and rows of texels, without the border
    int parts;
    int members;
    int groups;
    int copy_texels; // number of texels with copies
    int tile_texels; // number of texels on a side of a tile
    int next_round;  // number of the round of tiles that follows, or NO_ROUND
};
#define TEXELS tile_texels
#include "passes/tiles.glsl"
#include "passes/blocks.glsl"

// Whether obtuse triangles are split; see splits.glsl.
layout(constant_id = 6) const int SPLITS = 1;

layout(local_size_x = EXCHANGE_WORKGROUP) in;

// The image that was written last. After a round of tiles it is image 0, and some tiles have their fronts in image 1.
layout(set = 2, binding = 0, rgba32f) uniform restrict image2DArray new_fronts;
layout(set = 0, binding = 2, rgba32f) uniform restrict image2DArray old_fronts;

#include "passes/copies.glsl"

const int NO_ROUND = -1;

// Returns whether the fronts of a texel lie in old_fronts.
bool is_in_old(ivec2 texel) {
    if (next_round == NO_ROUND) return false;
    ivec2 tile_grid = tiles_of(texels);
    return (tiles[row_major(tile_with(texel, tile_grid), tile_grid.x)] & 1u) != 0u;
}

void load(ivec2 texel, out vec4 time, out vec4 held) {
    held = vec4(0.0);
    if (is_in_old(texel)) {
        time = imageLoad(old_fronts, ivec3(texel, TIME));
        if (CARRIES) held = imageLoad(old_fronts, ivec3(texel, CARRIED));
    } else {
        time = imageLoad(new_fronts, ivec3(texel, TIME));
        if (CARRIES) held = imageLoad(new_fronts, ivec3(texel, CARRIED));
    }
}

void store(ivec2 texel, vec4 time, vec4 held) {
    if (is_in_old(texel)) {
        imageStore(old_fronts, ivec3(texel, TIME), time);
        if (CARRIES) imageStore(old_fronts, ivec3(texel, CARRIED), held);
    } else {
        imageStore(new_fronts, ivec3(texel, TIME), time);
        if (CARRIES) imageStore(new_fronts, ivec3(texel, CARRIED), held);
    }
}

bool renews_fronts() {
    return renews != 0u;
}

int slot_of(int part) {
    return part;
}

// Puts the tiles that see a changed point on the list of the next round.
void wake_tiles(ivec2 point, float earlier) {
    const int REACH = SPLITS != 0 ? SPLIT_REACH : 1;
    ivec2 tile_grid = tiles_of(texels);
    ivec2 low = tile_with(texel_of(point - REACH), tile_grid);
    ivec2 high = tile_with(texel_of(point + REACH), tile_grid);
    for (int row = low.y; row <= high.y; row++) {
        for (int col = low.x; col <= high.x; col++) {
            uint tile = uint(row_major(ivec2(col, row), tile_grid.x));
            enlist(tile, urgency_of(earlier), uint(next_round), uint(tile_grid.x * tile_grid.y));
        }
    }
}

// Records that fronts of a texel have changed. Before a round of tiles, the tiles around points that have changed by
// more than the tolerance become due. Otherwise the blocks of lines around the texel become due.
void note_changes(ivec2 texel, vec4 time_before, vec4 held_before, vec4 time, vec4 held) {
    if (next_round == NO_ROUND) {
        ivec2 inner = without_border(texel);
        atomicMax(residual, change_of(time_before, time, held_before, held));
        make_both_due(DOWN, inner.y, pitch_of(texels));
        make_both_due(RIGHT, inner.x, pitch_of(texels));
        return;
    }
    for (int j = 0; j < 4; j++) {
        uint change = change_of(vec4(time_before[j]), vec4(time[j]), vec4(held_before[j]), vec4(held[j]));
        if (time_before[j] >= FAR && time[j] < FAR) atomicOr(reached, 1u);
        if (change <= tolerance) continue;
        if (next_round > 0) atomicMax(unsettled[next_round - 1], change);
        wake_tiles(first_point(texel) + to_corner(j), min(time_before[j], time[j]));
    }
}

#include "passes/exchange.glsl"

void main() {
    if (done != 0u || (next_round > 0 && rounds[ROUND_WORDS * (next_round - 1) + 3] == 0u)) return;
    causal = fronts_meet != 0u;
    holds = fronts_meet != FRONTS_ARE_ADDED;
    exchange_all();
}
