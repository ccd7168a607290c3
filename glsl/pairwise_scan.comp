#version 450
#extension GL_GOOGLE_include_directive : require
// A block of lines of a scan of all maps of a batch that are not done; see scan.glsl. The third
// dimension of the dispatch is the map.

#include "constants.glsl"
#include "texel.glsl"
#include "update.glsl"
#include "front.glsl"
#include "pairwise_progress.glsl"
#include "pairwise_layers.glsl"

layout(local_size_x_id = 3) in;

ivec3 place_of(ivec2 texel, int layer) {
    return ivec3(texel, layer_of(gl_WorkGroupID.z, layer));
}

bool renews_fronts() {
    return maps[gl_WorkGroupID.z].renews != 0u;
}

void note_change(uint change) {
    atomicMax(maps[gl_WorkGroupID.z].residual, change);
}

#include "scan.glsl"

void main() {
    if (maps[gl_WorkGroupID.z].done == 0u) scan_block();
}
