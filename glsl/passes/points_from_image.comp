// Reads positions, heights or metrics from an image of the host, one texel per point. One invocation is one grid
// point. See points.glsl.

layout(local_size_x = WORKGROUP) in;

#include "passes/points.glsl"
#include "passes/from_image.glsl"
#include "passes/open_points.glsl"
