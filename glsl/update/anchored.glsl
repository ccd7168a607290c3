// Implements fronts that carry the number of their anchor, with a tag. The surface values hold corners and
// holes. The update is in anchored_ways.glsl. Anchors are numbered: first the points of the grid, row by row,
// then sources inside cells.
// Twins: the anchored front in src/update, and src/vulkan/upload/anchors.rs.

// Returns the number of the anchor that a front carries.
uint number_of(float held) {
    uint bits = floatBitsToUint(held);
    return bits >> 31 << 25 | (bits >> 4 & (FIRST_INSIDE - 1u));
}

// Encodes the number of an anchor as a float that devices keep unchanged: neither too small nor too large,
// and with room for a tag.
float with_number(uint number) {
    return uintBitsToFloat(number >> 25 << 31 | 1u << 29 | (number & (FIRST_INSIDE - 1u)) << 4);
}

vec4 with_numbers(uvec4 numbers) {
    return uintBitsToFloat(numbers >> 25 << 31 | 1u << 29 | (numbers & (FIRST_INSIDE - 1u)) << 4);
}

// Returns whether one time is earlier than another by more than rounding.
bool is_shorter(float a, float b) {
    return a < b * (1.0 - ALIKE * PRECISION);
}

// Accepts fronts that are shorter by more than rounding. Fronts that the same scan brings again are accepted
// too, if `renews` is set. `scan` is counted from 1.
void accept_anchored(Fronts fronts, uint scan, bool renews, inout vec4 time, inout vec4 anchor) {
    const float alike = 1.0 - ALIKE * PRECISION;
    vec4 tagged = with_tags(fronts.carried, uvec4(scan));
    bvec4 first = lessThan(fronts.time, time * alike);
    bvec4 as_long = not(either(first, lessThan(time, fronts.time * alike)));
    bvec4 is_same = both(as_long, are_alike_but_for_tags(anchor, tagged));
    bvec4 again = both(both(bvec4(renews), lessThan(time, vec4(FAR))), are_of_scan(anchor, scan));
    bvec4 accepted = either(first, both(again, not(is_same)));
    anchor = mix(anchor, tagged, accepted);
    time = mix(time, fronts.time, accepted);
}

// Returns how much changes of anchors count beside changes of times, in units of the last place.
uint change_of_anchor(vec4 before, vec4 anchor) {
    return all(are_alike_but_for_tags(before, anchor)) ? 0u : uint(ANCHOR_COUNTS / PRECISION);
}
