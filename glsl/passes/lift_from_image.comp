#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
// Lifts the vertices of curves to the surface, whose points lie in an image of the host, one texel per point.
// One row of workgroups is one curve, and one invocation handles some of its vertices. See lift.glsl.
// Twin: Curve::lift in src/geometry/curve.rs.

#include "shared/constants.glsl"
#include "shared/chart.glsl"
#include "shared/cell.glsl"
#include "shared/usable.glsl"
#include "shared/curve.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 1, binding = 2) uniform texture2D image;

#include "passes/lift.glsl"

// Returns NaN beyond the edges of an image that is too small, so that the point counts as missing.
float component(ivec2 at, int index) {
    bool is_there = in_grid(at, textureSize(image, 0));
    return is_there ? texelFetch(image, at, 0)[index] : uintBitsToFloat(0x7fc00000u);
}
