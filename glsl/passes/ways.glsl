// Stores the ways back from all grid points in a buffer, for way_starts.comp, directions.comp and
// log_map_*.comp. The buffer begins with a header: the complement of the earliest initial value of the
// sources (by rank, see start.glsl), the rank of the latest one, and for each round of a log map whether
// points are left. Sections follow, each in row-major order:
//
//     words   two copies of one word a point. At first they hold the number of a source beside the point,
//             and when its front arrives. Both are complements, so that zero means none.
//     pairs   three copies of two words a point: (u, v) of the log map, and twice a direction or a place, in
//             column and row.
//
// Only log maps have the pairs. Directions have the packed result in the second copy of the words.

layout(set = 1, binding = 1) restrict buffer Ways {
    uint ways[];
};

layout(push_constant) uniform Push {
    ivec2 grid;      // columns and rows of the whole grid
    int first_word;  // offset of the first source
    int count;       // number of sources
    int turn;        // starts: 1 in the second pass; rounds: the number of the round
    float radius;    // points that are later than all sources by more than this are not in the log map
    float unreached; // u and v of points that are not in it
};

int index_of(ivec2 at) {
    return row_major(at, grid.x);
}

int word_of(int which, int index) {
    return WAYS_HEADER + which * points_of(grid) + index;
}

// Returns the first word of a pair: 0 for (u, v), 1 and 2 for the copies of directions or places.
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
