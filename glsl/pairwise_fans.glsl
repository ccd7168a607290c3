// The fans of a surface in the order in which scans pass them: what all maps share. A line of the
// grid is cut into pairs of points; a pair has a place for each of the four scans. Include after
// wavefront.glsl and chart.glsl.

// Numbers of a pair of points a and b: lengths of the edges to the neighbours behind, before,
// beside and after a, then b (6); of the three edges between those (3); for fronts that carry something also
// what the surface brings at the four points behind and at a and b (6).
const int NUMBERS = CARRIES ? 15 : 9;

// Where the first number of a pair stands; the others follow at a distance of `pairs`.
int fan_place(ivec2 grid, int scan, int line, int pair, int pairs) {
    int of_rows = pairs_of(grid.x) * grid.y;
    int of_cols = pairs_of(grid.y) * grid.x;
    int before = scan < 2 ? scan * of_rows : 2 * of_rows + (scan - 2) * of_cols;
    return (before + line * pairs) * NUMBERS + pair;
}
