// Places paths at their starts, except where no path can start. One invocation is one path.
// Twin: PathTracer::trace in crates/geometry/src/paths.

#include "shared/cell.glsl"

layout(local_size_x = WORKGROUP) in;

#include "passes/path_state.glsl"

// Returns whether the corners between which a place lies are reached.
bool is_reached_at(vec2 at) {
    ivec2 first = ivec2(at);
    vec2 share = at - vec2(first);
    bvec4 there = lessThan(times_at_corners(first), vec4(FAR));
    vec4 weights;
    bool inside = corner_weights(there, share, weights);
    bool on_line = there.x && (share.x == 0.0 || there.y) && (share.y == 0.0 || there.z);
    return share.x > 0.0 && share.y > 0.0 ? inside : on_line;
}

void main() {
    int number = int(gl_GlobalInvocationID.x);
    if (number >= records) return;
    Path path = Path(0u, OUTSIDE, -1, 0.0, 0.0, Place(ivec2(0), vec2(0.0)), 0.0, 0.0, 0.0, NO_CELL,
                     vec2(0.0), 0.0, FAR, -FAR, -1);
    vec2 at = start_of(number);
    if (number < paths && is_on_grid(at, grid)) {
        path.status = UNREACHED;
        if (is_reached_at(at)) {
            for (int i = 0; i < count; i++) {
                Source other = source(i);
                if (!counts(other)) continue;
                path.earliest = min(path.earliest, other.time);
                path.latest = max(path.latest, other.time);
            }
            begin(number, path, path.earliest);
        }
    }
    save(number, path);
}
