// Maps times to unsigned integers in the same order, so that integer atomics find the earliest or latest time. Times
// may be negative; 0 and -0 have the same integer.

uint rank_of(float time) {
    uint bits = time == 0.0 ? 0u : floatBitsToUint(time);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

// Returns the time with a rank.
float time_of(uint rank) {
    return uintBitsToFloat((rank & 0x80000000u) != 0u ? rank & 0x7fffffffu : ~rank);
}
