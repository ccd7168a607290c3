// Scans blocks of lines of one map; see scan.glsl. A dispatch covers one block, or many in turn if a line
// fits into a workgroup. The opposite scan may be at work in the other half of the grid.
// Twins: crates/cpu/src/twins/scan.rs, and scan_in_pairs in crates/cpu/src/twins/blocks.rs.

#define WITH_ANCHORS
#include "update/wavefront.glsl"
#include "passes/blocks.glsl"

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

void note_moved(uint moved, uint further, ivec2 texel);

bool passes(ivec2 point, ivec2 ahead) {
    return true;
}

#include "passes/scan.glsl"

// Makes the blocks due that read the changed lines of a texel: in this scan and the opposite one the blocks before and
// after the lines, and in the two scans across these the block of the texel and the blocks beside it that read it. The
// opposite scan also has this block due, and this scan has it due again in the next iteration where `further` is set.
void note_moved(uint moved, uint further, ivec2 texel) {
    bool by_rows = AHEAD_Y != 0;
    int forth = by_rows ? DOWN : RIGHT;
    int way = AHEAD_X + AHEAD_Y;
    ivec2 inner = without_border(texel);
    int first_line = by_rows ? inner.y : inner.x;
    int block = first_line / LINES;
    int in_block = first_line - block * LINES;
    int middle_block = (middle - BORDER) / LINES;
    make_due(way > 0 ? forth + 1 : forth, block, pitch);
    for (int k = 0; k < LINES; k++) {
        if ((moved >> k & 1u) == 0u) continue;
        note_place(inner + k * ahead);
        make_seen_due(forth, block, in_block + k * way, int(SCAN) - 1, middle_block, pitch);
    }
    if (further != 0u) {
        atomicOr(blocks[due_at(int(SCAN) - 1, block, pitch)], due_again(iterations));
    }
    make_both_due(by_rows ? RIGHT : DOWN, by_rows ? inner.x : inner.y, pitch);
}

shared uint is_due;
// The range of places along the lines of this scan, as first and last texel, in which a front of any line has changed
// since the map began. It is known only on maps with a limit.
shared ivec2 changed_along;

// Returns whether no front that has changed since the map began can reach this workgroup's texels within this block.
// Changes that other workgroups make in this dispatch cannot reach these texels either. Such changes start from fronts
// that had changed before, and a change spreads along a line by at most REACH texels in a whole block.
bool lies_apart() {
    if (in_turn != 0 || limit >= NO_LIMIT) return false;
    if (gl_LocalInvocationID.x == 0u) {
        const int AXIS = AHEAD_Y != 0 ? 0 : 1;
        changed_along = ivec2(atomicOr(changed_first[AXIS], 0), atomicOr(changed_last[AXIS], 0));
    }
    barrier();
    const int REACH = LINES * max(SPLITS, 1);
    int own = without_border(first_of_workgroup() + HALO);
    int written = int(gl_WorkGroupSize.x) - 2 * HALO;
    return own > changed_along.y + REACH || own + written - 1 < changed_along.x - REACH;
}

void main() {
    // The second word of a block is both its mark as due and the number of rows of groups of its indirect dispatch. So
    // there can be several rows, of which only the first works. See blocks.glsl.
    if (group_number().y > 0u) return;
    causal = fronts_meet != 0u;
    holds = fronts_meet != FRONTS_ARE_ADDED;
    latest = limit;
    int way = AHEAD_X + AHEAD_Y;
    int passed_lines = 0;
    for (int number = 0; passed_lines < lines; number++) {
        block_line = line + passed_lines * way;
        int first_line = without_border(block_line);
        int in_block = first_line % LINES;
        block_lines = min(way > 0 ? LINES - in_block : in_block + 1, lines - passed_lines);
        passed_lines += block_lines;
        int at = due_at(int(SCAN) - 1, first_line / LINES, pitch);
        if (in_turn != 0) {
            // Makes visible what the previous block has written: the line behind this block, and which blocks
            // are due.
            memoryBarrierImage();
            memoryBarrierBuffer();
            barrier();
            if (gl_LocalInvocationID.x == 0u) is_due = atomicOr(blocks[at], 0u);
            barrier();
            if (is_due == 0u) continue;
        }
        // The mark that made the block due has been read. Only a mark for the next iteration is kept.
        if (gl_LocalInvocationID.x == 0u && group_number().x == 0u) {
            atomicAnd(blocks[at], due_again(iterations));
            int bit = note + number;
            if (note >= 0) visits[bit / 32] |= 1u << (bit & 31);
        }
        if (lies_apart()) return;
        if (gl_LocalInvocationID.x == 0u) atomicAdd(visited, 1u);
        scan_block();
    }
}
