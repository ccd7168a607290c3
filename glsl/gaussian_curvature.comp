#version 450
#extension GL_GOOGLE_include_directive : require
// Gaussian curvature of the surface from its edge lengths, into both images of fronts. One
// invocation is one texel.
// Twin: src/surface/gaussian_curvature.rs, where the formulas are explained.

#include "constants.glsl"
#include "texel.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 0, rgba32f) uniform readonly restrict image2D edges;
layout(set = 0, binding = 1, rgba32f) uniform writeonly restrict image2DArray fronts_0;
layout(set = 0, binding = 3, rgba32f) uniform writeonly restrict image2DArray fronts_1;

layout(push_constant) uniform Size {
    ivec2 texels;       // columns and rows of texels, without the border
    float share_of_fan; // of a fan's area, to which its angle defect belongs
};

// Steps to the eight neighbours, counter-clockwise from east.
const ivec2 FAN[8] = ivec2[](ivec2(1, 0), ivec2(1, -1), ivec2(0, -1), ivec2(-1, -1),
                             ivec2(-1, 0), ivec2(-1, 1), ivec2(0, 1), ivec2(1, 1));

float edge_length(ivec2 point, ivec2 step) {
    return stored_here(step) ? stored_length(imageLoad(edges, point), step)
                             : stored_length(imageLoad(edges, point + step), -step);
}

// False if a triangle of the fan is missing.
bool fan_curvature(ivec2 point, out float curvature) {
    curvature = 0.0;
    vec2 turn = vec2(1.0, 0.0);
    float area = 0.0;
    float a = edge_length(point, FAN[0]);
    for (int i = 0; i < 8; i++) {
        ivec2 to = FAN[(i + 1) % 8];
        float b = edge_length(point, to);
        if (a >= FAR || b >= FAR) return false;
        float c = edge_length(point + FAN[i], to - FAN[i]);
        float longest = max(max(a, b), c);
        if (longest >= FAR || longest + longest >= a + b + c) return false;
        float x = 0.5 * ((a * a + b * b) - c * c) / (a * b);
        float y = sqrt(max((1.0 - x) * (1.0 + x), 0.0));
        turn = vec2(turn.x * x - turn.y * y, turn.x * y + turn.y * x);
        area = area + 0.5 * (a * b) * y;
        a = b;
    }
    float tangent = turn.x > 0.0 ? clamp(-turn.y / turn.x, -LARGEST_DEFECT, LARGEST_DEFECT)
                                 : (turn.y > 0.0 ? -LARGEST_DEFECT : LARGEST_DEFECT);
    float square = tangent * tangent;
    float defect = tangent * (1.0 - square * (1.0 / 3.0 - square * (1.0 / 5.0 - square * (1.0 / 7.0))));
    float signal = defect * defect / (defect * defect + DEFECT_NOISE * DEFECT_NOISE);
    curvature = defect * signal / (share_of_fan * area);
    return true;
}

// The curvature, tagged where waves diffract.
float tagged_curvature(ivec2 point) {
    float curvature;
    if (fan_curvature(point, curvature)) {
        return with_tag(curvature, 0u);
    }
    float sum = 0.0;
    float count = 0.0;
    for (int i = 0; i < 8; i++) {
        if (edge_length(point, FAN[i]) < FAR && fan_curvature(point + FAN[i], curvature)) {
            sum += curvature;
            count += 1.0;
        }
    }
    return with_tag(sum / max(count, 1.0), 1u);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (at.x >= texels.x) return;
    ivec2 texel = at + BORDER;
    ivec2 point = 2 * texel;
    vec4 curvature = vec4(tagged_curvature(point), tagged_curvature(point + ivec2(1, 0)),
                          tagged_curvature(point + ivec2(0, 1)), tagged_curvature(point + ivec2(1, 1)));
    imageStore(fronts_0, ivec3(texel, GAUSSIAN), curvature);
    imageStore(fronts_1, ivec3(texel, GAUSSIAN), curvature);
}
