// In the first pass (turn 0), stores the earliest and the latest initial value of all sources, and for each corner of a
// source's cells when a front arrives there over a straight line from a source. In the second pass (turn 1), stores the
// first source whose front is the earliest there. All values but the latest initial value are complements, so that
// atomics keep the smallest one whatever their order; see ways.glsl. One invocation is one source.
// Counterpart: crates/geometry/src/paths/goals.rs, which lists the sources of each cell.

layout(local_size_x = WORKGROUP) in;

#include "passes/ways.glsl"
#include "shared/cell.glsl"
#include "shared/start.glsl"
#include "passes/path_cell.glsl"
#include "shared/source.glsl"

void main() {
    int number = int(gl_GlobalInvocationID.x);
    if (number >= count) return;
    Source own = source(number);
    if (!counts(own)) return;
    if (turn == 0) {
        atomicMax(ways[0], ~rank_of(own.time));
        atomicMax(ways[1], rank_of(own.time));
    }
    for (int i = 0; i < 4; i++) {
        ivec2 first = ivec2(place_of(own)) - to_corner(i);
        vec2 uv = place_of(own) - vec2(first);
        if (any(greaterThan(uv, vec2(1.0)))) continue;
        Cell cell = cell_at(first);
        bvec4 reached = reached_corners(cell);
        vec4 there;
        if (cell.unit == 0.0 || !corner_weights(reached, uv, there)) continue;
        vec4 squares = squares_from(cell, there);
        for (int j = 0; j < 4; j++) {
            if (!reached[j] || squares[j] >= 0.5 * NO_EDGE) continue;
            int index = index_of(first + to_corner(j));
            float away = cell.unit * cost_of(cell, squares[j], there, corner_alone(j));
            uint start = ~rank_of(own.time + away);
            if (turn == 0) {
                atomicMax(ways[word_of(1, index)], start);
            } else if (ways[word_of(1, index)] == start) {
                atomicMax(ways[word_of(0, index)], ~uint(number));
            }
        }
    }
}
