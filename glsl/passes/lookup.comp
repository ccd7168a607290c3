// Looks up the distances at given places by bilinear interpolation between grid points. One invocation is one
// place.

#include "shared/cell.glsl"
#include "shared/times.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 1, binding = 0) readonly restrict buffer Input {
    float words[]; // row and column of each place
};
layout(set = 1, binding = 1) writeonly restrict buffer Output {
    float distances[];
};

layout(push_constant) uniform Places {
    ivec2 grid;           // columns and rows of the whole grid
    int count;
    int first_word;       // offset of the places
    int first_distance;
    float unreached;      // value for places that are not reached or not on the grid
};

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= count) return;
    vec2 place = vec2(words[first_word + 2 * index + 1], words[first_word + 2 * index]);
    float found = unreached;
    if (is_on_grid(place, grid)) {
        ivec2 first = ivec2(place);
        vec4 times = times_at_corners(first);
        vec4 weights;
        if (corner_weights(lessThan(times, vec4(FAR)), place - vec2(first), weights)) {
            found = 0.0;
            for (int i = 0; i < 4; i++) {
                if (weights[i] > 0.0) found += weights[i] * times[i];
            }
        }
    }
    distances[first_distance + index] = found;
}
