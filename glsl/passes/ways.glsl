// Defines the buffer of the ways back from all grid points, for way_starts.comp, directions.comp and log_map_*.comp.
// The buffer begins with a header: the complement of the earliest initial value of the sources (by rank, see
// start.glsl), the rank of the latest one, and for each round of a log map whether there are still points without
// coordinates. Sections follow, each in row-major order:
//
//     words   two arrays of one word a point. At first, array 0 holds the complement of the number of a source beside
//             the point, and array 1 the complement of the rank of the time at which its front arrives. Zero means
//             none. Later, array 1 holds packed directions. In a log map, both arrays instead hold numbers of sources
//             (labels), and take turns as input and output.
//     pairs   three arrays of two words a point, for log maps only. Array 0 is (u, v) of the log map. Arrays 1 and 2
//             take turns as input and output: directions or places, as column and row.

layout(set = 1, binding = 1) restrict buffer Ways {
    uint ways[];
};

layout(push_constant) uniform Push {
    ivec2 grid;      // columns and rows of the whole grid
    ivec2 lattice;   // GRID_ENDS, GOES_ON or REVERSES: in x beyond the first and last column, in y beyond the rows
    int first_word;  // offset of the first source
    int count;       // number of sources
    int turn;        // in way_starts.comp 1 in the second pass; in log_map_rounds.comp the number of the round
    float radius;    // points that are later than all sources by more than this are not in the log map
    float unreached; // u and v of points that are not in the log map
    int slowed;      // 1 if lengths are weighted by a slowness
};

int index_of(ivec2 at) {
    return row_major(at, grid.x);
}

int word_of(int which, int index) {
    return WAYS_HEADER + which * points_of(grid) + index;
}

// Returns the first word of a pair: 0 for (u, v), 1 and 2 for the arrays of directions or places.
int pair_of(int which, int index) {
    return WAYS_HEADER + 2 * ((1 + which) * points_of(grid) + index);
}

vec2 read_pair(int which, int index) {
    int at = pair_of(which, index);
    return vec2(uintBitsToFloat(ways[at]), uintBitsToFloat(ways[at + 1]));
}

void write_pair(int which, int index, vec2 pair) {
    int at = pair_of(which, index);
    ways[at] = floatBitsToUint(pair.x);
    ways[at + 1] = floatBitsToUint(pair.y);
}
