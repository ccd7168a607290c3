// Converts the host's points to the form that edges_from_*.comp read, for the shaders points_from_*.comp. One
// invocation is one grid point of a band of rows.
//
// The including shader defines
//     float component(ivec2 at, int index)              a component of the host's data for a point

float component(ivec2 at, int index);

layout(set = 0, binding = 3) writeonly restrict buffer Points {
    float points[]; // position and slowness, or height and slowness, row-major
};

layout(push_constant) uniform Band {
    ivec2 grid;     // columns and rows of the whole grid
    int first_row;  // the band's first row
    int band_rows;
    int first_own;  // first of these rows that belongs to no other band
    int own_rows;
    int heights;    // 1 for one height per point, 0 for positions
    int slowness;   // index of the component with the slowness; -1 for a slowness of 1 everywhere
    int first_word; // offset in the host's buffer
    int stride;     // words from point to point
};

#include "shared/usable.glsl"
#include "shared/progress.glsl"

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
    // The rows around a band belong to other bands and are counted there.
    bool is_own = place.y >= first_own && place.y < first_own + own_rows;
    if (!present && is_own) atomicAdd(holes, 1u);
}
