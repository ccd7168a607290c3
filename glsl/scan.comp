#version 450
#extension GL_GOOGLE_include_directive : require
// A block of lines of a scan of one map; see scan.glsl.

#include "constants.glsl"
#include "texel.glsl"
#include "update.glsl"
#include "front.glsl"
#include "progress.glsl"

layout(local_size_x_id = 3) in;

ivec3 place_of(ivec2 texel, int layer) {
    return ivec3(texel, layer);
}

bool renews_fronts() {
    return renews != 0u;
}

void note_change(uint change) {
    atomicMax(residual, change);
}

bool passes(ivec2 point, ivec2 ahead) {
    return true;
}

#include "scan.glsl"

void main() {
    scan_block();
}
