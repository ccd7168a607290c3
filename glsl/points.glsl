// The host's points in the form that edges_from_*.comp read: what the shaders points_from_*.comp
// share. One invocation is one grid point of a band of rows.
//
// The including shader defines
//     float component(ivec2 at, int index)              of what the host holds for a point

float component(ivec2 at, int index);

layout(set = 0, binding = 3) writeonly restrict buffer Points {
    float points[]; // position and slowness, or height and slowness, row-major
};

layout(push_constant) uniform Band {
    ivec2 grid;     // columns and rows of the whole grid
    int first_row;  // the band's first row
    int band_rows;
    int first_own;  // of these, the first one that no other band has
    int own_rows;
    int heights;    // 1 for a height a point, 0 for a position
    int slowness;   // which component is the slowness; -1 for 1 everywhere
    int first_word; // of the host's buffer
    int stride;     // words from point to point
};

#include "usable.glsl"
#include "progress.glsl"

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(place, ivec2(grid.x, band_rows))) return;
    ivec2 at = place + ivec2(0, first_row);
    int size = heights != 0 ? 1 : 3;
    int to = row_major(place, grid.x) * (size + 1);
    float weight = slowness < 0 ? 1.0 : component(at, slowness);
    bool present = is_usable(weight) && weight >= 0.0;
    weight = max(weight, LEAST_SLOWNESS);
    for (int i = 0; i < size; i++) {
        float value = component(at, i);
        bool usable = is_usable(value);
        present = present && usable;
        points[to + i] = usable ? value : 0.0;
    }
    points[to + size] = present ? weight : 0.0;
    // Rows around a band are those of others too.
    bool is_own = place.y >= first_own && place.y < first_own + own_rows;
    if (!present && is_own) atomicAdd(holes, 1u);
}
