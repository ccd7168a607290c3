// Returns a distance as hosts read it: the bits of a float. GLSL does not guarantee infinities.
uint distance_bits(float time) {
    return time < FAR ? floatBitsToUint(time) : 0x7f800000u;
}
