// Regions of the points nearest to each source, in a buffer: for each grid point, row-major, what is
// known of its label, twice, then the place to which its way leads, column and row, twice. Passes
// read the one and write the other, and the last of them leaves the labels in the first.
//
// The way to a point is the line on which its front has come, back towards the source: at first to
// where it crosses the base of the triangle that has brought the front. From there it leads on
// as the ways of the points around do, so that passes over all points make all ways longer by a
// factor each. Ways do not stick to grid points, which would turn them by up to half the angle
// between two neighbours.
// Twin of all passes: src/cpu/twins/regions.rs.

layout(set = 1, binding = 1) restrict buffer Regions {
    uint regions[];
};

layout(push_constant) uniform Push {
    ivec2 grid;     // columns and rows of the whole grid
    int first_word; // of the first source
    int count;      // of sources
    int from;       // 0 or 1: which links and places are read; the others are written
    uint is_last;   // 1 if nothing but labels is left to write: of seeds 1 in the second pass
};

// Set in a link beside a label. The others are the indices of points.
const uint KNOWN = 0x80000000u;
const uint NO_REGION = 0xffffffffu;

bool is_known(uint link) {
    return (link & KNOWN) != 0u;
}

int index_of(ivec2 at) {
    return row_major(at, grid.x);
}

int link_word(int which, int index) {
    return which * points_of(grid) + index;
}

int place_word(int which, int index) {
    return 2 * ((1 + which) * points_of(grid) + index);
}

vec2 place_at(int which, int index) {
    int at = place_word(which, index);
    return vec2(uintBitsToFloat(regions[at]), uintBitsToFloat(regions[at + 1]));
}

void write_place(int which, int index, vec2 place) {
    int at = place_word(which, index);
    regions[at] = floatBitsToUint(place.x);
    regions[at + 1] = floatBitsToUint(place.y);
}
