// Returns whether a value is a number of at most LONGEST_EDGE in absolute value, so neither infinite nor NaN.
bool is_usable(float value) {
    return (floatBitsToUint(value) & 0x7fffffffu) <= floatBitsToUint(LONGEST_EDGE);
}
