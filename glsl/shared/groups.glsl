// Numbers the workgroups of a dispatch. No map may depend on the order in which a device runs them. CPUs run
// them mostly in the order of their numbers, so tests assign the numbers in other orders.

// 0 for the device's numbers, -1 for the opposite order, and any other value for a random order.
layout(constant_id = 16) const int GROUP_ORDER = 0;

// Returns different values for different numbers.
uint scattered(uint number) {
    uint bits = (number ^ uint(GROUP_ORDER)) * 0x9e3779b1u;
    bits = (bits ^ (bits >> 15)) * 0x85ebca77u;
    return bits ^ (bits >> 13);
}

// Returns the place of a workgroup among all of a dispatch, in the order that is asked for.
uint in_group_order(uint number, uint count) {
    if (GROUP_ORDER < 0) return count - 1u - number;
    uint place = 0u;
    for (uint other = 0u; other < count; other++) place += scattered(other) < scattered(number) ? 1u : 0u;
    return place;
}

// Returns the number of this workgroup in each dimension, in place of gl_WorkGroupID.
uvec3 group_number() {
    if (GROUP_ORDER == 0) return gl_WorkGroupID;
    uvec3 groups = gl_NumWorkGroups;
    uvec3 id = gl_WorkGroupID;
    uint place = in_group_order(id.x + groups.x * (id.y + groups.y * id.z), groups.x * groups.y * groups.z);
    return uvec3(place % groups.x, place / groups.x % groups.y, place / (groups.x * groups.y));
}
