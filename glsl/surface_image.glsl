// What the surface brings to fronts, by their kind: its Gaussian curvature, tagged, or on floor plans where holes
// are (corner.glsl). Include after chart.glsl.

layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2D gaussians;

vec4 surface_of(ivec2 texel) {
    return imageLoad(gaussians, texel);
}

float surface_at(ivec2 point) {
    return surface_of(texel_of(point))[component_of(point)];
}
