// The fans of a surface in the order in which scans pass them: what all maps share. A line of the
// grid is cut into pairs of points; a pair has a place for each of the four scans. Include after update.glsl.

// Numbers of a pair of points a and b: lengths of the edges to the neighbours behind, before,
// beside and after a, then b (6); of the three edges between those (3); for curved fronts also the
// Gaussian curvature of the surface at the four points behind and at a and b (6).
const int NUMBERS = WAVEFRONT >= 2 ? 15 : 9;

// Where the first number of a pair stands; the others follow at a distance of `pairs`.
int fan_place(ivec2 grid, int scan, int line, int pair, int pairs) {
    ivec2 of_rows = ivec2((grid.x + 1) / 2, grid.y); // pairs of a line, and lines
    ivec2 of_cols = ivec2((grid.y + 1) / 2, grid.x);
    int before = scan < 2 ? scan * of_rows.x * of_rows.y
                          : 2 * of_rows.x * of_rows.y + (scan - 2) * of_cols.x * of_cols.y;
    return (before + line * pairs) * NUMBERS + pair;
}
