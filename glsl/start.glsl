// Times as numbers in the same order, negative ones too; equal times are equal numbers.

uint rank_of(float time) {
    uint bits = time == 0.0 ? 0u : floatBitsToUint(time);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

float time_of(uint rank) {
    return uintBitsToFloat((rank & 0x80000000u) != 0u ? rank & 0x7fffffffu : ~rank);
}
