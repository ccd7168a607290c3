// Converts the host's points to the form that edges_from_*.comp read, for the shaders points_from_*.comp and
// glued_points_from_*.comp. One invocation is one grid point of a band of rows.
//
// The including shader defines
//     float component(ivec2 at, int index)              a component of the host's data for a point
// and includes passes/open_points.glsl or passes/glued_points.glsl after this file.

float component(ivec2 at, int index);

layout(set = 0, binding = 3) writeonly restrict buffer Points {
    float points[]; // position, height or metric, each with the slowness, row-major
};

layout(push_constant) uniform Band {
    ivec2 grid;     // columns and rows of the whole grid
    int first_row;  // the band's first row
    int band_rows;
    int first_own;  // first of these rows that belongs to no other band
    int own_rows;
    int heights;    // 1 for one height per point, 0 for three numbers: a position or a metric
    int slowness;   // index of the component with the slowness; -1 for a slowness of 1 everywhere
    int first_word; // offset in the host's buffer
    int stride;     // words from point to point
    ivec2 halo;     // columns and rows of points beyond each side; 0 where the grid ends
    ivec2 lattice;  // see lattice.glsl
    vec2 spacing;   // of columns and rows, for heights
    int is_metric;  // 1 if three numbers are a metric
};

#include "shared/usable.glsl"
#include "shared/progress.glsl"

// Returns the number of components of a position, height or metric.
int components() {
    return heights != 0 ? 1 : 3;
}

// Returns the slowness at a point of the host, which may be unusable.
float given_slowness(ivec2 at) {
    return slowness < 0 ? 1.0 : component(at, slowness);
}

// Returns whether the host's data of a point are usable. Otherwise the point is a hole.
bool is_given(ivec2 at) {
    float weight = given_slowness(at);
    bool present = is_usable(weight) && weight >= 0.0;
    for (int i = 0; i < components(); i++) present = present && is_usable(component(at, i));
    return present;
}

// Writes the point with this number in the band: the host's point at `from`, or a hole.
void write_point(int number, ivec2 from, bool present) {
    int size = components();
    int to = number * (size + 1);
    for (int i = 0; i < size; i++) {
        float value = component(from, i);
        points[to + i] = is_usable(value) ? value : 0.0;
    }
    points[to + size] = present ? max(given_slowness(from), LEAST_SLOWNESS) : 0.0;
}

// Counts a hole at a place of the band. The rows around a band belong to other bands and are counted there.
void count_hole(int row) {
    bool is_own = row >= first_own && row < first_own + own_rows;
    if (is_own) atomicAdd(holes, 1u);
}
