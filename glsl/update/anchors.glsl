// Declares data at the end of the upload buffer, where there is room for SOURCES_INSIDE entries and one more. For
// fronts with anchors these are the sources inside cells, each in one entry, and in the last entry the metric of the
// floor plan. For curved fronts with several sources these are the origins, each in two entries: its ends, and the
// time at which fronts leave it. Columns and rows of places are those in the images with the border.
// Twins: src/vulkan/upload/anchors.rs and src/vulkan/upload/origins.rs.

layout(set = 0, binding = 3) readonly restrict buffer Anchors {
    vec4 anchors[];
};

// Returns the metric of the floor plan: the squared length of a step to the next row, the scalar product of this step
// and of a step to the next column, and the squared length of a step to the next column.
vec3 metric() {
    return anchors[anchors.length() - 1].xyz;
}

// Returns the ends of an origin of curved fronts, in columns and rows: one end in xy, and the step from it to the other
// end in zw.
vec4 origin_ends(uint number) {
    return anchors[anchors.length() - 1 - SOURCES_INSIDE + 2 * int(number)];
}

// Returns the time at which fronts leave an origin.
float origin_start(uint number) {
    return anchors[anchors.length() - SOURCES_INSIDE + 2 * int(number)].x;
}

// Returns a source inside a cell: its column and row in xy, and its start time in z. `number` counts such sources
// from 0.
vec4 source_inside(uint number) {
    return anchors[anchors.length() - 1 - SOURCES_INSIDE + int(number)];
}
