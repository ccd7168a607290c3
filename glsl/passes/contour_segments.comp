// Writes the segments of contours, two vertices each. Nearer points lie to the left as seen in a picture. If
// the buffer is too small, the southernmost segments are left out. One workgroup is one row of cells. One
// invocation is one strip of cells in it.
// Twin: crates/geometry/src/contours.rs.

#include "passes/contours.glsl"
#include "shared/curve.glsl"
#include "shared/crossing.glsl"

layout(local_size_x = WORKGROUP) in;

// Returns the place at which a level crosses the edge between two corners. It is computed from the corner
// that comes first in the grid, so that all triangles of the edge agree on it.
vec2 place_between(ivec2 cell, int a, int b, float time) {
    ivec2 from = cell + to_corner(min(a, b));
    ivec2 step = to_corner(max(a, b)) - to_corner(min(a, b));
    return vec2(from) + crossing(from, step, time, start) * vec2(step);
}

void main() {
    int row = int(gl_WorkGroupID.y);
    ivec2 columns = strip_columns();
    uint next = counts[row_index(row)] + counts[strip_index(row, gl_LocalInvocationID.x)];
    uint room = uint(capacity) / 2u;
    Corners cell;
    for (int col = columns.x; col < columns.y; col++) {
        ivec2 first = ivec2(col, row);
        cell = corners_at(first, col > columns.x, cell);
        ivec2 range = triangles(cell);
        for (int i = range.x; i < range.y; i++) {
            ivec3 triangle = TRIANGLES[i];
            uvec2 through = levels_through(cell, triangle);
            for (uint index = through.x; index < through.y; index++, next++) {
                if (next >= room) return;
                float time = level(index);
                // The walk around the triangle leaves the nearer part on one edge and returns to it on
                // another.
                for (int k = 0; k < 3; k++) {
                    int a = triangle[k];
                    int b = triangle[(k + 1) % 3];
                    bool a_is_nearer = cell.passed[a] <= index;
                    if (a_is_nearer == (cell.passed[b] <= index)) continue;
                    int vertex = 2 * int(next) + (a_is_nearer ? 0 : 1);
                    vec2 place = place_between(first, a, b, time);
                    write_vertex(first_vertex + VERTEX_WORDS * vertex, place, time);
                }
            }
        }
    }
}
