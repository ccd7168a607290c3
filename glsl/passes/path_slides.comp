// Moves the vertices of paths over a slowness along the grid's edges, to the best of all combinations within a window.
// One invocation is one window of a path; the vertices at its ends stay, and windows of the next step lie elsewhere.
// Twin: Lines::slide in crates/geometry/src/paths/slides.rs, where the choices are explained.

layout(local_size_x = WORKGROUP) in;

#include "passes/path_slides.glsl"

const int MOVES = 5;
// The move that is none.
const int STAYS = 2;
// Columns and rows by which a vertex at a grid point moves.
const vec2 AWAY[MOVES] = vec2[](vec2(0.0, 1.0), vec2(0.0, -1.0), vec2(0.0), vec2(1.0, 0.0), vec2(-1.0, 0.0));
const int STAYS_FIRST[MOVES] = int[](STAYS, 0, 1, 3, 4);
const int BITS_OF_MOVE = 3;

// A vertex, and whether it may move.
struct Vertex {
    vec2 at;
    bool is_free;
};

Vertex vertex_in(int number, int index, ivec2 window) {
    vec2 at = vertex_at(number, index);
    bool is_free = window.x < index && index < window.y && is_line(vertex_at(number, index - 1), at)
        && is_line(at, vertex_at(number, index + 1));
    return Vertex(at, is_free);
}

// Returns the place to which a vertex moves.
vec2 place_after(Vertex vertex, int move) {
    bvec2 between = notEqual(vertex.at, floor(vertex.at));
    if (!vertex.is_free || all(between)) return vertex.at;
    float size = exp2(-float(halvings + 1));
    if (!any(between)) return vertex.at + size * AWAY[move];
    vec2 moved = vertex.at + 0.5 * float(move - STAYS) * size * vec2(between);
    return clamp(moved, floor(vertex.at), ceil(vertex.at));
}

// Returns the first and the last vertex of a window.
ivec2 window_of(int window, int vertices) {
    int offset = halvings % 2 == 0 ? SLIDE_WINDOW : SLIDE_WINDOW / 2;
    int first = window == 0 ? 0 : offset + SLIDE_WINDOW * (window - 1);
    return ivec2(first, min(offset + SLIDE_WINDOW * window, vertices - 1));
}

void main() {
    int number = int(gl_GlobalInvocationID.y);
    if (!slides(number)) return;
    ivec2 window = window_of(int(gl_GlobalInvocationID.x), int(vertices_of(number)));
    if (window.x + 1 >= window.y) return;
    line_cell = cell_at(ivec2(vertex_at(number, window.x)));
    // For each move of each vertex, the best move of the vertex before.
    uint moves[SLIDE_WINDOW + 1];
    // For each move of the vertex before, the least cost of the path, less its cost if no vertex moves.
    float costs[MOVES] = float[](FAR, FAR, 0.0, FAR, FAR);
    Vertex from = vertex_in(number, window.x, window);
    for (int index = window.x + 1; index <= window.y; index++) {
        Vertex to = vertex_in(number, index, window);
        float stays = is_line(from.at, to.at) ? cost_of_line(from.at, to.at) : 0.0;
        float before[MOVES] = costs;
        uint best = 0u;
        for (int own = 0; own < MOVES; own++) {
            vec2 there = place_after(to, own);
            costs[own] = FAR;
            int move = STAYS;
            // Among equals, the vertex before stays.
            for (int i = 0; i < MOVES && (own == STAYS || there != to.at); i++) {
                int other = STAYS_FIRST[i];
                vec2 here = place_after(from, other);
                if (other != STAYS && here == from.at) continue;
                bool is_same = own == STAYS && other == STAYS;
                float cost = before[other] + (is_same ? 0.0 : cost_of_line(here, there) - stays);
                if (cost < costs[own]) {
                    costs[own] = cost;
                    move = other;
                }
            }
            best |= uint(move) << uint(BITS_OF_MOVE * own);
        }
        moves[index - window.x] = best;
        from = to;
    }
    int own = STAYS;
    for (int index = window.y; index > window.x; index--) {
        vec2 place = place_after(vertex_in(number, index, window), own);
        own = int(moves[index - window.x] >> uint(BITS_OF_MOVE * own)) & 7;
        if (index < window.y) write_vertex(word_of(number, index), place, 0.0);
    }
}
