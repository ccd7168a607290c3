// Counts an iteration of all maps of a batch that are not done, and decides which of them need another one.
// One invocation is one map.
// Twin: crates/cpu/src/progress.rs.

#include "passes/pairwise_progress.glsl"
#include "passes/count.glsl"

layout(local_size_x = WORKGROUP) in;

layout(push_constant) uniform Batch {
    uint count; // number of maps
};

void main() {
    uint map = gl_GlobalInvocationID.x;
    if (map >= count || maps[map].done != 0u) return;
    uint residual = maps[map].residual;
    maps[map].last_residual = residual;
    if (count_iteration(residual, tolerance, most, maps[map].iterations, maps[map].since_reached,
                 maps[map].renews)) {
        maps[map].done = 1u;
        bool was_last_map = atomicAdd(pending, ~0u) == 1u;
        if (was_last_map) {
            row_groups[0] = 0u;
            col_groups[0] = 0u;
        }
    }
    maps[map].residual = 0u;
}
