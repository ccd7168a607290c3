// Declares data at the end of the upload buffer, where there is room for SOURCES_INSIDE entries and one more: the sources
// inside cells of fronts with anchors, each in one entry, and in the last entry the metric of the floor plan. Columns and
// rows of places are those in the images with the border.
// Twin: src/vulkan/upload/anchors.rs.

layout(set = 0, binding = 3) readonly restrict buffer Anchors {
    vec4 anchors[];
};

// Returns the metric of the floor plan: the squared length of a step to the next row, the scalar product of this step
// and of a step to the next column, and the squared length of a step to the next column.
vec3 metric() {
    return anchors[anchors.length() - 1].xyz;
}

// Returns a source inside a cell: its column and row in xy, and its start time in z. `number` counts such sources
// from 0.
vec4 source_inside(uint number) {
    return anchors[anchors.length() - 1 - SOURCES_INSIDE + int(number)];
}
