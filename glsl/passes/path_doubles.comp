// Doubles the vertices of paths at grid points as far as there is room, so that each of the two can leave along an edge of
// its own. One invocation is one path.
// Twin: double() in crates/geometry/src/paths/slides.rs.

layout(local_size_x = WORKGROUP) in;

#include "passes/path_slides.glsl"

bool is_grid_point(vec2 at) {
    return at == floor(at);
}

void main() {
    int number = int(gl_GlobalInvocationID.x);
    if (!slides(number)) return;
    int vertices = without_copies(number);
    int doubles = 0;
    int last = vertices - 1;
    for (int i = 1; i < last; i++) doubles += is_grid_point(vertex_at(number, i)) ? 1 : 0;
    doubles = min(doubles, capacity - vertices);
    write_count(number, vertices + doubles);
    // From the last one on, since vertices move to later words.
    for (int i = last; i > 0 && doubles > 0; i--) {
        vec2 at = vertex_at(number, i);
        write_vertex(word_of(number, i + doubles), at, 0.0);
        if (i == last || !is_grid_point(at)) continue;
        doubles -= 1;
        write_vertex(word_of(number, i + doubles), at, 0.0);
    }
}
