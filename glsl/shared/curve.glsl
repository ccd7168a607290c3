// Stores curves in a buffer, so that they can be drawn without a readback. The buffer holds a record for each
// curve, and then room for the vertices of each curve. Passes receive the word at which the vertices begin.
//
// A record begins with what an indirect draw reads: the number of vertices, one instance, the first vertex,
// instance 0. The next word is the number of vertices that the path has, or that the contours need even if
// the buffer lacks room for them. The status of the curve follows. Paths also have the number of the source,
// the distance at the start and the length. A vertex is x, y and z, which lift_from_*.comp write, then its
// arrival time, row and column.

layout(set = 1, binding = 1) restrict buffer Curves {
    uint curves[];
};

// Writes the record of a curve, up to its status.
void write_record(int curve, uint drawn, uint first, uint vertices, uint status) {
    uint at = uint(curve * CURVE_WORDS);
    curves[at] = drawn;
    curves[at + 1u] = 1u;
    curves[at + 2u] = first;
    curves[at + 3u] = 0u;
    curves[at + 4u] = vertices;
    curves[at + 5u] = status;
}

uint vertices_of(int curve) {
    return curves[curve * CURVE_WORDS + 4];
}

// Returns the column and row of a vertex.
vec2 place_at(int at) {
    return vec2(uintBitsToFloat(curves[at + 5]), uintBitsToFloat(curves[at + 4]));
}

void write_vertex(int at, vec2 place, float time) {
    curves[at + 3] = floatBitsToUint(time);
    curves[at + 4] = floatBitsToUint(place.y);
    curves[at + 5] = floatBitsToUint(place.x);
}

void write_position(int at, vec3 position) {
    for (int i = 0; i < 3; i++) curves[at + i] = floatBitsToUint(position[i]);
}
