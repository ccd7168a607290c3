// Finds the earliest of the sources' own fronts at the points around them, and in a second pass the number of
// the first source that brings this front. One invocation is one source. Both values are stored as
// complements, so that zero means none, and are found by atomics whose order does not matter.
// Twin: crates/cpu/src/twins/regions.rs.

layout(local_size_x = WORKGROUP) in;

#include "passes/regions.glsl"
#include "update/source_arrival.glsl"
#include "shared/start.glsl"

void main() {
    int number = int(gl_GlobalInvocationID.x);
    if (number >= count) return;
    Source own = source(number);
    if (!counts(own)) return;
    ivec2 first = ivec2(ceil(place_of(own))) - 1;
    for (int i = 0; i < 9; i++) {
        ivec2 at = first + from_row_major(i, 3);
        if (!in_grid(at, grid)) continue;
        float time = arrival(own, at).x;
        if (time >= FAR) continue;
        int index = index_of(at);
        uint start = ~rank_of(time);
        if (is_last == 0u) {
            atomicMax(regions[link_word(1, index)], start);
        } else if (regions[link_word(1, index)] == start) {
            atomicMax(regions[link_word(0, index)], ~uint(number));
        }
    }
}
