// Finds the direction in which the way back leaves a grid point. Where squared times are smooth and the
// source is not near, it is the direction of their steepest descent; elsewhere it is the direction of the
// path's first line.
// Twin: crates/geometry/src/directions/ways.rs. Behind corners, the twin subtracts the arrival time at the corner
// before it squares times.

#include "passes/ways.glsl"
#include "shared/start.glsl"
// At a pole, columns and rows have no common plane. So a way that leaves from another copy would be of no use.
const bool PASSES_POLES = false;
#include "passes/path_line.glsl"
#include "passes/step_over_seams.glsl"
#include "update/reduced_basis.glsl"

// Largest change of second differences that counts as smooth, as a part of the squared length of a step.
const float SMOOTH = 0.5;
// Largest such change far from the source, as a part of the length of a step times the time since the start. A kink that
// is no larger turns the gradient by a hundredth of a radian at most.
const float SLIGHT = 0.08;
// Largest relative difference between the length of the gradient and the one that the eikonal equation
// demands.
const float OFF_LENGTH = 0.1;
// Least cosine of the angle between the gradient and the first line.
const float ALIKE_WAYS = 0.985;
// Nearer to the source than this, in cells, fronts of several sources can meet without a visible kink.
const float NEAR_SOURCE = 8.0;

float earliest_start() {
    return time_of(~ways[0]);
}

float latest_start() {
    return time_of(ways[1]);
}

// Returns the number of the source beside a point whose own front arrives there first, or -1 if there is no
// source beside the point.
int source_beside(ivec2 at) {
    uint number = in_grid(at, grid) ? ways[word_of(0, index_of(at))] : 0u;
    return number == 0u ? -1 : int(~number);
}

// Tries only the sources beside the corners of the cell (see source_beside()). No other source matters.
void find_source(Cell cell, vec4 weights, Path path, inout Line nearest) {
    int before = -1;
    for (int i = 0; i < 4; i++) {
        int number = source_beside(cell.first + to_corner(i));
        if (number >= 0 && number != before) try_source(number, cell, weights, path, nearest);
        before = number;
    }
}

// Returns a path that begins at a grid point. `start` is the time that is subtracted before times are
// squared.
Path path_from(ivec2 at, float start) {
    Path path;
    path.place = Place(at, vec2(0.0));
    path.base_time = time_at(at);
    path.below = 0.0;
    path.from = NO_CELL;
    path.zero_time = start;
    // With FAR, search_around() tries sources in every cell. A test by time would save nothing, since sources
    // are looked up by corners.
    path.latest = FAR;
    return path;
}

// Returns the squared time since the start at the point `at`, less the square at another point, whose arrival
// time is `time`, in squared units. The result is FAR if `at` is not reached.
float excess_at(ivec2 at, float time, vec2 start_and_unit) {
    // The grid may go on beyond its sides.
    if (SEAMS != 0) at = on_grid(at);
    float other = in_grid(at, grid) ? time_at(at) : FAR;
    if (!is_reached(other)) return FAR;
    float start = start_and_unit.x;
    return ((other - time) / start_and_unit.y) * (((other - start) + (time - start)) / start_and_unit.y);
}

// Computes the slope of the squared time along a grid line. Returns false where it is not smooth.
bool slope_along(ivec2 at, ivec2 along, float time, vec2 start_and_unit, float limit, out float slope) {
    float back = excess_at(at - along, time, start_and_unit);
    float ahead = excess_at(at + along, time, start_and_unit);
    slope = 0.0;
    if (back >= FAR || ahead >= FAR) return false;
    slope = 0.5 * (ahead - back);
    float bend = ahead + back;
    float far_back = excess_at(at - 2 * along, time, start_and_unit);
    float far_ahead = excess_at(at + 2 * along, time, start_and_unit);
    bool has_back = far_back < FAR;
    bool has_ahead = far_ahead < FAR;
    float bend_back = has_back ? far_back - 2.0 * back : bend;
    float bend_ahead = has_ahead ? far_ahead - 2.0 * ahead : bend;
    float low = min(bend, min(bend_back, bend_ahead));
    float high = max(bend, max(bend_back, bend_ahead));
    if (high - low <= limit) {
        if (has_back && has_ahead) slope = (8.0 * (ahead - back) - (far_ahead - far_back)) / 12.0;
        return has_back || has_ahead || low >= -limit;
    }
    // If a kink lies further away, the map is still smooth at the three points in the middle. The kink lowers
    // one of the other two second differences, so the one in the middle agrees with the larger of these.
    return has_back && has_ahead && abs(max(bend_back, bend_ahead) - bend) <= limit;
}

