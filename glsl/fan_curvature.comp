#version 450
#extension GL_GOOGLE_include_directive : require
// Gaussian curvature of each point's fan of triangles from its edge lengths, into the layer of
// what fronts carry of the second image, which is free until a map starts. One invocation is one
// texel.
// Twin: src/surface/gaussian_curvature.rs, where the formulas are explained.

#include "constants.glsl"
#include "chart.glsl"
#include "tag.glsl"
#include "edge_image.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform writeonly restrict image2DArray fronts_1;

layout(push_constant) uniform Size {
    ivec2 texels;       // columns and rows of texels, without the border
    float share_of_fan; // of a fan's area, to which its angle defect belongs
};

// Zero and a tag if a triangle of the fan is missing.
float fan_curvature(ivec2 point) {
    bool whole = true;
    bool lacks = false;
    vec2 turn = vec2(1.0, 0.0);
    float area = 0.0;
    float a = edge_length(point, NEIGHBOURS[0]);
    for (int i = 0; i < 8; i++) {
        ivec2 to = NEIGHBOURS[(i + 1) % 8];
        float b = edge_length(point, to);
        float c = edge_length(point + NEIGHBOURS[i], to - NEIGHBOURS[i]);
        float longest = max(max(a, b), c);
        if (longest >= FAR) {
            lacks = true;
            a = b;
            continue;
        }
        whole = whole && longest + longest < a + b + c;
        float x = 0.5 * ((a * a + b * b) - c * c) / (a * b);
        float y = sqrt(max((1.0 - x) * (1.0 + x), 0.0));
        turn = vec2(turn.x * x - turn.y * y, turn.x * y + turn.y * x);
        area = area + 0.5 * (a * b) * y;
        a = b;
    }
    // What is open to waves beside a hole or the border.
    if (lacks) return with_tag(0.0, turn.y < min(0.0, REFLEX * turn.x) ? LACKING | DIFFRACTS : LACKING);
    if (!whole) return with_tag(0.0, LACKING);
    float tangent = turn.x > 0.0 ? clamp(-turn.y / turn.x, -LARGEST_DEFECT, LARGEST_DEFECT)
                                 : (turn.y > 0.0 ? -LARGEST_DEFECT : LARGEST_DEFECT);
    float square = tangent * tangent;
    float defect = tangent * (1.0 - square * (1.0 / 3.0 - square * (1.0 / 5.0 - square * (1.0 / 7.0))));
    float signal = defect * defect / (defect * defect + DEFECT_NOISE * DEFECT_NOISE);
    return with_tag(defect * signal / (share_of_fan * area), 0u);
}

void main() {
    ivec2 inner = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(inner, texels)) return;
    ivec2 texel = with_border(inner);
    vec4 curvature;
    for (int i = 0; i < 4; i++) {
        curvature[i] = fan_curvature(first_point(texel) + to_corner(i));
    }
    imageStore(fronts_1, ivec3(texel, CARRIED), curvature);
}
