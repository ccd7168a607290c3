// Computes the points nearest to each source. A buffer holds two copies of the labels of all grid points, in
// row-major order, and then two copies of the places to which their ways lead, as column and row. Each pass
// reads one copy and writes the other. The last pass leaves the labels in the first copy. Before the first of these
// passes, the second copy of the labels holds the arrival times of the sources' own fronts, as complements of ranks. On
// a glued surface it then holds the ranks of the arrival times at all points.
//
// The way of a point is the line on which its front has come, followed back towards the source. At first it
// leads to the point where it crosses the base of the triangle through which the front came. From there it
// continues like the ways of the points around. So each pass over all points lengthens all ways by a factor.
// Ways do not run from grid point to grid point, which would turn them by up to half the angle between two
// neighbours.
// Twin of all passes: crates/cpu/src/twins/regions.rs.

layout(set = 1, binding = 1) restrict buffer Regions {
    uint regions[];
};

layout(push_constant) uniform Push {
    ivec2 grid;     // columns and rows of the whole grid
    int first_word; // offset of the first source
    int count;      // number of sources
    int from;       // 0 or 1: copy of links and places that is read; the other one is written
    uint is_last;   // 1 in the last pass of region_labels.comp, and in the second pass of region_starts.comp
};

// Marks a link that is a label. Other links are the indices of points.
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
