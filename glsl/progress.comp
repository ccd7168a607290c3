#version 450
#extension GL_GOOGLE_include_directive : require
// Counts an iteration and decides whether another one follows. One invocation is all.
// Twin: src/cpu/progress.rs.

#include "constants.glsl"
#include "progress.glsl"

layout(local_size_x = 1) in;

void main() {
    if (done != 0u) return;
    iterations += 1u;
    last_residual = residual;
    since_reached = residual > FIRST_REACHED ? 0u : since_reached + 1u;
    if (since_reached >= PATIENCE) renews = 0u;
    if (residual <= tolerance || iterations >= most) {
        done = 1u;
        row_groups[0] = 0u;
        col_groups[0] = 0u;
        grid_groups[0] = 0u;
    }
    residual = 0u;
}
