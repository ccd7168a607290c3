// Adds fronts at the points around a source inside a skewed cell, for surroundings.comp. Between the corners of such a
// cell, rays cross bases whose ends no ray has reached yet. The points around the cell, as far away as those that split
// obtuse triangles, are close enough to the source for straight lines of the chart. The length of any line is an upper
// bound of the distance, so no front is early.
// Twin: crates/cpu/src/twins/chart_lines.rs.

#include "update/reduced_basis.glsl"

// Number of pieces of a line per row or column, whose lengths are added up.
const float PIECES = 4.0;

// Distance of the farthest point that splits a triangle of the points around the source's cell.
shared int skew_around;

float window_length(ivec2 at, ivec2 step) {
    bool here = stored_here(step);
    return stored_length(lengths[spot(here ? at : at + step)], here ? step : -step);
}

float window_square(ivec2 at, ivec2 step) {
    float size = window_length(at, step);
    return size < sqrt(FAR) ? size * size : FAR;
}

// Finds how skewed the cells around the cell of a source are. `place` is the source, in columns and rows of the window.
// Invocations of the whole workgroup call this, and a barrier must follow.
void find_skew(int index, vec2 place) {
    // The corners of the cell and the points beside them, and four of the triangles of each.
    ivec2 at = ivec2(place) - 1 + from_row_major(index / 4, 4);
    ivec2 a = NEIGHBOURS[index % 4];
    ivec2 b = NEIGHBOURS[index % 4 + 1];
    if (index >= 64 || !in_grid(at - 1, ivec2(SIDE - 2))) return;
    vec3 squares = vec3(window_square(at, a), window_square(at, b), window_square(at + a, b - a));
    atomicMax(skew_around, splits_within(a, b, squares));
}

// Returns the length of a step inside the cell with a given north-western corner, or FAR if the cell is not whole.
float length_in_cell(ivec2 at, vec2 step) {
    float north = window_square(at, ivec2(1, 0));
    float south = window_square(at + ivec2(0, 1), ivec2(1, 0));
    float west = window_square(at, ivec2(0, 1));
    float east = window_square(at + ivec2(1, 0), ivec2(0, 1));
    float falling = window_square(at, ivec2(1, 1));
    float rising = window_square(at + ivec2(0, 1), ivec2(1, -1));
    if (max(max(max(north, south), max(west, east)), max(falling, rising)) >= FAR) return FAR;
    float along_cols = 0.5 * (north + south) * step.x * step.x;
    float along_rows = 0.5 * (west + east) * step.y * step.y;
    return sqrt(max(along_cols + along_rows + 0.5 * (falling - rising) * step.x * step.y, 0.0));
}

// Returns the length of the straight line of the chart from a place to a point, or FAR if a point is missing beside it.
float length_of_line(vec2 place, ivec2 point) {
    vec2 whole = vec2(point) - place;
    float pieces = ceil(max(abs(whole.x), abs(whole.y)) * PIECES);
    float sum = 0.0;
    for (float piece = 0.5; piece < pieces; piece += 1.0) {
        vec2 middle = place + piece / pieces * whole;
        // A line along the last row or column of the window lies in the cells before it.
        ivec2 cell = min(ivec2(middle), ivec2(SIDE - 2));
        sum += length_in_cell(cell, whole / pieces);
        if (sum >= FAR) return FAR;
    }
    return sum;
}

// Adds the fronts along lines from a source to the fronts at the points of the texel whose first point is at `at`.
void add_lines(Source own, vec2 place, ivec2 at, inout vec4 time, inout vec4 held) {
    for (int j = 0; j < 4; j++) {
        ivec2 point = at + to_corner(j);
        vec2 beyond = max(floor(place) - vec2(point), vec2(point) - ceil(place));
        if (max(beyond.x, beyond.y) > float(skew_around)) continue;
        float away = length_of_line(place, point);
        if (away >= FAR || own.time + away >= time[j]) continue;
        time[j] = own.time + away;
        held[j] = with_tag(1.0 / away, SOURCE_TAG);
    }
}
