// Computes the number of segments in all rows before each row of cells, and writes the record that a draw of
// all segments reads. A single workgroup is dispatched. One invocation takes some consecutive rows.
// Twin: crates/geometry/src/contours.rs.

#include "passes/contours.glsl"
#include "shared/curve.glsl"

layout(local_size_x = WORKGROUP) in;

#include "shared/prefix.glsl"

void main() {
    int rows = cells_of(grid).y;
    int some = (rows + WORKGROUP - 1) / WORKGROUP;
    int first = int(gl_LocalInvocationID.x) * some;
    int last = min(first + some, rows);
    uint own = 0u;
    for (int row = first; row < last; row++) {
        own = min(own + counts[row_index(row)], MOST);
    }
    uint sum = sum_up_to_here(own);
    uint before = sum - own;
    for (int row = first; row < last; row++) {
        uint segments = counts[row_index(row)];
        counts[row_index(row)] = before;
        before = min(before + segments, MOST);
    }
    if (gl_LocalInvocationID.x == WORKGROUP - 1) {
        uint needed = 2u * sum;
        uint drawn = min(needed, uint(capacity));
        write_record(0, drawn, 0u, needed, needed > drawn ? OUT_OF_ROOM : COMPLETE);
        // These words have a meaning for paths only.
        for (int word = 6; word < CURVE_WORDS; word++) curves[word] = 0u;
    }
}
