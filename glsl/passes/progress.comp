// Counts an iteration and decides whether another one follows. If so, the blocks past the middle of the grid
// that have waited for the end of the iteration become due; see blocks.glsl. A single invocation is dispatched.
// Twin: crates/cpu/src/progress.rs.

#include "passes/count.glsl"
#include "passes/blocks.glsl"

layout(local_size_x = 1) in;

layout(push_constant) uniform Halves {
    ivec2 middle; // first block of the last half of the rows, and of the columns
    int pitch;    // number of blocks stored for each scan; see pitch_of() in blocks.glsl
};

void main() {
    if (done != 0u) return;
    last_residual = residual;
    if (count_iteration(residual, tolerance, most, iterations, since_reached, renews)) {
        done = 1u;
        for (int i = 1; i < blocks.length(); i += 3) blocks[i] = 0u;
    } else if (PAIRS != 0) {
        for (int scan = 0; scan < 4; scan++) {
            int middle_block = scan < RIGHT ? middle.x : middle.y;
            uint marks = due_past_middle[scan];
            for (int number = 0; marks >> number != 0u; number++) {
                if ((marks >> number & 1u) == 0u) continue;
                make_due(scan, block_past(middle_block, number, (scan & 1) == 0), pitch);
            }
            due_past_middle[scan] = 0u;
        }
    }
    residual = 0u;
}
