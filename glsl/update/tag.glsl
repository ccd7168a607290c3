// Defines tags: the last binary digits of the value that a front carries, and of the surface value.
//
// The tag of a front is the number of the scan that has brought it, from 1 to 4. A source's own front
// has the number 0, to which WHOLE is added. An exact seed has the tag EXACT; no front replaces it unless sources are
// added to the map. A front that comes from another copy of its point, on a glued surface, has the tag EXCHANGED.
// NOT_EXACT marks fronts in the surroundings of a source, at points where
// fronts of other sources may come first: merge_surroundings.comp drops the marked fronts. WHOLE is added if the front
// came through a whole triangle or is a source's own front. The tag of a surface value is LACKING at points that lack
// an edge, with DIFFRACTS added where fronts diffract.

const uint SCAN_OF_TAG = TAG & ~WHOLE;
// Tag of a source's front. It has WHOLE, since the direction of this front is as certain as that of a front through a
// whole triangle.
const uint SOURCE_TAG = WHOLE;

// Returns a number with a tag in its last digits. Numbers near zero become FLAT with the tag.
float with_tag(float value, uint tag) {
    float held = abs(value) < FLAT ? FLAT : value;
    return uintBitsToFloat((floatBitsToUint(held) & ~TAG) | tag);
}

vec4 with_tags(vec4 values, uvec4 tags) {
    return vec4(with_tag(values.x, tags.x), with_tag(values.y, tags.y),
                with_tag(values.z, tags.z), with_tag(values.w, tags.w));
}

uint tag_of(float held) {
    return floatBitsToUint(held) & TAG;
}

uvec4 tags_of(vec4 held) {
    return floatBitsToUint(held) & TAG;
}

// Returns the number of the scan that has brought a front.
uint scan_of(float held) {
    return floatBitsToUint(held) & SCAN_OF_TAG;
}

// Returns which fronts a scan has brought. `scan` is counted from 1.
bvec4 are_of_scan(vec4 held, uint scan) {
    return equal(floatBitsToUint(held) & SCAN_OF_TAG, uvec4(scan));
}

// Returns which numbers are equal except for their tags.
bvec4 are_alike_but_for_tags(vec4 a, vec4 b) {
    return equal((floatBitsToUint(a) ^ floatBitsToUint(b)) & ~TAG, uvec4(0u));
}
