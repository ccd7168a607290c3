// Writes the fans of a surface in the order in which one of the scans visits them. One invocation is one pair
// of points of a line.
// Twin: Fan::of in crates/cpu/src/pairwise.

#include "shared/edge_image.glsl"
#include "shared/surface_image.glsl"
#include "passes/pairwise_fans.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 3) writeonly restrict buffer Fans {
    float fans[];
};

layout(push_constant) uniform Size {
    ivec2 grid; // columns and rows of points
    int scan;   // number of the scan, from 0 in the order of an iteration
};

void main() {
    ivec2 ahead = ahead_of(scan);
    ivec2 along = along_of(scan);
    int pairs = pairs_of(points_of_line(grid, scan));
    int line = int(gl_GlobalInvocationID.y);
    int pair = int(gl_GlobalInvocationID.x);
    if (pair >= pairs) return;

    ivec2 a = point_at(in_line(line, 2 * pair, ahead, along));
    int place = fan_place(grid, scan, line, pair, pairs);
    for (int i = 0; i < 3; i++) {
        ivec2 step = (i - 1) * along - ahead;
        fans[place + i * pairs] = edge_length(a, step);
        fans[place + (3 + i) * pairs] = edge_length(a + along, step);
        fans[place + (6 + i) * pairs] = edge_length(a + step, along);
    }
    if (CARRIES) {
        for (int i = 0; i < 4; i++) {
            fans[place + (9 + i) * pairs] = surface_at(a + (i - 1) * along - ahead);
        }
        fans[place + 13 * pairs] = surface_at(a);
        fans[place + 14 * pairs] = surface_at(a + along);
    }
}
