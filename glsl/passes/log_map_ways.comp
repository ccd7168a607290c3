// Begins a log map: computes the direction of the way back from each grid point. For points near a source it
// also follows the way to the source, and computes the direction in which the shortest path leaves the
// source. One invocation is one point.
// Twin: crates/geometry/src/directions/departures.rs computes the same from maps of sources that move.

layout(local_size_x = WORKGROUP) in;

#define OPEN_ONLY
#include "passes/way.glsl"
#include "passes/log_map.glsl"

// Returns the metric at a place between grid points: the mean over the points around it that have a usable
// one.
Metric metric_between(vec2 place, float unit) {
    place = back_on_grid(place, grid);
    ivec2 first = ivec2(place);
    vec4 weights = bilinear(place - vec2(first));
    Metric sum = Metric(0.0, 0.0, 0.0);
    float all = 0.0;
    for (int i = 0; i < 4; i++) {
        if (weights[i] == 0.0) continue;
        Metric of_point = metric_of_point(first + to_corner(i), unit);
        if (!is_usable(of_point)) continue;
        sum.cc += weights[i] * of_point.cc;
        sum.rr += weights[i] * of_point.rr;
        sum.cr += weights[i] * of_point.cr;
        all += weights[i];
    }
    return all > 0.0 ? Metric(sum.cc / all, sum.rr / all, sum.cr / all) : sum;
}

Metric difference(Metric a, Metric b) {
    return Metric(a.cc - b.cc, a.rr - b.rr, a.cr - b.cr);
}

// Returns the direction in which the shortest path to a place near a source leaves the source, in the
// source's basis: u along the columns, v at a right angle to it, on the side of larger rows. The shortest
// path bends in the grid as the metric changes. If d is the step from the source to the place, the path
// leaves along d + Christoffel(d, d) / 2, to the second order.
vec2 departure(vec2 from, vec2 place, float unit) {
    vec2 d = place - from;
    Metric metric = metric_between(from, unit);
    if (!is_usable(metric)) return normalize(d);
    const vec2 HALF = vec2(0.5, 0.0);
    Metric by_col = difference(metric_between(from + HALF.xy, unit), metric_between(from - HALF.xy, unit));
    Metric by_row = difference(metric_between(from + HALF.yx, unit), metric_between(from - HALF.yx, unit));
    Metric along = Metric(d.x * by_col.cc + d.y * by_row.cc, d.x * by_col.rr + d.y * by_row.rr,
                          d.x * by_col.cr + d.y * by_row.cr);
    vec2 lower = vec2(along.cc * d.x + along.cr * d.y, along.cr * d.x + along.rr * d.y)
        - 0.5 * vec2(product(by_col, d, d), product(by_row, d, d));
    vec2 bend = 0.5 * raised(metric, lower);
    // Where the grid does not resolve the surface, the second order is no better than the first.
    if (product(metric, bend, bend) < 0.0625 * product(metric, d, d)) d += bend;
    float per_col = sqrt(metric.cc);
    float across = sqrt(metric.rr - metric.cr * metric.cr / metric.cc);
    return normalize(vec2(per_col * d.x + metric.cr / per_col * d.y, across * d.y));
}

// Follows the way from a point to its source. Returns the number of the source, or -1 if the source is not
// near. `last` is the last vertex that is at least a cell away from the source, or the point itself.
int follow(ivec2 at, float start, out vec2 last) {
    Path path = path_from(at, start);
    vec2 passed[3] = vec2[](vec2(at), vec2(at), vec2(at));
    last = vec2(at);
    for (int i = 0; i < LOG_MAP_LINES; i++) {
        Line line = line_from(path);
        if (!line.exists) return -1;
        if (line.source >= 0) {
            vec2 end = place_of(source(line.source));
            for (int j = 0; j < 3; j++) {
                vec2 away = abs(passed[j] - end);
                if (max(away.x, away.y) >= 1.0 || j == 0) last = passed[j];
            }
            return line.source;
        }
        path.place = line.end;
        path.from = line.cell;
        float next = time_at(line.end.first);
        path.below = line.time + (path.base_time - next);
        path.base_time = next;
        passed[0] = passed[1];
        passed[1] = passed[2];
        passed[2] = position(line.end);
    }
    return -1;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(at, grid)) return;
    int index = index_of(at);
    float time = time_at(at);
    uint label = NO_LABEL;
    vec2 coordinates = vec2(unreached);
    vec2 way = NO_WAY;
    if (is_reached(time) && time - latest_start() <= radius) {
        way = way_from(at);
        float unit = longest_edge(at);
        if (time - latest_start() <= LOG_MAP_DISC * unit || source_beside(at) >= 0) {
            vec2 last;
            int found = follow(at, earliest_start(), last);
            if (found >= 0 && source(found).time != earliest_start()) {
                // Squared times are smooth if the initial value of the point's own source is subtracted
                // first.
                vec2 other;
                if (follow(at, source(found).time, other) == found) last = other;
            }
            if (found >= 0) {
                Source own = source(found);
                label = uint(found);
                vec2 from = place_of(own);
                bool is_there = last == from;
                float away = max(time - own.time, 0.0);
                coordinates = is_there ? vec2(0.0) : away * departure(from, last, unit);
            }
        }
    }
    ways[word_of(1, index)] = label;
    write_pair(0, index, coordinates);
    write_pair(1, index, way);
}
