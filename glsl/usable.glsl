// Neither infinite, nor NaN, nor so large that squares of lengths would be.
bool is_usable(float value) {
    return (floatBitsToUint(value) & 0x7fffffffu) <= floatBitsToUint(LONGEST_EDGE);
}
