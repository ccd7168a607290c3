// Blocks of LINES rows of texels (scans down and up) or columns (right and left), counted from the
// grid's first, and which of them are due in each scan: those in which, or on the line behind which,
// a texel has changed since the scan has last visited the block. To visit any other would change
// nothing: what a scan brings to a block depends on that line and the block alone, and it has brought
// it.
// But with anchors a scan looks at corners further behind as well, and in obtuse triangles at points beyond them;
// and at some of those in the block as they were before. So if one of these has changed the block is due again in the
// next iteration.
// Skipped blocks leave both images of fronts as they are, which are alike there: a scan that changes a
// texel writes one image, the next scan reads that image and writes the other, and the texel's block
// is due in it. So after each scan the image it writes holds the whole map.
// Include after progress.glsl. Twin: src/cpu/twins/scan_due.rs.

// Most lines of texels in a block.
layout(constant_id = 4) const int LINES = 1;

layout(set = 2, binding = 2) restrict buffer Blocks {
    // For each scan, in the order of an iteration, and each block what its dispatch reads: groups of
    // a line, 1 if the block is due or 0, and 1. A block that is due again has 2 or 4 in place of that
    // 1, or their sum: the groups that this makes too many do nothing. A scan has a block more on each
    // side of the grid, so that nothing has to ask whether there is one ahead.
    uint blocks[];
};

const int DOWN = 0;
const int UP = 1;
const int RIGHT = 2;
const int LEFT = 3;

// Blocks of a scan, in a grid with so many columns and rows of texels.
int pitch_of(ivec2 texels) {
    return (max(texels.x, texels.y) + LINES - 1) / LINES + 2;
}

int due_at(int scan, int block, int pitch) {
    return 3 * (scan * pitch + 1 + block) + 1;
}

void make_due(int scan, int block, int pitch) {
    atomicOr(blocks[due_at(scan, block, pitch)], 1u);
}

// What makes a block due again in the iteration after this one: 2 or 4 in turns, so that what this one was
// made by can be taken away while others write.
uint due_again(uint iteration) {
    return 2u << (iteration & 1u);
}

// A line of a block has changed: makes the blocks due that see it behind them in two opposite scans, `forth` and
// back: points see so many lines of texels behind them.
void make_seen_due(int forth, int block, int in_block, int pitch) {
    const int REACH = (SPLIT_REACH + 1) / 2;
    // There is one block on each side of the grid.
    int after = LINES - 1 - in_block;
    for (int next = block + 1; after < REACH && next < pitch - 1; next++) {
        make_due(forth, next, pitch);
        after += LINES;
    }
    for (int next = block - 1; in_block < REACH && next >= -1; next--) {
        make_due(forth + 1, next, pitch);
        in_block += LINES;
    }
}

// A line has changed: makes its block due in both scans that pass lines like it, and those that see it.
void make_both_due(int forth, int line, int pitch) {
    int block = line / LINES;
    make_due(forth, block, pitch);
    make_due(forth + 1, block, pitch);
    make_seen_due(forth, block, line - block * LINES, pitch);
}
