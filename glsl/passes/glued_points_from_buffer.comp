// Reads positions, heights or metrics of a glued surface from a buffer of the host, such as a vertex buffer. One
// invocation is one point of the grid or beyond its sides. See points.glsl and glued_points.glsl.

layout(local_size_x = WORKGROUP) in;

#include "passes/points.glsl"
#include "passes/from_buffer.glsl"
#include "passes/glued_points.glsl"
