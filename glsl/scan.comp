#version 450
#extension GL_GOOGLE_include_directive : require
// One line of texels of a rotated raster scan (paper, section 5.3 and figure 3, second row): a
// row for the scans down and up, a column for those right and left.
// One invocation is one texel. Its first line of points is updated from the line behind, which
// the dispatch before has written; its second from its first, for which the two neighbouring
// points of the first line are computed here again.
// Twin: src/cpu/rotated_scan.rs.

#include "constants.glsl"
#include "texel.glsl"
#include "update.glsl"

layout(local_size_x = WORKGROUP) in;

// The scan's direction: one of the four unit steps.
layout(constant_id = 0) const int AHEAD_X = 0;
layout(constant_id = 1) const int AHEAD_Y = 1;

// The image that the scan writes is bound twice, so that reads of the line behind and writes of
// this line can be told apart.
layout(set = 0, binding = 0, rgba32f) uniform readonly restrict image2D edges;
layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2D old_times;
layout(set = 0, binding = 2, rgba32f) uniform readonly image2D line_behind;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2D new_times;
layout(set = 0, binding = 4) restrict buffer Residual {
    uint residual; // bits of the largest relative fall of an arrival time
};

layout(push_constant) uniform Line {
    int line;  // the row or column of texels
    int first; // the first texel visited in it
    int count; // how many
};

const ivec2 ahead = ivec2(AHEAD_X, AHEAD_Y);
const ivec2 along = ivec2(AHEAD_Y * AHEAD_Y, AHEAD_X * AHEAD_X);

float edge_length(ivec2 point, ivec2 step) {
    bool stored_here = step.y < 0 || (step.y == 0 && step.x > 0);
    return stored_here ? stored_length(imageLoad(edges, point), step)
                       : stored_length(imageLoad(edges, point + step), -step);
}

// Edge lengths from four points in a row, the second being this one.
vec4 edge_lengths(ivec2 point, ivec2 step) {
    return vec4(edge_length(point - along, step), edge_length(point, step),
                edge_length(point + along, step), edge_length(point + 2 * along, step));
}

void main() {
    if (gl_GlobalInvocationID.x >= uint(count)) return;
    ivec2 texel = line * abs(ahead) + (first + int(gl_GlobalInvocationID.x)) * along;
    vec4 old = imageLoad(old_times, texel);

    // Points along the line: the texel's own are 0 and 1.
    vec2 behind_01 = second_line(imageLoad(line_behind, texel - ahead), ahead);
    vec2 behind_21 = second_line(imageLoad(line_behind, texel - ahead - along), ahead);
    vec2 behind_23 = second_line(imageLoad(line_behind, texel - ahead + along), ahead);
    vec4 left = vec4(behind_21, behind_01);
    vec4 middle = vec4(behind_21.y, behind_01, behind_23.x);
    vec4 right = vec4(behind_01, behind_23);

    // First line, points -1 to 2.
    ivec2 point = 2 * texel + max(-ahead, 0);
    vec4 to_left = edge_lengths(point, -ahead - along);
    vec4 to_middle = edge_lengths(point, -ahead);
    vec4 to_right = edge_lengths(point, -ahead + along);
    vec4 base_left = edge_lengths(point - ahead - along, along);
    vec4 base_right = edge_lengths(point - ahead, along);
    vec4 line1 = vec4(first_line(imageLoad(old_times, texel - along), ahead).y,
                      first_line(old, ahead),
                      first_line(imageLoad(old_times, texel + along), ahead).x);
    line1 = min(line1, min(update(left, middle, to_left, to_middle, base_left),
                           update(middle, right, to_middle, to_right, base_right)));

    // Second line, points 0 and 1: left triangles in xy, right triangles in zw.
    ivec2 next = point + ahead;
    vec2 sides = vec2(edge_length(next, -ahead), edge_length(next + along, -ahead));
    vec4 l1 = vec4(edge_length(next, -ahead - along), edge_length(next + along, -ahead - along), sides);
    vec4 l2 = vec4(sides, edge_length(next, -ahead + along), edge_length(next + along, -ahead + along));
    vec4 base = vec4(edge_length(point - along, along), edge_length(point, along),
                     edge_length(point, along), edge_length(point + along, along));
    vec4 arrival = update(line1.xyyz, line1.yzzw, l1, l2, base);
    vec2 line2 = min(second_line(old, ahead), min(arrival.xy, arrival.zw));

    vec4 new = texel_of(line1.yz, line2, ahead);
    imageStore(new_times, texel, new);

    vec4 fall = mix(vec4(0.0), (old - new) / old, lessThan(new, old));
    float change = max(max(fall.x, fall.y), max(fall.z, fall.w));
    if (change > 0.0) atomicMax(residual, floatBitsToUint(change));
}
