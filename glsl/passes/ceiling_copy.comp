// Copies the fronts from one image to the other. It serves to measure the rate of a pass that only moves
// data. One invocation is one texel.

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray old_fronts;
layout(set = 2, binding = 0, rgba32f) uniform writeonly restrict image2DArray new_fronts;

layout(push_constant) uniform Size {
    ivec2 texels; // columns and rows of texels, without the border
};

void main() {
    ivec2 inner = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(inner, texels)) return;
    for (int layer = 0; layer < LAYERS; layer++) {
        ivec3 at = ivec3(with_border(inner), layer);
        imageStore(new_fronts, at, imageLoad(old_fronts, at));
    }
}
