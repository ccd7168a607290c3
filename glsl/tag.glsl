// Tags: the last binary digits of what a front carries and of what the surface brings.
//
// The tag of a front is the scan that has brought it, from 1 to 4, or 0 for a source or EXACT for one that stays, plus WHOLE if it came
// through a whole triangle or is a source's. The surface's is LACKING at points that lack an edge, and DIFFRACTS
// beside it where waves diffract.

const uint SCAN_OF_TAG = TAG & ~WHOLE;
// That of a source's front, which knows where it comes from as well as one through a triangle.
const uint SOURCE_TAG = WHOLE;

// A number with a tag; zero becomes tiny.
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

// The scan that has brought a front.
uint scan_of(float held) {
    return floatBitsToUint(held) & SCAN_OF_TAG;
}

bvec4 are_of_scan(vec4 held, uint scan) {
    return equal(floatBitsToUint(held) & SCAN_OF_TAG, uvec4(scan));
}

bvec4 are_alike_but_for_tags(vec4 a, vec4 b) {
    return equal((floatBitsToUint(a) ^ floatBitsToUint(b)) & ~TAG, uvec4(0u));
}
