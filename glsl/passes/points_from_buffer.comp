// Reads positions, heights or metrics from a buffer of the host, such as a vertex buffer. One invocation is one grid
// point. See points.glsl.

layout(local_size_x = WORKGROUP) in;

#include "passes/points.glsl"
#include "passes/from_buffer.glsl"
#include "passes/open_points.glsl"
