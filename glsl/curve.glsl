// Curves in a buffer, for drawing without a readback: first a record for each curve, then, from a
// word that the passes are told, room for so many vertices of each.
//
// A record is what a draw reads (how many vertices, one instance, the first vertex, instance 0),
// then how many vertices are there or are needed, what has become of the curve, and for paths the
// source's number, the distance at the start and the length. A vertex is x, y, z, which
// lift_from_*.comp fill in, the arrival time there, row and column.

layout(set = 1, binding = 1) restrict buffer Curves {
    uint curves[];
};

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

// Column and row of a vertex.
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
