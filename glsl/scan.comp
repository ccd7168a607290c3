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
layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2DArray old_fronts;
layout(set = 0, binding = 2, rgba32f) uniform readonly image2DArray fronts_behind;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2DArray new_fronts;
layout(set = 0, binding = 4) restrict buffer Residual {
    uint residual; // largest change of a front, in units of the last place of its arrival time
};

layout(push_constant) uniform Line {
    int line;  // the row or column of texels
    int first; // the first texel visited in it
    int count; // how many
    bool renews; // curved fronts that this scan has brought before
};

const ivec2 ahead = ivec2(AHEAD_X, AHEAD_Y);
const ivec2 along = ivec2(AHEAD_Y * AHEAD_Y, AHEAD_X * AHEAD_X);

float edge_length(ivec2 point, ivec2 step) {
    return stored_here(step) ? stored_length(imageLoad(edges, point), step)
                             : stored_length(imageLoad(edges, point + step), -step);
}

// Edge lengths from four points in a row, the second being this one.
vec4 edge_lengths(ivec2 point, ivec2 step) {
    return vec4(edge_length(point - along, step), edge_length(point, step),
                edge_length(point + along, step), edge_length(point + 2 * along, step));
}

// A layer of the fronts on the line behind, at points -2 to 3 along the line of texels; the
// texel's own points are 0 and 1. Gaussian curvature never changes.
struct Behind {
    vec2 left, middle, right;
};

Behind behind(ivec2 texel, int layer) {
    ivec3 at = ivec3(texel - ahead, layer);
    ivec3 side = ivec3(along, 0);
    return Behind(second_line(imageLoad(fronts_behind, at - side), ahead),
                  second_line(imageLoad(fronts_behind, at), ahead),
                  second_line(imageLoad(fronts_behind, at + side), ahead));
}

// A layer at points -1 to 2 of the texel's first line.
vec4 first_line_old(ivec2 texel, int layer) {
    ivec3 at = ivec3(texel, layer);
    ivec3 side = ivec3(along, 0);
    return vec4(first_line(imageLoad(old_fronts, at - side), ahead).y,
                first_line(imageLoad(old_fronts, at), ahead),
                first_line(imageLoad(old_fronts, at + side), ahead).x);
}

// Distance from 1 to the next number.
const float PRECISION = 1.1920929e-7;

// The scan's number, from 1 in the order of an iteration.
const uint SCAN = AHEAD_Y != 0 ? (AHEAD_Y > 0 ? 1u : 2u) : (AHEAD_X > 0 ? 3u : 4u);

// Accepts fronts that are the first to arrive. Between equally early ones whole triangles know
// better, then the flatter front; and those that this scan has brought before may be
// renewed, earlier or later.
void accept(Fronts fronts, inout vec4 time, inout vec4 curvature) {
    bvec4 first = lessThan(fronts.time, time);
    if (WAVEFRONT == 2) {
        uvec4 tag = mix(uvec4(SCAN), uvec4(SCAN | WHOLE), fronts.whole);
        vec4 tagged = vec4(with_tag(fronts.curvature.x, tag.x), with_tag(fronts.curvature.y, tag.y),
                           with_tag(fronts.curvature.z, tag.z), with_tag(fronts.curvature.w, tag.w));
        uvec4 tag_before = floatBitsToUint(curvature) & 15u;
        bvec4 whole_before = greaterThanEqual(tag_before, uvec4(WHOLE));
        bvec4 alike = equal(uvec4(fronts.whole), uvec4(whole_before));
        bvec4 flatter = both(alike, lessThan(tagged, curvature));
        bvec4 knows = either(both(fronts.whole, not(whole_before)), flatter);
        bvec4 preferred = both(equal(fronts.time, time), knows);
        bvec4 renewed = both(bvec4(renews), equal(tag_before & 7u, uvec4(SCAN)));
        first = either(first, both(lessThan(time, vec4(FAR)), either(renewed, preferred)));
        curvature = mix(curvature, tagged, first);
    }
    time = mix(time, fronts.time, first);
}

// Largest difference in units of the last place, for numbers of one sign.
uint units_between(vec4 a, vec4 b) {
    uvec4 units = max(floatBitsToUint(a), floatBitsToUint(b)) - min(floatBitsToUint(a), floatBitsToUint(b));
    return max(max(units.x, units.y), max(units.z, units.w));
}

