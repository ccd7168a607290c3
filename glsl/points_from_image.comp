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

// Beyond an image that is too small there is no point.
float component(ivec2 at, int index) {
    bool is_there = in_grid(at, textureSize(image, 0));
    return is_there ? texelFetch(image, at, 0)[index] : uintBitsToFloat(0x7fc00000u);
}
