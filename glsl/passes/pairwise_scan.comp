// Scans a block of lines on all maps of a batch that are not done; see scan.glsl. The third dimension of the
// dispatch is the map. In the first iteration of a map, each scan visits only the lines ahead of the map's source.
// Twin: scan_outward in crates/cpu/src/twins/scan.rs.

#include "passes/pairwise_progress.glsl"
#include "passes/pairwise_layers.glsl"
#include "shared/groups.glsl"

layout(local_size_x_id = 3) in;

// Largest number of lines of texels in a block.
layout(constant_id = 4) const int LINES = 1;
// Opposite scans do not go in pairs.
const int PAIRS = 0;

ivec3 place_of(ivec2 texel, int layer) {
    return ivec3(texel, layer_of(group_number().z, layer));
}

bool renews_fronts() {
    return maps[group_number().z].renews != 0u;
}

void note_change(uint change) {
    atomicMax(maps[group_number().z].residual, change);
}

void note_moved(uint moved, uint further, ivec2 texel) {}

bool passes(ivec2 point, ivec2 ahead) {
    if (maps[group_number().z].iterations > 0u) return true;
    return lines_ahead(point - point_at(source_of(group_number().z)), ahead) > 0;
}

#include "passes/scan.glsl"

void main() {
    block_line = line;
    block_lines = lines;
    // Updates must be causal where fronts may meet themselves, as over a varying slowness, and where fronts
    // come through parts of obtuse triangles.
    causal = SLOWED != 0 || SPLITS != 0;
    if (maps[group_number().z].done == 0u) scan_block();
}
