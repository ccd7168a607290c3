// What the update by anchors knows of a floor plan beside its grid points: at the end of the buffer for
// uploads sources inside cells, then the metric. Twin: src/vulkan/anchors.rs.

layout(set = 0, binding = 3) readonly restrict buffer Anchors {
    vec4 anchors[];
};

vec3 metric() {
    return anchors[anchors.length() - 1].xyz;
}

// The ends of an origin of curved fronts, by column and row: one, and what leads from it to the other; and its time.
vec4 origin_ends(uint number) {
    return anchors[anchors.length() - 1 - SOURCES_INSIDE + 2 * int(number)];
}

float origin_start(uint number) {
    return anchors[anchors.length() - SOURCES_INSIDE + 2 * int(number)].x;
}

vec4 source_inside(uint number) {
    return anchors[anchors.length() - 1 - SOURCES_INSIDE + int(number)];
}
