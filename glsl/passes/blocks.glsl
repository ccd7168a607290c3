// Tracks which blocks are due in each scan. In scans down and up a block consists of LINES rows of texels, in scans
// right and left of LINES columns, counted from the first of the grid. It is due if a texel in it, or on the line
// behind it, has changed since the scan last visited the block. A visit to any other block would change nothing, since
// the fronts that a scan computes in a block depend on the block and the line behind it alone.
//
// With anchors, a scan also reads corners further behind, and for obtuse triangles points beyond their bases. Some of
// these points lie in the block itself, and are read before the scan updates them. If the scan then changes one of
// them, the block is due again in the next iteration.
//
// Two opposite scans may run at the same time, each in a half of the grid. In the first phase they move from the
// ends to the middle, and in the second one from the middle to the other ends. Neither sees the changes that the
// other makes in the same phase. So if a scan changes a line next to the middle in the second phase, the blocks
// across the middle that read this line are due in the next iteration. The marks of such blocks have words of their own
// (`due_past_middle`). A mark in a block's own word would race with the block's dispatch in the same phase, which might
// or might not read the mark. No other mark concerns a block that the opposite scan visits in the same phase.
//
// Where a scan skips a block, both images of fronts stay as they are, and are equal there. Where a scan changes a
// texel, the scan writes one image. The next scan reads that image and writes the other one, and the texel's block is
// due in the next scan. So after each scan, the image that it has written holds the whole map. Phases of pairs behave
// in the same way: in the next phase the opposite scan, or a scan of the next pair, visits the texel.
// Twin: crates/cpu/src/twins/blocks.rs.

#include "shared/progress.glsl"
#include "update/reach.glsl"

// Largest number of lines of texels in a block.
layout(constant_id = 4) const int LINES = 1;
// Whether opposite scans run in pairs.
layout(constant_id = 15) const int PAIRS = 0;

layout(set = 2, binding = 2) restrict buffer Blocks {
    // Three words for each block of each scan, in the order of an iteration. They are the group counts of the
    // block's indirect dispatch: the groups of a line; 1 if the block is due, else 0; and 1. A block that is due
    // again in the next iteration has the mark 2 or 4 added to its second word (see due_again()). Workgroups
    // beyond the first row of groups do nothing. Each scan has one more block on each side of the grid, so that no
    // access needs a bounds test.
    uint blocks[];
};

const int DOWN = 0;
const int UP = 1;
const int RIGHT = 2;
const int LEFT = 3;

// Returns the number of blocks of a scan on a grid of this size in texels.
int pitch_of(ivec2 texels) {
    return (max(texels.x, texels.y) + LINES - 1) / LINES + 2;
}

// Returns the index of the word that says whether a block is due in a scan.
int due_at(int scan, int block, int pitch) {
    return 3 * (scan * pitch + 1 + block) + 1;
}

void make_due(int scan, int block, int pitch) {
    atomicOr(blocks[due_at(scan, block, pitch)], 1u);
}

// Returns the mark that makes a block due again in the iteration after this one. It alternates between 2 and
// 4, so that the mark of this iteration can be cleared while others set the next one.
uint due_again(uint iteration) {
    return 2u << (iteration & 1u);
}

// Stands for the scan that has changed a line if it is neither of the two opposite scans.
const int NO_SCAN = -1;

// Returns the block of a scan that is `number` blocks ahead of the middle. `middle` is the first block of the last
// half. `is_forth` is true for scans down and right, false for scans up and left.
int block_past(int middle, int number, bool is_forth) {
    return is_forth ? middle + number : middle - 1 - number;
}

// Makes the blocks due that read a changed line: in the scan `forth` (DOWN or RIGHT) the blocks after the line, and in
// the opposite scan the blocks before it. The line has the number `in_block` in `block`. Updates read REACH lines of
// texels behind a point. `by` is the scan that has changed the line, or NO_SCAN. With PAIRS, `middle` is the first
// block of the last half.
void make_seen_due(int forth, int block, int in_block, int by, int middle, int pitch) {
    const int REACH = (max(SPLITS, SPLIT_REACH) + 1) / 2;
    // There is one more block on each side of the grid.
    int after = LINES - 1 - in_block;
    for (int next = block + 1; after < REACH && next < pitch - 1; next++) {
        if (PAIRS != 0 && by == forth + 1 && block < middle && next >= middle) {
            atomicOr(due_past_middle[forth], 1u << (next - middle));
        } else {
            make_due(forth, next, pitch);
        }
        after += LINES;
    }
    for (int next = block - 1; in_block < REACH && next >= -1; next--) {
        if (PAIRS != 0 && by == forth && block >= middle && next < middle) {
            atomicOr(due_past_middle[forth + 1], 1u << (middle - 1 - next));
        } else {
            make_due(forth + 1, next, pitch);
        }
        in_block += LINES;
    }
}

// Makes the block of a changed line due in the scan `forth` and in the opposite one, as well as the blocks that read
// the line.
void make_both_due(int forth, int line, int pitch) {
    int block = line / LINES;
    make_due(forth, block, pitch);
    make_due(forth + 1, block, pitch);
    make_seen_due(forth, block, line - block * LINES, NO_SCAN, 0, pitch);
}
