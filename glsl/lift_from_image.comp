#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Lifts the vertices of curves to points in an image of the host's, one texel a point.

#include "constants.glsl"
#include "chart.glsl"
#include "cell.glsl"
#include "usable.glsl"
#include "curve.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 1, binding = 2) uniform texture2D image;

#include "lift.glsl"

// Beyond an image that is too small there is no point.
float component(ivec2 at, int index) {
    bool is_there = in_grid(at, textureSize(image, 0));
    return is_there ? texelFetch(image, at, 0)[index] : uintBitsToFloat(0x7fc00000u);
}
