// Measures the edges of the surface, for the shaders edges_from_*.comp. One invocation is one grid point. It
// writes the lengths of the point's edges to the east, north, north-east and north-west, or FAR where the
// surface has no edge.
// Twin: crates/surface/src/measure.rs.
//
// The including shader declares a Point with a member `slowness` (0 in a hole), and
//     Point load(ivec2 at)                              a point of the band's buffer
// and defines
//     float separation(ivec2 at, ivec2 step)            distance to a neighbour, without slowness
//     void measure_turns(ivec2 at)                      measures how far the surface turns at a point
// after this file. skew.glsl follows too.

#include "update/tag.glsl"
#include "shared/progress.glsl"

float separation(ivec2 at, ivec2 step);
void measure_turns(ivec2 at);
void measure_skew(ivec2 at);

layout(set = 0, binding = 0, rgba32f) uniform writeonly restrict image2D edges;
layout(set = 0, binding = 1, rgba32f) uniform writeonly restrict image2D gaussians;

bool is_present(ivec2 at) {
    return in_grid(at + halo, grid + 2 * halo) && load(at).slowness > 0.0;
}

// Returns whether a point is present and not beyond a side where the grid goes on.
bool is_own(ivec2 at) {
    return in_grid(at, grid) && is_present(at);
}

// Returns whether there is an edge between two points of which the first is present. A diagonal exists only if one of
// the two points beside it does.
bool has_edge(ivec2 at, ivec2 step) {
    if (!is_own(at + step)) return false;
    bool diagonal = step.x != 0 && step.y != 0;
    return !diagonal || is_present(at + ivec2(step.x, 0)) || is_present(at + ivec2(0, step.y));
}

// Returns the length of an edge, weighted by the mean slowness of its ends.
float edge_length(ivec2 at, ivec2 step) {
    if (!has_edge(at, step)) return FAR;
    float apart = separation(at, step);
    if (!(apart > 0.0 && apart < FAR)) atomicAdd(no_length, 1u);
    return 0.5 * (load(at).slowness + load(at + step).slowness) * apart;
}

// Returns the slowness at a point, with a tag if it jumps there.
float tagged_slowness(ivec2 at) {
    float own = load(at).slowness;
    bool jumps = false;
    for (int i = 0; i < 8; i++) {
        if (!is_own(at + NEIGHBOURS[i])) continue;
        float there = load(at + NEIGHBOURS[i]).slowness;
        jumps = jumps || max(there, own) > EVEN_SLOWNESS * min(there, own);
        if (!is_own(at - NEIGHBOURS[i])) continue;
        float back = load(at - NEIGHBOURS[i]).slowness;
        jumps = jumps || abs(there - own + (back - own)) > ROUGH_SLOWNESS * own;
    }
    return with_tag(own, jumps ? JUMPS : 0u);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (is_beyond(at, ivec2(grid.x, first_row + band_rows))) return;
    vec4 lengths = vec4(FAR);
    if (is_present(at)) {
        // This is a loop, since drivers are slow to compile the same code four times.
        for (int i = 0; i < 4; i++) {
            lengths[i] = edge_length(at, STORED[i]);
        }
        measure_turns(at);
        measure_skew(at);
    }
    imageStore(edges, point_at(at), lengths);
    // The slowness of all points of a texel is written by the invocation of its first point.
    if (slowed == 0 || at != first_point(without_border(texel_of(point_at(at))))) return;
    vec4 slowness;
    for (int i = 0; i < 4; i++) {
        ivec2 other = at + to_corner(i);
        slowness[i] = is_own(other) ? tagged_slowness(other) : 1.0;
    }
    imageStore(gaussians, texel_of(point_at(at)) + ivec2(imageSize(gaussians).x / 2, 0), slowness);
}
