// Continues paths by some steps back to the source. A path runs from cell to cell along the straight line on
// which the front arrives first. One invocation is one path.
// Twin: PathTracer::along_the_map in crates/geometry/src/paths, in double precision. Without that option the twin also
// pulls paths taut and traces again those that are too long. Over a slowness, path_slides.comp follows. To leave pits of
// the map, the twin looks further than two grid points.

layout(local_size_x = WORKGROUP) in;

#include "passes/path_state.glsl"
const bool PASSES_POLES = true;
#include "passes/path_line.glsl"

// Points coincide if they are nearer to one another than this, in units of their longest edges.
const float SAME_POINT = 1e-6;

void find_source(Cell cell, vec4 weights, Path path, inout Line nearest) {
    for (int i = 0; i < count; i++) try_source(i, cell, weights, path, nearest);
}

// Returns the earliest of the grid points between which a place lies: the point itself, the ends of its edge, or the
// corners of its cell at a start.
ivec2 lower_end(Place place) {
    ivec2 lowest = place.first;
    float time = FAR;
    for (int i = 0; i < 4; i++) {
        bool own = (to_corner(i).x == 0 || place.share.x > 0.0)
            && (to_corner(i).y == 0 || place.share.y > 0.0);
        float other = time_at(place.first + to_corner(i));
        if (own && other < time) {
            time = other;
            lowest = place.first + to_corner(i);
        }
    }
    return lowest;
}

// Moves along an edge and adds a vertex there. Returns false if there is no room.
bool step_to(int number, inout Path path, inout ivec2 point, ivec2 step) {
    path.size += edge_length(point_at(point), step);
    point += step;
    return add(number, path, vec2(point), time_at(point));
}

// Looks for the earliest neighbour of a point that coincides with the place of a path.
void look_from(ivec2 at, inout float earliest, inout ivec2 point, inout ivec2 first) {
    for (int j = 0; j < 8; j++) {
        float time = time_at(at + NEIGHBOURS[j]);
        if (time < earliest && edge_length(point_at(at), NEIGHBOURS[j]) < FAR) {
            earliest = time;
            first = NEIGHBOURS[j];
            point = at;
        }
    }
}

// Moves across coinciding points (copies of a point, and points in a row as at a pole) to the point from which an edge
// leads lowest. Returns the step of this edge, or zero if no edge leads lower than `below`.
ivec2 step_across(inout ivec2 point, float below) {
    float longest = 0.0;
    for (int i = 0; i < 8; i++) {
        float size = edge_length(point_at(point), NEIGHBOURS[i]);
        if (size < FAR) longest = max(longest, size);
    }
    ivec2 from = point;
    ivec2 first = ivec2(0);
    float earliest = below;
    for (int i = 0; i < 8; i += 2) {
        ivec2 at = from;
        while (edge_length(point_at(at), NEIGHBOURS[i]) <= SAME_POINT * longest) {
            at += NEIGHBOURS[i];
            look_from(at, earliest, point, first);
        }
    }
    Place own = Place(from, vec2(0.0));
    int copies = most_copies(own);
    for (int i = 1; i < copies; i++) {
        Place copy;
        if (copy_at(own, i, copy)) look_from(copy.first, earliest, point, first);
    }
    return first;
}

