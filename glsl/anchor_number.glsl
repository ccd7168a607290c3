// Anchors are numbered: first the points of the grid, row by row, then sources inside cells. The number lies
// where other fronts have their curvature.
// Twin: of_number() and number() in src/surface/real.rs.

// Numbers from here on are those of sources inside cells.
const uint FIRST_INSIDE = 1u << 25;

uint number_of(float held) {
    uint bits = floatBitsToUint(held);
    return bits >> 31 << 25 | (bits >> 4 & (FIRST_INSIDE - 1u));
}

// A number as one that devices keep as it is, between the smallest and the largest: with room for a tag.
float with_number(uint number) {
    return uintBitsToFloat(number >> 25 << 31 | 1u << 29 | (number & (FIRST_INSIDE - 1u)) << 4);
}

vec4 with_numbers(uvec4 numbers) {
    return uintBitsToFloat(numbers >> 25 << 31 | 1u << 29 | (numbers & (FIRST_INSIDE - 1u)) << 4);
}