// Computes the direction of steepest descent at a point as a step of columns and rows. Returns false if the
// map is not smooth there.
bool descent(ivec2 at, float time, float start, Metric metric, float unit, out vec2 step) {
    step = vec2(0.0);
    float since = (time - start) / unit;
    if (!is_usable(metric) || since <= 0.0) return false;
    float noise = 16.0 * since * abs(time / unit) * ROUNDING;
    // In sheared cells, the nearest points lie along other steps than rows and columns.
    ivec2 a = ivec2(1, 0);
    ivec2 b = ivec2(0, 1);
    vec2 squares = vec2(metric.cc, metric.rr);
    float along = metric.cr;
    if (!reduce(a, b, squares, along)) return false;
    vec2 limits = max(SMOOTH * squares, SLIGHT * since * sqrt(squares)) + noise;
    vec2 slopes;
    if (!slope_along(at, a, time, vec2(start, unit), limits.x, slopes.x)
        || !slope_along(at, b, time, vec2(start, unit), limits.y, slopes.y)) {
        return false;
    }
    // The slopes are products with both steps. The determinant of the steps is 1 or -1.
    float turn = float(a.x * b.y - a.y * b.x);
    vec2 gradient = turn * vec2(float(b.y) * slopes.x - float(a.y) * slopes.y,
                                float(a.x) * slopes.y - float(b.x) * slopes.x);
    step = -raised(metric, gradient);
    float size = sqrt(max(product(metric, step, step), 0.0)) / (2.0 * since);
    return abs(size - 1.0) < OFF_LENGTH;
}

// Returns the step from a point to the earliest neighbour, or zero if all are later.
vec2 to_earliest(ivec2 at, float time) {
    vec2 step = vec2(0.0);
    Place own = Place(at, vec2(0.0));
    int copies = most_copies(own);
    for (int i = 0; i < copies; i++) {
        Place copy;
        if (!copy_at(own, i, copy)) continue;
        for (int j = 0; j < 8; j++) {
            float other = time_at(copy.first + NEIGHBOURS[j]);
            if (other < time && edge_length(point_at(copy.first), NEIGHBOURS[j]) < FAR) {
                time = other;
                step = step_at_copy(copy.first, at, vec2(NEIGHBOURS[j]));
            }
        }
    }
    return step;
}

// Returns the direction in which the way back leaves a point that is reached, as a step of columns and rows
// of unit length. It is zero at a source, and where no neighbour is earlier.
vec2 way_from(ivec2 at) {
    float time = time_at(at);
    float start = earliest_start();
    float unit = longest_edge(at);
    if (unit == 0.0) return vec2(0.0);
    Metric metric = metric_over_seams(at, unit);
    vec2 downhill = vec2(0.0);
    bool is_smooth = source_beside(at) < 0 && descent(at, time, start, metric, unit, downhill);
    if (is_smooth && (time - start) / unit > NEAR_SOURCE) return normalize(downhill);
    Line line = line_from(path_from(at, start));
    vec2 step;
    if (!line.exists) {
        step = to_earliest(at, time);
    } else {
        step = step_at_copy(line.start.first, at, position(line.end) - vec2(line.start.first));
        float both = product(metric, step, step) * product(metric, downhill, downhill);
        if (is_smooth && line.source < 0 && product(metric, step, downhill) > ALIKE_WAYS * sqrt(both)) {
            step = downhill;
        }
    }
    float size = length(step);
    return size > 0.0 ? step / size : vec2(0.0);
}
