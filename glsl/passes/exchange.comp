// Gives all copies of a point of a glued surface the earliest front among them. It runs after the seeds, each scan
// and each round of tiles.
// A single workgroup is dispatched; see exchange.glsl.
// Twin: crates/cpu/src/fronts/exchange.rs.

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

layout(local_size_x = EXCHANGE_WORKGROUP) in;

// The image bound as fronts_0 was written last. After a round of tiles some tiles have their fronts in fronts_1.
#include "passes/two_images.glsl"

const int NO_ROUND = -1;

// Returns whether the fronts of a texel lie in fronts_1.
bool is_in_1(ivec2 texel) {
    if (next_round == NO_ROUND) return false;
    ivec2 tile_grid = tiles_of(texels);
    return (tiles[row_major(tile_with(texel, tile_grid), tile_grid.x)] & 1u) != 0u;
}

void load(ivec2 texel, out vec4 time, out vec4 held) {
    load_fronts(is_in_1(texel), texel, time, held);
}

void store(ivec2 texel, vec4 time, vec4 held) {
    store_fronts(is_in_1(texel), texel, time, held);
}

bool renews_fronts() {
    return renews != 0u;
}

int slot_of(int part) {
    return part;
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
        // The tiles that see the point are on the list of the next round.
        const int REACH = max(SPLITS, 1);
        ivec2 point = first_point(texel) + to_corner(j);
        uint urgency = urgency_of(min(time_before[j], time[j]));
        enlist_around(texel_of(point - REACH), texel_of(point + REACH), urgency, uint(next_round), tiles_of(texels));
    }
}

#include "passes/exchange.glsl"

void main() {
    if (done != 0u || (next_round > 0 && rounds[ROUND_WORDS * (next_round - 1) + 3] == 0u)) return;
    causal = fronts_meet != 0u;
    holds = fronts_meet != FRONTS_ARE_ADDED;
    exchange_all();
}
