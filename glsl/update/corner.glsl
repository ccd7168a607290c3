// Finds corners of holes, at which shortest paths bend. The eight directions to the neighbours divide the surroundings
// of a point into eighths. On floor plans, the surface value of a point that lacks an edge holds three items: the tag,
// whether the point is a corner, and its open eighths. `there` has a bit for each of the eight neighbours,
// counter-clockwise from east: 1 if the neighbour is present. Include after tag.glsl.
// Twin: crates/surface/src/corner.rs.

// Bits of the directions along grid axes.
const uint AXES = 0x55u;

// Returns bits of directions turned clockwise by a number of eighths.
uint turned(uint bits, int by) {
    return (bits >> by | bits << (8 - by)) & 255u;
}

// Returns the eighths in which a path can leave a point. The bit of an eighth is that of the first of its two
// directions. Paths can pass through whole cells and halves of cells.
uint open_eighths(uint there) {
    uint axes = there & AXES;
    uint diagonals = there & ~AXES;
    uint next = axes & turned(axes, 2); // cells of which both axes are present
    return next | turned(next, 7) | (axes & turned(diagonals, 1)) | (diagonals & turned(axes, 1));
}

// Returns whether paths can bend at a point.
bool is_corner(uint there) {
    uint open = open_eighths(there);
    uint beside = open | turned(open, 7);
    uint passable = (there & AXES) | (there & ~AXES & beside);
    uint ends = open | passable;
    uint blocked = (passable | beside) & ~open;
    return (blocked & (turned(ends, 1) | turned(ends, 2) | turned(ends, 3))) != 0u;
}

const uint CORNER = 1u << 12;

// Encodes in a surface value whether a point is a corner, its open eighths and a tag. The exponent is that of FLAT, so
// that the value counts as zero where a Gaussian curvature is expected.
float with_corner(uint there, uint tag) {
    uint held = floatBitsToUint(FLAT) & 0x7f800000u;
    return uintBitsToFloat(held | (is_corner(there) ? CORNER : 0u) | open_eighths(there) << 4 | tag);
}

// Returns at which of four points paths can bend.
bvec4 are_corners(vec4 surface) {
    return equal(floatBitsToUint(surface) & (CORNER | LACKING), uvec4(CORNER | LACKING));
}

// Returns the eighths around a point that lead into a hole.
uint blocked_eighths(float surface) {
    return (tag_of(surface) & LACKING) != 0u ? ~(floatBitsToUint(surface) >> 4) & 255u : 0u;
}
