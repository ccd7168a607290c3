// Finds the straight line on which the front arrives first at a place of a path. On a glued surface the line may
// begin at a copy of the place.
//
// The including shader defines find_source(), and the push constant `slowed`.
// Twin: crates/geometry/src/paths/search.rs.

#include "shared/cell.glsl"
#include "shared/source.glsl"
#include "passes/path_cell.glsl"
#include "passes/path_profile.glsl"
#include "passes/path_copies.glsl"

// Twice the distance from 1 to the next number.
const float ROUNDING = 2.4e-7;
// Triangles with a smaller squared sine of the angle at the nearer end of the side are too flat for single precision.
const float FLAT_TRIANGLE = 3e-7;

// A straight line of a path.
struct Line {
    bool exists;
    int source;   // source at its end; -1 if it ends elsewhere
    Place start;
    Place end;
    float time;   // time at its end, less the base_time of its step
    float size;
    ivec2 cell;
};

Line best;

// Returns the number of cells in which a place lies.
int cells_around(Place place) {
    return (place.share.x == 0.0 ? 2 : 1) * (place.share.y == 0.0 ? 2 : 1);
}

// Returns the offset of one of a place's cells from its south-eastern cell, in columns to the west and rows
// to the north.
ivec2 offset_of(Place place, int index) {
    if (place.share.x > 0.0) return ivec2(0, index);
    return to_corner(index);
}

vec4 weights_in(Place place, ivec2 cell) {
    return bilinear(place.share + vec2(place.first - cell));
}

// Computes the weights of a place inside a cell. Places on grid lines need only two of the corners and do not
// use this.
bool weights_inside(Place place, Cell cell, out vec4 weights) {
    return corner_weights(reached_corners(cell), place.share, weights);
}

// Returns whether the time falls along a line by at least LEAST_FALL of its length.
bool falls(Line line, Path path) {
    float slack = ROUNDING * abs(path.base_time + path.below);
    return path.below - line.time >= LEAST_FALL * line.size - slack;
}

// Replaces the best line by another one that is better and ends lower than the place of the path. A line that
// falls is better than one that does not. Among equals, the one on which the front arrives first is better.
void offer(Place end, float time, float size, Path path, ivec2 cell) {
    Line line = Line(true, -1, path.place, end, time, size, cell);
    bool is_better = !best.exists || time + size < best.time + best.size;
    if (best.exists && falls(line, path) != falls(best, path)) is_better = falls(line, path);
    if (is_better && time < path.below) best = line;
}

// Returns the lengths of the edges before and behind the edge from a point along a step, as parts of its own length.
// Lengths that are weighted by a slowness do not tell how far apart points are; these edges count as equally long.
vec2 ratios_along(ivec2 point, ivec2 step, float own) {
    if (slowed != 0) return vec2(1.0);
    return vec2(edge_length(point_at(point - step), step), edge_length(point_at(point + step), step)) / own;
}

// Looks for a better line through a cell.
void cross_cell(Cell cell, vec4 weights, Path path) {
    float base_time = path.base_time;
    vec4 squares = squares_from(cell, weights);
    bvec4 reached = reached_corners(cell);
    int support = 0;
    for (int i = 0; i < 4; i++) support += weights[i] > 0.0 ? 1 : 0;
    for (int side = 0; side < 4; side++) {
        int a = SIDES[side].x;
        int b = SIDES[side].y;
        // Skips the edge on which the place lies, and edges that end at the place.
        float own = weights[a] + weights[b];
        if (support == 1 ? own > 0.0 : support == 2 && own > 0.9999999) continue;
        ivec2 point = cell.first + to_corner(a);
        ivec2 step = to_corner(b) - to_corner(a);
        vec2 ends = vec2(squares[a], squares[b]);
        float base = cell.squares[a][b];
        float nearer = min(ends.x, ends.y);
        float skew = max(ends.x, ends.y) - nearer - base;
        float whole = 4.0 * nearer * base;
        bool is_flat = whole - skew * skew <= FLAT_TRIANGLE * whole;
        // The start lies on the side as far as single precision can tell.
        bool is_beside = is_flat && support > 2 && base > 0.0;
        if (reached[a] && reached[b] && max(ends.x, ends.y) < 0.5 * NO_EDGE
            && (is_beside || !is_flat)) {
            vec4 times = vec4(time_at(point - step), cell.times[a], cell.times[b],
                              time_at(point + 2 * step));
            vec2 ratios = ratios_along(point, step, cell.unit * sqrt(base));
            Profile profile = profile_of(times, ratios, path.zero_time, cell.unit, base);
            float foot = clamp(0.5 + 0.5 * (ends.x - ends.y) / base, 0.0, 1.0);
            Crossing found = is_beside ? crossing_at(profile, ends, base, foot)
                                       : crossing(profile, ends, base);
            int end = found.share > 0.5 ? b : a;
            float away = found.share > 0.5 ? 1.0 - found.share : found.share;
            // A line that passes a point closely ends there, unless the point is reached later than the start
            // of the line, or lies aside from the way of a line that is short itself.
            Place corner = Place(cell.first + to_corner(end), vec2(0.0));
            Line moved = Line(true, -1, path.place, corner, cell.times[end] - base_time,
                                  cell.unit * sqrt(max(squares[end], 0.0)), cell.first);
            bool leads_on = moved.time < path.below && falls(moved, path);
            if (away == 0.0 || (away < AT_POINT && leads_on)) {
                offer(corner, moved.time, moved.size, path, cell.first);
            } else {
                float time = cell.times[a] - base_time + cell.unit * found.time;
                Place there = Place(point, found.share * vec2(step));
                offer(there, time, cell.unit * found.distance, path, cell.first);
            }
            continue;
        }
        // Without a triangle, paths run along edges.
        for (int k = 0; k < 2; k++) {
            int end = SIDES[side][k];
            bool along = support == 1 || weights[end] > 0.0 || support > 2;
            if (reached[end] && along && squares[end] < 0.5 * NO_EDGE) {
                Place there = Place(cell.first + to_corner(end), vec2(0.0));
                float size = cell.unit * sqrt(max(squares[end], 0.0));
                offer(there, cell.times[end] - base_time, size, path, cell.first);
            }
        }
    }
}

