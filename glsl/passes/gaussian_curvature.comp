// Computes the surface value of each point: the Gaussian curvature of its fan, reduced where the curvatures
// of its neighbours differ. Beside the holes of floor plans, the value tells instead whether the point is a
// corner; see corner.glsl. One invocation is one texel.
// Twin: settled() in crates/surface/src/gaussian_curvature.rs, where the formula is explained.

#include "update/tag.glsl"
#include "shared/edge_image.glsl"
#include "update/corner.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 1, rgba32f) uniform writeonly restrict image2D gaussians;
layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts_1;

layout(push_constant) uniform Size {
    ivec2 texels;       // columns and rows of texels, without the border
    float share_of_fan; // see fan_curvature.comp
    uint is_floor;      // whether the surface is a floor plan
    ivec2 grid;         // columns and rows of the whole grid
    ivec2 lattice;      // see lattice.glsl
    uint is_glued;      // whether points of the grid are copies of one another
};

#include "shared/lattice.glsl"
#include "passes/over_seams.glsl"

float fan_curvature(ivec2 point) {
    return imageLoad(fronts_1, ivec3(texel_of(point), CARRIED))[component_of(point)];
}

bool is_whole(float curvature) {
    return tag_of(curvature) == 0u;
}

// Returns the neighbours to which a point has edges, one bit each.
uint neighbours_of(ivec2 point) {
    uint there = 0u;
    for (int i = 0; i < 8; i++) there |= edge_length(point, NEIGHBOURS[i]) < FAR ? 1u << i : 0u;
    return there;
}

// Returns the tag of a point, given the tag that its fan has given it. Beside a pole some triangles have no
// area. The fan counts them as missing, but a front that passes the pole does not turn there, so the point
// loses the tag.
uint tag_beside_poles(ivec2 point, uint tag) {
    if (is_glued == 0u || tag == 0u) return tag;
    for (int i = 0; i < 8; i++) {
        ivec2 to = NEIGHBOURS[i];
        float base = edge_over_seams(point + to, NEIGHBOURS[(i + 1) % 8] - to);
        if (max(edge_over_seams(point, to), base) >= FAR) return tag;
    }
    return 0u;
}

// Returns the surface value of a point.
float settled(ivec2 point) {
    float own = fan_curvature(point);
    if (is_floor != 0u && !is_whole(own)) return with_corner(neighbours_of(point), tag_of(own));
    float curvatures[9];
    curvatures[8] = own;
    float largest = is_whole(own) ? abs(own) : 0.0;
    for (int i = 0; i < 8; i++) {
        bool exists = edge_over_seams(point, NEIGHBOURS[i]) < FAR;
        // Neighbours in the border are not read: the border of the image is not written, and no edge leads
        // there.
        curvatures[i] = exists ? fan_curvature(point_over_seams(point + NEIGHBOURS[i])) : with_tag(0.0, LACKING);
        if (is_whole(curvatures[i])) largest = max(largest, abs(curvatures[i]));
    }
    uint tag = tag_beside_poles(point, tag_of(own));
    if (largest <= 0.0) return with_tag(0.0, tag);
    float sum = 0.0;
    float squares = 0.0;
    float count = 0.0;
    for (int i = 0; i < 9; i++) {
        float curvature = curvatures[(i + 8) % 9];
        if (!is_whole(curvature)) continue;
        float relative = curvature / largest;
        sum += relative;
        squares += relative * relative;
        count += 1.0;
    }
    float mean = sum / count;
    float mean_square = squares / count;
    float agreement = max(2.0 * (mean * mean) - mean_square, 0.0) / mean_square;
    float curvature = is_whole(own) ? own : largest * mean;
    return with_tag(curvature * agreement, tag);
}

void main() {
    ivec2 inner = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(inner, texels)) return;
    ivec2 texel = with_border(inner);
    vec4 curvature;
    for (int i = 0; i < 4; i++) {
        ivec2 point = first_point(texel) + to_corner(i);
        curvature[i] = in_grid(at_point(point), grid) ? settled(point) : with_tag(0.0, LACKING);
    }
    imageStore(gaussians, texel, curvature);
}
