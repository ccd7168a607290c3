// Returns whether a value is neither infinite, nor NaN, nor so large that squares of lengths would overflow.
bool is_usable(float value) {
    return (floatBitsToUint(value) & 0x7fffffffu) <= floatBitsToUint(LONGEST_EDGE);
}