// Replaces the nearest source by another one if that other source lies in the cell, at `uv`, and its front arrives
// earlier over a straight line at the place of a path in the cell.
void try_source_at(vec2 uv, int number, float initial, Cell cell, vec4 weights, Path path, inout Line nearest) {
    bool inside = all(greaterThanEqual(uv, vec2(0.0))) && all(lessThanEqual(uv, vec2(1.0)));
    vec4 there;
    if (!inside || !corner_weights(reached_corners(cell), uv, there)) return;
    float time = initial - path.base_time;
    float size = cell.unit * distance_of(cell, weights, there);
    if (!nearest.exists || time + size < nearest.time + nearest.size) {
        nearest = Line(true, number, path.place, Place(cell.first, uv), time, size, ivec2(-2));
    }
}

// Returns a corner of a cell that is a copy of a point, or -1.
int corner_that_is(ivec2 at, Cell cell) {
    int first = first_copy(at);
    for (int i = 0; i < 4; i++) {
        ivec2 corner = cell.first + to_corner(i);
        if (in_grid(corner, grid) && first_copy(corner) == first) return i;
    }
    return -1;
}

// Tries a source, or the copy of it that lies in the cell, as try_source_at() does.
void try_source(int number, Cell cell, vec4 weights, Path path, inout Line nearest) {
    Source other = source(number);
    if (!counts(other)) return;
    Place own = as_one_point(place_from(place_of(other)));
    ivec2 members = copies_of(own.first);
    if (is_point(own) && members.x < members.y) {
        int corner = corner_that_is(own.first, cell);
        if (corner >= 0) try_source_at(vec2(to_corner(corner)), number, other.time, cell, weights, path, nearest);
        return;
    }
    int copies = most_copies(own);
    for (int i = 0; i < copies; i++) {
        Place copy;
        if (!copy_at(own, i, copy)) continue;
        try_source_at(position(copy) - vec2(cell.first), number, other.time, cell, weights, path, nearest);
    }
}

// Finds the source in a cell from which the front arrives first at the place of a path in the cell, over a straight
// line.
void find_source(Cell cell, vec4 weights, Path path, inout Line nearest);

// Looks for a better line, and for a nearer source, in the cells around the place of a path. The search begins with a
// cell from which the path does not come.
void search_around(Path path, inout Line nearest) {
    Place place = path.place;
    int cells = cells_around(place);
    int first = place.first - offset_of(place, 0) == path.from ? 1 : 0;
    bool is_known = path.below < UNKNOWN;
    for (int i = 0; i < cells; i++) {
        Cell cell = cell_at(place.first - offset_of(place, (first + i) % cells));
        if (cell.unit == 0.0) continue;
        vec4 weights = weights_in(place, cell.first);
        if (cells == 1) weights_inside(place, cell, weights);
        cross_cell(cell, weights, path);
        // A source in the cell is near, and so its time is not much earlier.
        if (!is_known || path.base_time + path.below - path.latest <= 4.0 * cell.unit) {
            find_source(cell, weights, path, nearest);
        }
        bool fits =
            best.exists && is_known && best.time + best.size <= path.below + FITS * best.size;
        if (cells == 2 && fits && !nearest.exists) break;
    }
}

// Returns the straight line across a cell on which the front arrives first, among those that begin at the place of the
// path or a copy of it and end lower.
Line line_from(Path path) {
    best.exists = false;
    Line nearest;
    nearest.exists = false;
    Place own = path.place;
    int copies = most_copies(own);
    for (int i = 0; i < copies; i++) {
        if (copy_at(own, i, path.place)) search_around(path, nearest);
    }
    bool in_sight = nearest.exists
        && (best.exists ? nearest.time + (1.0 - FITS) * nearest.size <= best.time + best.size
                        : nearest.time <= path.below);
    return in_sight ? nearest : best;
}
