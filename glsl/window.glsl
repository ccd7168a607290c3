// A window of TEXELS x TEXELS texels in shared memory: their points, and those around that they see.
// Include after chart.glsl; the including shader defines TEXELS.

const int SIDE = 2 * TEXELS + 2;
const int AREA = SIDE * SIDE;
const int OWN_TEXELS = TEXELS * TEXELS;

// Where a point of the window is in shared memory.
int spot(ivec2 in_window) {
    return row_major(in_window, SIDE);
}

// The first point of a texel of the window, which counts from the window's first.
ivec2 first_in_window(ivec2 texel) {
    return first_point(texel) + 1;
}

// The point of the images that is the window's first, given its first texel.
ivec2 window_at(ivec2 first_texel) {
    return first_point(first_texel) - 1;
}
