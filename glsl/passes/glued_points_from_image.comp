// Reads positions, heights or metrics of a glued surface from an image of the host, one texel per point. One
// invocation is one point of the grid or beyond its sides. See points.glsl and glued_points.glsl.

layout(local_size_x = WORKGROUP) in;

#include "passes/points.glsl"
#include "passes/from_image.glsl"
#include "passes/glued_points.glsl"
