// Counts the segments of contours in each row of cells, and within a row the segments before each strip. One
// workgroup is one row of cells. One invocation is one strip of cells in it.
// Twin: crates/geometry/src/contours.rs.

#include "passes/contours.glsl"

layout(local_size_x = WORKGROUP) in;

#include "shared/prefix.glsl"

void main() {
    int row = int(gl_WorkGroupID.y);
    ivec2 columns = strip_columns();
    uint own = 0u;
    Corners cell;
    for (int col = columns.x; col < columns.y; col++) {
        cell = corners_at(ivec2(col, row), col > columns.x, cell);
        ivec2 range = triangles(cell);
        for (int i = range.x; i < range.y; i++) {
            uvec2 through = levels_through(cell, TRIANGLES[i]);
            own += through.y - through.x;
        }
    }
    uint sum = sum_up_to_here(own);
    counts[strip_index(row, gl_LocalInvocationID.x)] = sum - own;
    if (gl_LocalInvocationID.x == WORKGROUP - 1) counts[row_index(row)] = sum;
}
