// Defines the places of a path, and its state.

// A time that is not known yet.
const float UNKNOWN = 1e20;
const ivec2 NO_CELL = ivec2(-2);

// A place: a grid point, and a share of a cell to the east and south of it.
struct Place {
    ivec2 first;
    vec2 share;
};

struct Path {
    // The record.
    uint vertices;
    uint status;
    int source;
    float time;
    float size;
    // The state: the place, and the arrival time there less `base_time`, which keeps the digits of small differences.
    Place place;
    float below;
    float base_time;
    float lowest;   // earliest time of the grid points passed
    ivec2 from;     // cell through which the path came
    vec2 last;      // its last vertex, column and row
    float zero_time; // time that is subtracted before times are squared
    float earliest; // earliest and latest of the sources' initial values
    float latest;
    int own;        // source that the path must lead to; -1 if not known yet, -2 if not certain
};

bool is_point(Place place) {
    return place.share == vec2(0.0);
}

// Returns the column and row of a place.
vec2 position(Place place) {
    return vec2(place.first) + place.share;
}

Place place_from(vec2 at) {
    ivec2 first = ivec2(at);
    return Place(first, at - vec2(first));
}

bool is_same(Place a, Place b) {
    return a.first == b.first && a.share == b.share;
}
