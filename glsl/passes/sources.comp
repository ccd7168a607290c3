// Computes the initial values around sources that lie anywhere on the grid, as seed.comp reads them. A source
// reaches at most 2 x 2 texels. One invocation is one source and one of these texels. The first source that
// reaches a texel writes the earliest fronts of all sources to it.
// Twin: Sources::seeds in crates/surface/src/sources.

#include "update/tag.glsl"
#include "shared/seed_texel.glsl"
#include "shared/progress.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 3) writeonly restrict buffer Seeds {
    SeedTexel seeds[];
};

layout(push_constant) uniform Portion {
    ivec2 grid;     // columns and rows of the whole grid
    ivec2 lattice;  // see lattice.glsl
    int first_word; // offset of the first source
    int count;      // number of sources
    int copy;       // 0 for the sources, or bits OVER_COLUMNS and OVER_ROWS for their copies on the opposite sides
};

const int OVER_COLUMNS = 1;
const int OVER_ROWS = 2;

#include "update/source_arrival.glsl"

// Moves a place from a side of the grid to the opposite one. Returns whether the place lies on a side at
// which the grid goes on.
bool pass_side(inout float across, inout float along, vec2 last, int beyond) {
    bool is_on_seam = beyond != GRID_ENDS && (across == 0.0 || across == last.x);
    across = last.x - across;
    if (beyond == REVERSES) along = last.y - along;
    return is_on_seam;
}

// Returns a source, or the copy of it that `copy` selects. If there is no such copy, the returned source does
// not count.
Source copied(int index) {
    Source s = source(index);
    vec2 last = vec2(grid - 1);
    if ((copy & OVER_COLUMNS) != 0 && !pass_side(s.col, s.row, last.xy, lattice.x)) s.time = FAR;
    if ((copy & OVER_ROWS) != 0 && !pass_side(s.row, s.col, last.yx, lattice.y)) s.time = FAR;
    return s;
}

// Returns the first of the texels that hold points of the cells around a source.
ivec2 first_texel(Source s) {
    return texel_of(point_at(max(ivec2(ceil(place_of(s))) - 1, ivec2(0))));
}

// Returns whether a source reaches any of the points around it.
bool arrives(Source s) {
    if (!counts(s)) return false;
    for (int i = 0; i < 4; i++) {
        ivec2 at = ivec2(floor(place_of(s))) + to_corner(i);
        if (in_grid(at, grid) && arrival(s, at).x < FAR) return true;
    }
    return false;
}

bool reaches(Source s, ivec2 texel) {
    return in_grid(texel - first_texel(s), ivec2(2));
}

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= 4 * count) return;
    int number = index / 4;
    Source own = copied(number);
    seeds[index].texel = ivec2(-1);
    if ((index & 3) == 0 && copy == 0 && !arrives(own)) atomicAdd(passed_over, 1u);
    if (!counts(own)) return;
    ivec2 texel = first_texel(own) + to_corner(index & 3);
    // Next to the last texel of the grid lies the border, which gets no seeds.
    if (is_beyond(without_border(texel), texels_of(grid))) return;
    for (int i = 0; i < number; i++) {
        Source other = copied(i);
        if (counts(other) && reaches(other, texel)) return;
    }
    vec4 times = vec4(FAR);
    vec4 curvatures = vec4(0.0);
    for (int i = number; i < count; i++) {
        Source other = copied(i);
        if (!counts(other) || !reaches(other, texel)) continue;
        for (int j = 0; j < 4; j++) {
            vec2 front = arrival(other, at_point(first_point(texel) + to_corner(j)));
            if (front.x < times[j]) {
                times[j] = front.x;
                curvatures[j] = with_tag(front.y, SOURCE_TAG);
            }
        }
    }
    seeds[index].texel = texel;
    seeds[index].times = times;
    seeds[index].curvatures = curvatures;
}
