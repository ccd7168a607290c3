// Unpacks arrival times into an image with one distance per texel. One invocation is one texel of the fronts.

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts;
layout(set = 1, binding = 3, r32f) uniform writeonly restrict image2D distances;

layout(push_constant) uniform Size {
    ivec2 grid;      // columns and rows of the whole grid
    float unreached; // value for points that are not reached
};

void main() {
    ivec2 inner = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(inner, texels_of(grid))) return;
    ivec2 texel = with_border(inner);
    vec4 times = imageLoad(fronts, ivec3(texel, TIME));
    for (int i = 0; i < 4; i++) {
        ivec2 at = at_point(first_point(texel) + to_corner(i));
        if (is_beyond(at, grid)) continue;
        imageStore(distances, at, vec4(times[i] < FAR ? times[i] : unreached));
    }
}
