#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Reads positions or heights from an image of the host, one texel per point. One invocation is one grid
// point. See points.glsl.

#include "shared/constants.glsl"
#include "shared/chart.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 1, binding = 2) uniform texture2D image;

#include "passes/points.glsl"

// Returns NaN beyond the edges of an image that is too small, so that the point counts as missing.
float component(ivec2 at, int index) {
    bool is_there = in_grid(at, textureSize(image, 0));
    return is_there ? texelFetch(image, at, 0)[index] : uintBitsToFloat(0x7fc00000u);
}
