// Reads the surface values: the Gaussian curvature with a tag, or on floor plans the places of holes
// (corner.glsl).

layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2D gaussians;

// Returns the slowness of a texel. If the slowness varies, the image is twice as wide, and its right half
// holds the slowness, which is 1 where there is no point.
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
