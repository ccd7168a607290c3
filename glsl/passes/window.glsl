// Places a window of TEXELS x TEXELS texels in shared memory: the points of these texels, and a ring of
// points around them. The including shader defines TEXELS.

const int SIDE = 2 * TEXELS + 2;
const int AREA = SIDE * SIDE;
const int OWN_TEXELS = TEXELS * TEXELS;

// Returns the index in shared memory of a point of the window.
int spot(ivec2 in_window) {
    return row_major(in_window, SIDE);
}

// Returns the first point of a texel. The texel is counted from the window's first texel, the point from the
// window's first point.
ivec2 first_in_window(ivec2 texel) {
    return first_point(texel) + 1;
}

// Returns the image point that comes first in the window, given the window's first texel.
ivec2 window_at(ivec2 first_texel) {
    return first_point(first_texel) - 1;
}
