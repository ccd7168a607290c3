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

#include "passes/lift.glsl"
#include "passes/from_image.glsl"
