// Reads the sources of a map as the host gives them.
//
// The including shader declares
//     ivec2 grid;       columns and rows of the whole grid
//     int first_word;   offset of the first source

layout(set = 1, binding = 0) readonly restrict buffer Input {
    float words[]; // four words per source, as in Source
};

struct Source {
    float row;
    float col;
    float time;
    float curvature;
};

// Returns the curvature of a source. A value that is 0, negative, infinite or NaN stands for a point source.
// A tiny value stands for a straight front.
float usable_curvature(float given) {
    uint bits = floatBitsToUint(given);
    if (bits == 0u || bits >= 0x7f800000u) return SOURCE_CURVATURE;
    return given <= FLAT ? 0.0 : min(given, SOURCE_CURVATURE);
}

Source source(int index) {
    int at = first_word + 4 * index;
    return Source(words[at], words[at + 1], words[at + 2], usable_curvature(words[at + 3]));
}

vec2 place_of(Source s) {
    return vec2(s.col, s.row);
}

// Returns whether a source counts: it lies on the grid, and its time is finite and less than FAR.
bool counts(Source s) {
    return is_on_grid(place_of(s), grid) && (floatBitsToUint(s.time) & 0x7f800000u) != 0x7f800000u
        && s.time < FAR;
}
