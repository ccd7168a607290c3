// Follows the ways of a log map between grid points, for log_map_*.comp.
//
// A way leads from a point some cells back towards the source. The way from a place between grid points is the
// mean of the ways of the points around it. So a way can be continued by the way from its end, which doubles
// it. All ways have the same length in the grid, so the ways of neighbouring points end side by side and can
// be averaged.

#include "passes/ways.glsl"
#include "shared/cell.glsl"

// The label of a point whose coordinates in the log map are not known yet. Other labels are the numbers of
// sources.
const uint NO_LABEL = 0xffffffffu;
// The value in place of a way for a point that has none: a hole, or a point beyond the radius.
const vec2 NO_WAY = vec2(-4.0);

bool is_way(vec2 way) {
    return way.x > NO_WAY.x;
}

// The points around a place that have a way, with their weights.
struct Around {
    ivec4 points;
    vec4 weights;
    int nearest; // index of the point with the largest weight; -1 if there is none
};

// Returns the points around a place that have a way. `which` is the number of the array of pairs that holds
// the ways.
Around around(vec2 place, int which) {
    Around found;
    vec2 first = floor(place);
    found.weights = bilinear(place - first);
    found.points = corners_row_major(ivec2(first), grid.x);
    found.nearest = -1;
    float heaviest = 0.0;
    for (int i = 0; i < 4; i++) {
        if (found.weights[i] <= 0.0 || !is_way(read_pair(which, found.points[i]))) {
            found.weights[i] = 0.0;
        } else if (found.weights[i] > heaviest) {
            heaviest = found.weights[i];
            found.nearest = i;
        }
    }
    return found;
}

vec2 place_of_point(int index) {
    return vec2(from_row_major(index, grid.x));
}

// Returns the place to which the way from a place leads. Points are left out if their ways end far from the
// end of the nearest point's way, as across the cut locus.
vec2 carried_back(vec2 place, Around around, int which) {
    if (around.nearest < 0) return place;
    vec2 on = read_pair(which, around.points[around.nearest]);
    vec2 sum = vec2(0.0);
    float all = 0.0;
    for (int i = 0; i < 4; i++) {
        if (around.weights[i] == 0.0) continue;
        vec2 to = read_pair(which, around.points[i]);
        vec2 apart = abs(to - on);
        if (max(apart.x, apart.y) > NEAR_PLACES) continue;
        sum += around.weights[i] * (to - place_of_point(around.points[i]));
        all += around.weights[i];
    }
    return back_on_grid(place + sum / all, grid);
}
