// Declares the data about a floor plan, other than its grid points, that the update with anchors reads. They
// lie at the end of the upload buffer: the sources inside cells, then the metric.
// Twin: src/vulkan/upload/anchors.rs.

layout(set = 0, binding = 3) readonly restrict buffer Anchors {
    vec4 anchors[];
};

vec3 metric() {
    return anchors[anchors.length() - 1].xyz;
}

// Returns the ends of an origin of curved fronts, in columns and rows: one end, and the step from it to the
// other. The time of the origin is read by origin_start().
vec4 origin_ends(uint number) {
    return anchors[anchors.length() - 1 - SOURCES_INSIDE + 2 * int(number)];
}

float origin_start(uint number) {
    return anchors[anchors.length() - SOURCES_INSIDE + 2 * int(number)].x;
}

vec4 source_inside(uint number) {
    return anchors[anchors.length() - 1 - SOURCES_INSIDE + int(number)];
}
