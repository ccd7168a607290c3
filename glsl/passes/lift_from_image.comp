// Lifts the vertices of curves to the surface, whose points lie in an image of the host, one texel per point.
// One row of workgroups is one curve, and one invocation handles some of its vertices. See lift.glsl.
// Twin: Curve::lift in crates/geometry/src/curve.rs.

layout(local_size_x = WORKGROUP) in;

#include "passes/lift.glsl"
#include "passes/from_image.glsl"
