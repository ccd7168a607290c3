// Reads the components of the host's points from a buffer. Include after points.glsl or lift.glsl.

layout(set = 1, binding = 0) readonly restrict buffer Input {
    float words[];
};

float component(ivec2 at, int index) {
    return words[first_word + row_major(at, grid.x) * stride + index];
}
