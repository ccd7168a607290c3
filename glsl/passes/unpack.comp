// Unpacks arrival times into rows of distances. Each invocation unpacks two points, one column of a texel.
// Neighbouring invocations then write to adjacent addresses, which matters since the output crosses a bus to the
// host. The third dimension of the dispatch selects the map. Twin: the distances of a solution in src/cpu.

#include "shared/distance.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts;
layout(set = 1, binding = 1) writeonly restrict buffer Output {
    uint distances[]; // as in distance.glsl, row-major
};

layout(push_constant) uniform Band {
    ivec2 grid;     // columns and rows of the whole grid
    int first_row;  // the band's first row, even
    int band_rows;
    int layers;     // number of layers per map in the image; the first holds its times
};

void main() {
    ivec2 first = ivec2(gl_GlobalInvocationID.x, first_row + 2 * int(gl_GlobalInvocationID.y));
    ivec2 end = ivec2(grid.x, first_row + band_rows);
    if (is_beyond(first, end)) return;
    vec4 times = imageLoad(fronts, ivec3(texel_of(point_at(first)), int(gl_WorkGroupID.z) * layers));
    for (int i = 0; i < 2; i++) {
        ivec2 at = first + ivec2(0, i);
        if (is_beyond(at, end)) continue;
        int row = int(gl_WorkGroupID.z) * band_rows + at.y - first_row;
        distances[row_major(ivec2(at.x, row), grid.x)] = distance_bits(times[component_of(point_at(at))]);
    }
}
