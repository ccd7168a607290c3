// Adds fronts at the points around a source inside a skewed cell or over a slowness, for surroundings.comp. Between the
// corners of such a cell, rays cross bases whose ends no ray has reached yet. The points around the cell, as far away as
// those that split obtuse triangles, are close enough to the source for straight lines of the chart. The length of any
// line is an upper bound of the distance, so no front is early.
// Twin: crates/cpu/src/twins/chart_lines.rs.

#include "shared/cell.glsl"
#include "update/reduced_basis.glsl"

// Distance of the farthest point that splits a triangle of the points around the source's cell.
shared int skew_around;

float window_length(ivec2 at, ivec2 step) {
    bool here = stored_here(step);
    return stored_length(lengths[spot(here ? at : at + step)], here ? step : -step);
}

float window_square(ivec2 at, ivec2 step) {
    float size = window_length(at, step);
    if (size >= sqrt(FAR)) return FAR;
    if (SLOWED != 0) size /= 0.5 * (slowness[spot(at)] + slowness[spot(at + step)]);
    return size * size;
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

// Returns the slowness at a place of the cell with a given north-western corner, 1 without a slowness.
float slowness_in_cell(ivec2 at, vec2 place) {
    if (SLOWED == 0) return 1.0;
    ivec4 s = spots(at);
    return dot(bilinear(place - vec2(at)), vec4(slowness[s.x], slowness[s.y], slowness[s.z], slowness[s.w]));
}

// Returns the length on the surface of a step inside the cell with a given north-western corner, or FAR if the cell is not
// whole.
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
// Over a slowness, its part in a cell costs its length times the mean slowness of its ends, as in the updates.
float length_of_line(vec2 place, ivec2 point) {
    vec2 whole = vec2(point) - place;
    // The next column and row that the line meets.
    vec2 line = mix(floor(place) + 1.0, ceil(place) - 1.0, lessThan(whole, vec2(0.0)));
    float sum = 0.0;
    float from = 0.0;
    for (int i = 0; i < 2 * TEXELS + 2 && from < 1.0; i++) {
        vec2 meets = mix(min((line - place) / whole, 1.0), vec2(1.0), equal(whole, vec2(0.0)));
        float to = min(meets.x, meets.y);
        vec2 middle = place + 0.5 * (from + to) * whole;
        // A line along the last row or column of the window lies in the cells before it.
        ivec2 cell = min(ivec2(middle), ivec2(SIDE - 2));
        float slow = slowness_in_cell(cell, place + from * whole) + slowness_in_cell(cell, place + to * whole);
        sum += 0.5 * slow * length_in_cell(cell, (to - from) * whole);
        if (sum >= FAR) return FAR;
        line += mix(vec2(0.0), sign(whole), lessThanEqual(meets, vec2(to)));
        from = to;
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
