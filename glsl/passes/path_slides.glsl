// Measures the lines of a complete path over a slowness, for path_doubles.comp, path_slides.comp and path_lengths.comp.
// Twin: crates/geometry/src/paths/slides.rs.

#include "shared/cell.glsl"
#include "passes/path_state.glsl"
#include "passes/path_cell.glsl"

// Relative excess over the map's value up to which a path is accepted, as on the CPU.
const float TOO_LONG = 5e-4;

// The cell of the last line. The next line mostly lies in it too.
Cell line_cell;

int word_of(int number, int vertex) {
    return first_vertex + VERTEX_WORDS * (number * capacity + vertex);
}

vec2 vertex_at(int number, int vertex) {
    return place_at(word_of(number, vertex));
}

// Returns whether a path is too long for the map's value, so that its vertices slide.
bool slides(int number) {
    int record = number * CURVE_WORDS;
    if (number >= records || curves[record + 5] != COMPLETE) return false;
    float start = source(int(curves[record + 6])).time;
    float value = uintBitsToFloat(curves[record + 7]) - start;
    return uintBitsToFloat(curves[record + 8]) > (1.0 + TOO_LONG) * value;
}

// Returns whether two vertices are the ends of a line. On a seam, they are copies of one point.
bool is_line(vec2 a, vec2 b) {
    return all(lessThanEqual(abs(a - b), vec2(1.0)));
}

// Returns whether a place lies in the line's cell, and its weights there.
bool weights_there(vec2 at, out vec4 weights) {
    vec2 inside = at - vec2(line_cell.first);
    bool is_inside = all(greaterThanEqual(inside, vec2(0.0))) && all(lessThanEqual(inside, vec2(1.0)));
    return corner_weights(reached_corners(line_cell), inside, weights) && is_inside;
}

// Returns the cost of the straight line between two places, or FAR if no cell contains both.
float cost_of_line(vec2 a, vec2 b) {
    if (a == b) return 0.0;
    vec2 middle = 0.5 * (a + b);
    vec2 first = floor(middle);
    // A line along the edge between two cells lies in both.
    vec2 on_edge = vec2(equal(first, middle));
    for (int i = 0; i < 2; i++) {
        ivec2 corner = ivec2(first - float(i) * on_edge);
        if (corner != line_cell.first) line_cell = cell_at(corner);
        vec4 own;
        vec4 there;
        if (line_cell.unit > 0.0 && weights_there(a, own) && weights_there(b, there)) {
            return line_cell.unit * cost_between(line_cell, own, there);
        }
    }
    return FAR;
}

// Removes vertices that are copies of the one before. Returns the number of the others.
int without_copies(int number) {
    int vertices = int(vertices_of(number));
    int count = 1;
    vec2 last = vertex_at(number, 0);
    for (int i = 1; i < vertices; i++) {
        vec2 at = vertex_at(number, i);
        if (at == last) continue;
        write_vertex(word_of(number, count), at, 0.0);
        last = at;
        count += 1;
    }
    return count;
}

// Writes the number of a path's vertices.
void write_count(int number, int vertices) {
    curves[number * CURVE_WORDS] = uint(vertices);
    curves[number * CURVE_WORDS + 4] = uint(vertices);
}