void main() {
    if (gl_GlobalInvocationID.x >= uint(count)) return;
    ivec2 texel = line * abs(ahead) + (first + int(gl_GlobalInvocationID.x)) * along;
    bool is_curved = WAVEFRONT == 2;

    Behind zero = Behind(vec2(0.0), vec2(0.0), vec2(0.0));
    Behind times = behind(texel, TIME);
    Behind curvatures = zero;
    Behind gaussians = zero;
    if (is_curved) {
        curvatures = behind(texel, CURVATURE);
        gaussians = behind(texel, GAUSSIAN);
    }
    Ends left = Ends(vec4(times.left, times.middle), vec4(curvatures.left, curvatures.middle),
                     vec4(gaussians.left, gaussians.middle));
    Ends middle = Ends(vec4(times.left.y, times.middle, times.right.x),
                       vec4(curvatures.left.y, curvatures.middle, curvatures.right.x),
                       vec4(gaussians.left.y, gaussians.middle, gaussians.right.x));
    Ends right = Ends(vec4(times.middle, times.right), vec4(curvatures.middle, curvatures.right),
                      vec4(gaussians.middle, gaussians.right));

    // First line, points -1 to 2.
    ivec2 point = 2 * texel + max(-ahead, 0);
    vec4 to_left = edge_lengths(point, -ahead - along);
    vec4 to_middle = edge_lengths(point, -ahead);
    vec4 to_right = edge_lengths(point, -ahead + along);
    vec4 base_left = edge_lengths(point - ahead - along, along);
    vec4 base_right = edge_lengths(point - ahead, along);
    Ends line1 = Ends(first_line_old(texel, TIME), vec4(0.0), vec4(0.0));
    if (is_curved) {
        line1.curvature = first_line_old(texel, CURVATURE);
        line1.gaussian = first_line_old(texel, GAUSSIAN);
    }
    vec4 g1 = line1.gaussian;
    accept(earlier(update(left, middle, g1, to_left, to_middle, base_left),
                   update(middle, right, g1, to_middle, to_right, base_right)),
           line1.time, line1.curvature);

    // Second line, points 0 and 1: left triangles in xy, right triangles in zw.
    ivec2 next = point + ahead;
    vec2 sides = vec2(edge_length(next, -ahead), edge_length(next + along, -ahead));
    vec4 l1 = vec4(edge_length(next, -ahead - along), edge_length(next + along, -ahead - along), sides);
    vec4 l2 = vec4(sides, edge_length(next, -ahead + along), edge_length(next + along, -ahead + along));
    vec4 base = vec4(edge_length(point - along, along), edge_length(point, along),
                     edge_length(point, along), edge_length(point + along, along));
    Ends near = Ends(line1.time.xyyz, line1.curvature.xyyz, line1.gaussian.xyyz);
    Ends beyond = Ends(line1.time.yzzw, line1.curvature.yzzw, line1.gaussian.yzzw);
    vec4 old = imageLoad(old_fronts, ivec3(texel, TIME));
    vec4 old_curvature = vec4(0.0);
    vec2 g2 = vec2(0.0);
    if (is_curved) {
        old_curvature = imageLoad(old_fronts, ivec3(texel, CURVATURE));
        g2 = second_line(imageLoad(old_fronts, ivec3(texel, GAUSSIAN)), ahead);
    }
    Fronts sided = update(near, beyond, g2.xyxy, l1, l2, base);
    Fronts from_right = Fronts(sided.time.zwzw, sided.curvature.zwzw, sided.whole.zwzw);
    vec4 line2 = second_line(old, ahead).xyxy;
    vec4 line2_curvature = second_line(old_curvature, ahead).xyxy;
    accept(earlier(sided, from_right), line2, line2_curvature);

    vec4 new = texel_of(line1.time.yz, line2.xy, ahead);
    imageStore(new_fronts, ivec3(texel, TIME), new);
    vec4 new_curvature = texel_of(line1.curvature.yz, line2_curvature.xy, ahead);
    if (is_curved) imageStore(new_fronts, ivec3(texel, CURVATURE), new_curvature);

    uint change = units_between(old, new);
    if (is_curved) {
        vec4 bends = abs(new_curvature - old_curvature) * new;
        float bend = max(max(bends.x, bends.y), max(bends.z, bends.w)) * CURVATURE_COUNTS;
        change = max(change, uint(min(bend / PRECISION, 4e9)));
    }
    if (change > 0u) atomicMax(residual, change);
}
