// Measures the edges of the surface: what the shaders edges_from_*.comp share.
// One invocation is one grid point and writes its edges to the east, north, north-east and
// north-west; FAR where the surface has none.
// Twin: src/surface/edges.rs.
//
// The including shader declares a Point with a member `slowness` (0 in a hole), and
//     Point load(ivec2 at)                              the point of the band's buffer
//     float separation(Point a, Point b, ivec2 step)    their distance without slowness

layout(set = 0, binding = 0, rgba32f) uniform writeonly restrict image2D edges;

bool in_grid(ivec2 at) {
    return at.x >= 0 && at.y >= 0 && at.x < grid.x && at.y < grid.y;
}

bool is_present(ivec2 at) {
    return in_grid(at) && load(at).slowness > 0.0;
}

float edge_length(ivec2 at, ivec2 step) {
    if (!is_present(at + step)) return FAR;
    bool diagonal = step.x != 0 && step.y != 0;
    bool beside = is_present(at + ivec2(step.x, 0)) || is_present(at + ivec2(0, step.y));
    if (diagonal && !beside) return FAR;
    Point a = load(at);
    Point b = load(at + step);
    return 0.5 * (a.slowness + b.slowness) * separation(a, b, step);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, first_row);
    if (at.x >= grid.x || at.y >= first_row + band_rows) return;
    vec4 lengths = vec4(FAR);
    if (is_present(at)) {
        lengths = vec4(edge_length(at, ivec2(1, 0)), edge_length(at, ivec2(0, -1)),
                       edge_length(at, ivec2(1, -1)), edge_length(at, ivec2(-1, -1)));
    }
    imageStore(edges, at + 2 * BORDER, lengths);
}
