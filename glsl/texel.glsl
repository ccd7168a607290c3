// Which point lies where. 2 x 2 grid points share a texel of the fronts:
//
//     x y     a texel's row above, columns 2c and 2c + 1
//     z w     its row below
//
// Texels and points are counted from the corner of the image's border: grid point (row, col) is
// point ivec2(col, row) + 2 BORDER, and point p lies in texel p / 2. The image of edge lengths
// has one texel a point: its edges to the east, north, north-east and north-west.

// The arrival times of a texel's first and second line, in the order in which a scan that goes
// ahead passes them, each from west to east or from north to south.
vec2 first_line(vec4 texel, ivec2 ahead) {
    if (ahead.y != 0) return ahead.y > 0 ? texel.xy : texel.zw;
    return ahead.x > 0 ? texel.xz : texel.yw;
}

vec2 second_line(vec4 texel, ivec2 ahead) {
    return first_line(texel, -ahead);
}

// The texel made of two such lines.
vec4 texel_of(vec2 first, vec2 second, ivec2 ahead) {
    bool forward = ahead.x + ahead.y > 0;
    vec2 low = forward ? first : second;
    vec2 high = forward ? second : first;
    return ahead.y != 0 ? vec4(low, high) : vec4(low.x, high.x, low.y, high.y);
}

// The component of a point's lengths that leads a step to the east or north.
float stored_length(vec4 lengths, ivec2 step) {
    if (step.y == 0) return lengths.x;
    return step.x == 0 ? lengths.y : step.x > 0 ? lengths.z : lengths.w;
}

// Where the length of an edge is stored: at the end from which it leads east or north.
bool stored_here(ivec2 step) {
    return step.y < 0 || (step.y == 0 && step.x > 0);
}

// A number with a tag from 0 to 15 in its last binary digits; zero becomes tiny. The curvature of
// a front is tagged with the scan that has brought it, from 1 to 4, plus WHOLE if it came from a
// whole triangle, and that of the surface with 1 where waves diffract.
float with_tag(float value, uint tag) {
    float held = abs(value) < FLAT ? FLAT : value;
    return uintBitsToFloat((floatBitsToUint(held) & ~15u) | tag);
}
