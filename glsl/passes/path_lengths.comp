// Measures the paths whose vertices have slid, and writes the arrival times at their vertices. One invocation is one path.
// Twin: Tracer::slid in crates/geometry/src/paths/slides.rs.

layout(local_size_x = WORKGROUP) in;

#include "passes/path_slides.glsl"

float length_of_line(int number, int index) {
    vec2 a = vertex_at(number, index - 1);
    vec2 b = vertex_at(number, index);
    return is_line(a, b) ? cost_of_line(a, b) : 0.0;
}

void main() {
    int number = int(gl_GlobalInvocationID.x);
    if (!slides(number)) return;
    int record = number * CURVE_WORDS;
    int vertices = without_copies(number);
    line_cell = cell_at(ivec2(vertex_at(number, 0)));
    float size = 0.0;
    for (int i = 1; i < vertices; i++) size += length_of_line(number, i);
    // From the map's value at the start to the source's own, as the length adds up.
    float time = uintBitsToFloat(curves[record + 7]);
    float end = source(int(curves[record + 6])).time;
    float passed = 0.0;
    for (int i = 0; i < vertices; i++) {
        if (i > 0) passed += length_of_line(number, i);
        float share = size > 0.0 ? passed / size : 0.0;
        write_vertex(word_of(number, i), vertex_at(number, i), mix(time, end, share));
    }
    write_count(number, vertices);
    curves[record + 8] = floatBitsToUint(size);
}
