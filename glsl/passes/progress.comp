#version 450
#extension GL_GOOGLE_include_directive : require
// Counts an iteration and decides whether another one follows. A single invocation is dispatched.
// Twin: src/cpu/progress.rs.

#include "shared/constants.glsl"
#include "shared/progress.glsl"
#include "passes/count.glsl"
#include "passes/blocks.glsl"

layout(local_size_x = 1) in;

void main() {
    if (done != 0u) return;
    last_residual = residual;
    if (was_last(residual, tolerance, most, iterations, since_reached, renews)) {
        done = 1u;
        grid_groups[0] = 0u;
        for (int i = 1; i < blocks.length(); i += 3) blocks[i] = 0u;
    }
    residual = 0u;
}