// Moves along edges to a point with an earlier arrival time than all points passed so far. That point lies one or two
// edges away, or one edge away from a point that coincides with `point`. Returns false if there is none.
bool detour(int number, inout Path path, inout ivec2 point) {
    float below = path.lowest;
    if (time_at(point) < below) return true;
    ivec2 first = ivec2(0);
    ivec2 second = ivec2(0);
    float earliest = below;
    for (int i = 0; i < 8; i++) {
        if (edge_length(point_at(point), NEIGHBOURS[i]) >= FAR) continue;
        float time = time_at(point + NEIGHBOURS[i]);
        if (time < earliest) {
            earliest = time;
            first = NEIGHBOURS[i];
        }
    }
    for (int i = 0; i < 8 && earliest == below; i++) {
        if (edge_length(point_at(point), NEIGHBOURS[i]) >= FAR) continue;
        ivec2 between = point + NEIGHBOURS[i];
        for (int j = 0; j < 8; j++) {
            if (edge_length(point_at(between), NEIGHBOURS[j]) >= FAR) continue;
            float time = time_at(between + NEIGHBOURS[j]);
            if (time < earliest) {
                earliest = time;
                first = NEIGHBOURS[i];
                second = NEIGHBOURS[j];
            }
        }
    }
    if (earliest == below) {
        ivec2 at = point;
        first = step_across(point, below);
        if (first == ivec2(0)) path.status = LOST;
        if (path.status == LOST || (point != at && !add(number, path, vec2(point), below))) {
            return false;
        }
    }
    return step_to(number, path, point, first)
        && (second == ivec2(0) || step_to(number, path, point, second));
}

// Leaves a place from which no line falls.
void escape(int number, inout Path path) {
    Place place = path.place;
    ivec2 point = lower_end(place);
    if (!is_point(place)) {
        ivec2 along = ivec2(greaterThan(place.share, vec2(0.0)));
        float share = max(place.share.x, place.share.y);
        path.size += (point == place.first ? share : 1.0 - share)
            * edge_length(point_at(place.first), along);
        if (!add(number, path, vec2(point), time_at(point))) return;
    }
    if (!detour(number, path, point)) return;
    path.place = Place(point, vec2(0.0));
    path.base_time = time_at(point);
    path.below = 0.0;
}

// Adds a vertex, unless the path is there already. Returns false if there is no room.
bool go_to(int number, inout Path path, vec2 at, float time) {
    return at == path.last || add(number, path, at, time);
}

// Adds one line to a path.
void go_on(int number, inout Path path) {
    if (is_point(path.place)) path.lowest = min(path.lowest, time_at(path.place.first));
    Line line = line_from(path);
    if (!line.exists) {
        escape(number, path);
        return;
    }
    if (path.time == UNKNOWN) path.time = path.base_time + line.time + line.size;
    if (!is_same(line.start, path.place)) {
        float here = path.below < UNKNOWN ? path.base_time + path.below : path.time;
        if (!add(number, path, position(line.start), here)) return;
    }
    path.size += line.size;
    if (line.source >= 0) {
        path.source = line.source;
        Source end = source(line.source);
        // The line may end at a copy of the source. A path that starts at its source is a single place.
        if (go_to(number, path, position(line.end), end.time) && go_to(number, path, place_of(end), end.time)) {
            path.status = COMPLETE;
        }
        return;
    }
    path.place = line.end;
    path.from = line.cell;
    if (!add(number, path, vec2(line.end.first) + line.end.share, path.base_time + line.time)) return;
    float next = time_at(line.end.first);
    path.below = line.time + (path.base_time - next);
    path.base_time = next;
}

// Restarts a path with the initial value of its own source. Squared times are smooth at a source if that value is
// subtracted first. The value is known once a path has found the source. If the restarted path leads to another source,
// it starts once more.
void go_again(int number, inout Path path) {
    if (path.own == -1 && path.status == COMPLETE) {
        float own = source(path.source).time;
        if (own == path.earliest) return;
        path.own = path.source;
        begin(number, path, own);
    } else if (path.own >= 0 && (path.status != COMPLETE || path.source != path.own)) {
        path.own = -2;
        begin(number, path, path.earliest);
    }
}

void main() {
    int number = int(gl_GlobalInvocationID.x);
    if (number >= records || curves[number * CURVE_WORDS + 5] != UNDER_WAY) return;
    Path path = load(number);
    for (int i = 0; i < STEPS_TOGETHER && path.status == UNDER_WAY; i++) {
        go_on(number, path);
        if (path.status != UNDER_WAY) go_again(number, path);
    }
    if (path.status != UNDER_WAY) {
        // The time at a start between grid points is known only once the first line has been found.
        int first = first_vertex + VERTEX_WORDS * number * capacity;
        write_vertex(first, start_of(number), path.time);
    }
    save(number, path);
}
