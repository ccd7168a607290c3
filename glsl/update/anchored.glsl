// Implements fronts that carry the number of their anchor, with a tag. The surface value at a point tells whether the
// point is a corner of a hole, and where the hole lies (corner.glsl). The update is in anchored_ways.glsl. Anchors have
// numbers. The points of the grid come first, row by row. The sources inside cells have the numbers from FIRST_INSIDE
// on.
// Twins: the anchored front in src/update, and src/vulkan/upload/anchors.rs.

// Returns the number of the anchor that a front carries.
uint number_of(float held) {
    uint bits = floatBitsToUint(held);
    return bits >> 31 << 25 | (bits >> 4 & (FIRST_INSIDE - 1u));
}

// Encodes the number of an anchor as a float with room for a tag. Devices keep this float unchanged: it is neither so
// small that they flush it to zero, nor infinite or NaN.
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

// Replaces the present fronts (`time`, `anchor`) by those that a scan brings, where these are earlier by more than
// rounding. If `renews` is set, fronts that the same scan brought before are replaced too, unless nothing but rounding
// has changed. `scan` is counted from 1.
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

// Returns a change of anchors at any of four points as an equivalent change of time, in units of the last place. The
// result is 0 if no anchor has changed.
uint change_of_anchor(vec4 before, vec4 anchor) {
    return all(are_alike_but_for_tags(before, anchor)) ? 0u : uint(ANCHOR_COUNTS / PRECISION);
}
