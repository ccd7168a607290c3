// A distance as hosts read it: the bits of a float, since GLSL does not promise infinities.
uint distance_bits(float time) {
    return time < FAR ? floatBitsToUint(time) : 0x7f800000u;
}
