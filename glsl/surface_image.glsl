// What the surface brings to fronts, by their kind: its Gaussian curvature, tagged, or on floor plans where holes
// are (corner.glsl). Include after chart.glsl.

layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2D gaussians;

// Where there is a slowness that is not the same everywhere, the image is twice as wide, and has it in its right
// half: 1 where no point is.
vec4 slowness_of(ivec2 texel) {
    return imageLoad(gaussians, texel + ivec2(imageSize(gaussians).x / 2, 0));
}

float slowness_at(ivec2 point) {
    return slowness_of(texel_of(point))[component_of(point)];
}

vec4 surface_of(ivec2 texel) {
    return imageLoad(gaussians, texel);
}

float surface_at(ivec2 point) {
    return surface_of(texel_of(point))[component_of(point)];
}
