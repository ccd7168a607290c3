// Measures the edges of the surface: what the shaders edges_from_*.comp share.
// One invocation is one grid point and writes its edges to the east, north, north-east and
// north-west; FAR where the surface has none.
// Twin: src/surface/measure.rs.
//
// The including shader declares a Point with a member `slowness` (0 in a hole), and
//     Point load(ivec2 at)                              the point of the band's buffer
// and defines
//     float separation(ivec2 at, ivec2 step)            to a neighbour, without slowness
//     void look_at_turns(ivec2 at)                      how far the surface turns at a point

float separation(ivec2 at, ivec2 step);
void look_at_turns(ivec2 at);

layout(set = 0, binding = 0, rgba32f) uniform writeonly restrict image2D edges;

bool is_present(ivec2 at) {
    return in_grid(at, grid) && load(at).slowness > 0.0;
}

float edge_length(ivec2 at, ivec2 step) {
    if (!is_present(at + step)) return FAR;
    bool diagonal = step.x != 0 && step.y != 0;
    bool beside = is_present(at + ivec2(step.x, 0)) || is_present(at + ivec2(0, step.y));
    if (diagonal && !beside) return FAR;
    return 0.5 * (load(at).slowness + load(at + step).slowness) * separation(at, step);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (is_beyond(at, ivec2(grid.x, first_row + band_rows))) return;
    vec4 lengths = vec4(FAR);
    if (is_present(at)) {
        // A loop, since drivers are slow to compile the same code four times over.
        for (int i = 0; i < 4; i++) {
            lengths[i] = edge_length(at, STORED[i]);
        }
        look_at_turns(at);
    }
    imageStore(edges, point_at(at), lengths);
}
