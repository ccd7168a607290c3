// Defines where the numbers of each pair of points lie in the buffer of fans, in the order in which scans visit
// pairs. The fan of a pair is all that an update of its two points reads from the surface: lengths of edges, and
// surface values. It is the same for all maps. A line of the grid is split into pairs of points, and a pair has a
// place for each of the four scans.

#include "update/wavefront.glsl"

// Count of numbers stored for a pair of points a and b. They are the lengths of the edges to the three
// neighbours behind a (before, beside and after it) and behind b (6), and the lengths of the three edges
// between those neighbours (3). For fronts that carry something, the surface values at the four points behind
// and at a and b follow (6).
const int NUMBERS = CARRIES ? 15 : 9;

// Returns the index of the first number of a pair. The others follow at a distance of `pairs`.
int fan_place(ivec2 grid, int scan, int line, int pair, int pairs) {
    int of_rows = pairs_of(grid.x) * grid.y;
    int of_cols = pairs_of(grid.y) * grid.x;
    int before = scan < 2 ? scan * of_rows : 2 * of_rows + (scan - 2) * of_cols;
    return (before + line * pairs) * NUMBERS + pair;
}
