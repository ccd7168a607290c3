// Follows the way of each point to places whose coordinates in the log map are known, and doubles the length
// of all ways for the next round. One invocation is one point.
// Twin: none; tests compare log maps with those of crates/geometry/src/directions.

#include "shared/times.glsl"

layout(local_size_x = WORKGROUP) in;

#include "passes/log_map.glsl"
#include "shared/source.glsl"

// Least cosine of the angle between coordinates of neighbours that follow the same front.
const float SAME_SIDE = 0.8;

// Numbers of the arrays of labels that are read and written. The arrays of ways have numbers that are larger
// by 1.
int from;
int to;

// Interpolates the direction of departure at a place from the points around it. Returns false if the
// coordinates of some of these points are not known.
bool departure_at(Around around, out vec2 departure, out uint label) {
    departure = vec2(0.0);
    label = NO_LABEL;
    if (around.nearest < 0) return false;
    for (int i = 0; i < 4; i++) {
        if (around.weights[i] > 0.0 && ways[word_of(from, around.points[i])] == NO_LABEL) return false;
    }
    int nearest = around.points[around.nearest];
    label = ways[word_of(from, nearest)];
    vec2 on = read_pair(0, nearest);
    for (int i = 0; i < 4; i++) {
        if (around.weights[i] == 0.0 || ways[word_of(from, around.points[i])] != label) continue;
        vec2 other = read_pair(0, around.points[i]);
        if (dot(other, on) < SAME_SIDE * length(other) * length(on)) continue;
        departure += around.weights[i] * other;
    }
    return dot(departure, departure) > 0.0;
}

// Takes the direction of departure from the earliest neighbour whose coordinates are known, for a point from
// which no way leads on.
bool departure_beside(ivec2 at, out vec2 departure, out uint label) {
    label = NO_LABEL;
    float earliest = FAR;
    for (int i = 0; i < 8; i++) {
        ivec2 other = at + NEIGHBOURS[i];
        if (!in_grid(other, grid) || ways[word_of(from, index_of(other))] == NO_LABEL) continue;
        float time = time_at(other);
        if (time < earliest) {
            earliest = time;
            label = ways[word_of(from, index_of(other))];
            departure = read_pair(0, index_of(other));
        }
    }
    return label != NO_LABEL && dot(departure, departure) > 0.0;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    // Nothing is left to find if the coordinates of all points were known after the previous round.
    if (is_beyond(at, grid) || (turn > 0 && ways[1 + turn] == 0u)) return;
    from = 1 - turn % 2;
    to = 1 - from;
    int index = index_of(at);
    uint label = ways[word_of(from, index)];
    vec2 place = read_pair(1 + from, index);
    vec2 next = place;
    if (is_way(place)) {
        next = carried_back(place, around(place, 1 + from), 1 + from);
        vec2 departure;
        bool is_new = false;
        vec2 on = place;
        for (int i = 0; i < LOG_MAP_STEPS && label == NO_LABEL && !is_new; i++) {
            Around near = around(on, 1 + from);
            is_new = departure_at(near, departure, label);
            if (!is_new) {
                label = NO_LABEL;
                vec2 back = i == 0 ? next : carried_back(on, near, 1 + from);
                if (back == on) is_new = departure_beside(at, departure, label);
                on = back;
            }
        }
        if (is_new) {
            float away = max(time_at(at) - source(int(label)).time, 0.0);
            write_pair(0, index, away * normalize(departure));
        }
        if (label == NO_LABEL) atomicOr(ways[2 + turn], 1u);
    }
    ways[word_of(to, index)] = label;
    write_pair(1 + to, index, next);
}
