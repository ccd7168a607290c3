#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Takes positions or heights from an image of the host's, one texel a point. One invocation is one
// grid point.

#include "constants.glsl"
#include "chart.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 1, binding = 2) uniform texture2D image;

#include "points.glsl"

float component(ivec2 at, int index) {
    return texelFetch(image, at, 0)[index];
}
