// Maps times to integers in the same order, including negative times. Equal times have equal integers.

uint rank_of(float time) {
    uint bits = time == 0.0 ? 0u : floatBitsToUint(time);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

float time_of(uint rank) {
    return uintBitsToFloat((rank & 0x80000000u) != 0u ? rank & 0x7fffffffu : ~rank);
}
