#version 450
#extension GL_GOOGLE_include_directive : require
// Reads positions or heights from a buffer of the host, such as a vertex buffer. One invocation is one grid
// point. See points.glsl.

#include "shared/constants.glsl"
#include "shared/chart.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 1, binding = 0) readonly restrict buffer Input {
    float words[];
};

#include "passes/points.glsl"

float component(ivec2 at, int index) {
    return words[first_word + row_major(at, grid.x) * stride + index];
}
