// Estimates the typical length of a surface's edges along rows and columns from some texels of the grid. It
// averages the logarithms of the lengths, which are interpolated linearly between powers of two. A single
// workgroup is dispatched. One invocation handles some of the texels.
// Twin: crates/cpu/src/rotated/typical_edge.rs.

#include "shared/edge_image.glsl"
#include "shared/progress.glsl"

layout(local_size_x = WORKGROUP) in;

layout(push_constant) uniform Size {
    ivec2 texels; // columns and rows of texels, without the border
};

// Sum of logarithms in units of 2^-11, and their number.
shared uint sum;
shared uint count;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        sum = 0u;
        count = 0u;
    }
    barrier();
    for (int i = int(gl_LocalInvocationIndex); i < EDGE_LOOKS * EDGE_LOOKS; i += WORKGROUP) {
        ivec2 look = from_row_major(i, EDGE_LOOKS);
        ivec2 texel = with_border(texels * (2 * look + 1) / (2 * EDGE_LOOKS));
        vec4 lengths = imageLoad(edges, first_point(texel));
        for (int j = 0; j < 2; j++) {
            if (lengths[j] <= 0.0 || lengths[j] >= FAR) continue;
            atomicAdd(sum, floatBitsToUint(lengths[j]) >> 12);
            atomicAdd(count, 1u);
        }
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        typical_edge = count == 0u ? 0.0 : uintBitsToFloat(sum / count << 12);
    }
}
