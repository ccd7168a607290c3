// A block of lines of texels of a rotated raster scan (paper, section 5.3 and figure 3, second
// row): rows for the scans down and up, columns for those right and left.
// One invocation is one texel of each line. Its first line of points is updated from the line
// behind; its second from its first, for which the two neighbouring points of the first line are
// computed here again. Between lines of a block, neighbours pass their results on in shared
// memory. At both ends of a workgroup the results go wrong by one texel a line, for want of a
// neighbour; these texels are computed by the workgroup beside it too, which writes them.
// Include after update.glsl and front.glsl. Twin: src/cpu/twins/scan_in_turn.rs.
//
// The including shader defines
//     ivec3 place_of(ivec2 texel, int layer)            in the images of fronts
//     bool renews_fronts()                              whether fronts are renewed
//     void note_change(uint change)                     of a front, in units of the last place
//     bool passes(ivec2 point, ivec2 ahead)             whether the scan gets to a point's line
//     void note_moved(uint moved, uint beside_holes, ivec2 texel)
//                                                       in which lines, bit by bit from that of the
//                                                       texel on, a front has changed at all, and in
//                                                       which of them at a point that lacks an edge
//     int LINES                                         most lines of texels in a block
// and, for fronts with anchors, WITH_ANCHORS and what anchored.glsl asks for of metric and sources.

// The scan's direction: one of the four unit steps.
layout(constant_id = 0) const int AHEAD_X = 0;
layout(constant_id = 1) const int AHEAD_Y = 1;

// The image that the scan writes is bound twice, so that reads of the line behind and writes of
// this line can be told apart.
layout(set = 0, binding = 0, rgba32f) uniform readonly restrict image2D edges;
layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2D gaussians;
layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray old_fronts;
layout(set = 0, binding = 3, rgba32f) uniform readonly image2DArray fronts_behind;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2DArray new_fronts;

layout(push_constant) uniform Block {
    int line;  // the first row or column of texels in the order of the scan
    int lines; // how many
    int first; // the first texel visited in each
    int count; // how many
    int last;  // the last texel of a line of the grid
    int pitch; // blocks of a scan: see blocks.glsl
    int note;  // number of the dispatch in the recording, for profiles; or negative
};

const ivec2 ahead = ivec2(AHEAD_X, AHEAD_Y);
const ivec2 along = ivec2(AHEAD_Y * AHEAD_Y, AHEAD_X * AHEAD_X);
// The scan's number, from 1 in the order of an iteration.
const uint SCAN = AHEAD_Y != 0 ? (AHEAD_Y > 0 ? 1u : 2u) : (AHEAD_X > 0 ? 3u : 4u);
// Texels at each end of a workgroup that another one writes.
const int HALO = LINES - 1;
// Arrival times and curvatures of the line of points just updated, in turns, for the neighbours.
shared vec4 passed[2][gl_WorkGroupSize.x];

bool differ(vec4 a, vec4 b) {
    return any(notEqual(floatBitsToUint(a), floatBitsToUint(b)));
}

// The line of points before the texel's, at points -2 to 3; its own are 0 and 1.
struct Behind {
    vec2 left, middle, right;
};

float edge_length(ivec2 point, ivec2 step) {
    bool here = stored_here(step);
    return stored_length(imageLoad(edges, here ? point : point + step), here ? step : -step);
}

// Edge lengths from four points in a row, the second being this one.
vec4 edge_lengths(ivec2 point, ivec2 step) {
    return vec4(edge_length(point - along, step), edge_length(point, step),
                edge_length(point + along, step), edge_length(point + 2 * along, step));
}

// A layer at points -1 to 2 of the texel's first line.
vec4 first_line_old(ivec2 texel, int layer) {
    ivec3 at = place_of(texel, layer);
    ivec3 side = ivec3(along, 0);
    return vec4(first_line(imageLoad(old_fronts, at - side), ahead).y,
                first_line(imageLoad(old_fronts, at), ahead),
                first_line(imageLoad(old_fronts, at + side), ahead).x);
}

Behind layer_behind(ivec2 texel, int layer) {
    ivec3 at = place_of(texel - ahead, layer);
    ivec3 side = ivec3(along, 0);
    return Behind(second_line(imageLoad(fronts_behind, at - side), ahead),
                  second_line(imageLoad(fronts_behind, at), ahead),
                  second_line(imageLoad(fronts_behind, at + side), ahead));
}

Behind gaussians_behind(ivec2 texel) {
    ivec2 at = texel - ahead;
    return Behind(second_line(imageLoad(gaussians, at - along), ahead),
                  second_line(imageLoad(gaussians, at), ahead),
                  second_line(imageLoad(gaussians, at + along), ahead));
}

#ifdef WITH_ANCHORS
// Behind the block lines are as this scan has left them, in it and ahead as they were before.
vec2 front_at(ivec2 point) {
    ivec2 texel = point / 2;
    ivec2 way = texel * ahead;
    bool is_behind = way.x + way.y < line * (AHEAD_X + AHEAD_Y);
    ivec3 time_at = place_of(texel, TIME);
    ivec3 held_at = place_of(texel, CURVATURE);
    vec4 times = is_behind ? imageLoad(fronts_behind, time_at) : imageLoad(old_fronts, time_at);
    vec4 held = is_behind ? imageLoad(fronts_behind, held_at) : imageLoad(old_fronts, held_at);
    int i = 2 * (point.y & 1) + (point.x & 1);
    return vec2(times[i], held[i]);
}

float gaussian_at(ivec2 point) {
    return imageLoad(gaussians, point / 2)[2 * (point.y & 1) + (point.x & 1)];
}

int points_in_row() {
    return imageSize(edges).x;
}

#include "anchored.glsl"
#endif

void scan_block() {
    int lane = int(gl_LocalInvocationID.x);
    int place = int(gl_WorkGroupID.x) * (int(gl_WorkGroupSize.x) - 2 * HALO) + lane - HALO;
    bool writes = lane >= HALO && lane < int(gl_WorkGroupSize.x) - HALO && place < count;
    // Beyond the grid a texel is computed again: no edge leads there.
    place = min(first + place, last);
    place = max(place, BORDER);
    // Neighbours' lanes; the outermost have none, and what they compute is not written.
    int before = max(lane - 1, 0);
    int beyond = min(lane + 1, int(gl_WorkGroupSize.x) - 1);
    bool may_renew = renews_fronts();
    Behind zero = Behind(vec2(0.0), vec2(0.0), vec2(0.0));
    Behind times = zero;
    Behind curvatures = zero;
    Behind bends = zero;
    uint change = 0u;
    uint moved = 0u;
    uint beside_holes = 0u;

    for (int k = 0; k < LINES; k++) {
        if (k >= lines) break;
        int number = line + k * (AHEAD_X + AHEAD_Y);
        ivec2 texel = number * abs(ahead) + place * along;
        if (k == 0) {
            times = layer_behind(texel, TIME);
            if (HAS_TWO_LAYERS) curvatures = layer_behind(texel, CURVATURE);
        } else {
            barrier();
            vec4 left = passed[(k - 1) & 1][before];
            vec4 right = passed[(k - 1) & 1][beyond];
            times.left = left.xy;
            times.right = right.xy;
            curvatures.left = left.zw;
            curvatures.right = right.zw;
        }
        if (HAS_TWO_LAYERS) bends = gaussians_behind(texel);
        Ends left = Ends(vec4(times.left, times.middle), vec4(curvatures.left, curvatures.middle),
                         vec4(bends.left, bends.middle));
        Ends middle = Ends(vec4(times.left.y, times.middle, times.right.x),
                           vec4(curvatures.left.y, curvatures.middle, curvatures.right.x),
                           vec4(bends.left.y, bends.middle, bends.right.x));
        Ends right = Ends(vec4(times.middle, times.right), vec4(curvatures.middle, curvatures.right),
                          vec4(bends.middle, bends.right));

        // First line, points -1 to 2.
        ivec2 point = 2 * texel + max(-ahead, 0);
        vec4 to_left = edge_lengths(point, -ahead - along);
        vec4 to_middle = edge_lengths(point, -ahead);
        vec4 to_right = edge_lengths(point, -ahead + along);
        vec4 base_left = edge_lengths(point - ahead - along, along);
        vec4 base_right = edge_lengths(point - ahead, along);
        Ends line1 = Ends(first_line_old(texel, TIME), vec4(0.0), vec4(0.0));
        vec4 own_gaussian = vec4(0.0);
        if (HAS_TWO_LAYERS) {
            line1.curvature = first_line_old(texel, CURVATURE);
            own_gaussian = imageLoad(gaussians, texel);
            line1.gaussian = vec4(first_line(imageLoad(gaussians, texel - along), ahead).y,
                                  first_line(own_gaussian, ahead),
                                  first_line(imageLoad(gaussians, texel + along), ahead).x);
        }
        vec4 g1 = line1.gaussian;
        // Second line, points 0 and 1: left triangles in xy, right triangles in zw.
        ivec2 next = point + ahead;
        vec2 sides = vec2(edge_length(next, -ahead), edge_length(next + along, -ahead));
        vec4 l1 = vec4(edge_length(next, -ahead - along), edge_length(next + along, -ahead - along),
                       sides);
        vec4 l2 = vec4(sides, edge_length(next, -ahead + along),
                       edge_length(next + along, -ahead + along));
        vec4 old = imageLoad(old_fronts, place_of(texel, TIME));
        vec4 old_curvature = vec4(0.0);
        if (HAS_TWO_LAYERS) old_curvature = imageLoad(old_fronts, place_of(texel, CURVATURE));
        vec4 line2 = second_line(old, ahead).xyxy;
        vec4 line2_curvature = second_line(old_curvature, ahead).xyxy;

#ifdef WITH_ANCHORS
        if (HAS_ANCHORS) {
            // A loop, since drivers are slow to compile the same code twice over.
            for (int half_of = 0; half_of < 2; half_of++) {
                ivec2 at = half_of == 0 ? point : next;
                if (!passes(at, ahead)) continue;
                Sight sight = Sight(Ends[](left, middle, right), vec4[](to_left, to_middle, to_right));
                Places places = Places(point - along, along, 2 * along, ahead, along);
                vec4 time = line1.time;
                vec4 held = line1.curvature;
                if (half_of == 1) {
                    sight = sight_of_two(line1, l1, l2);
                    places = Places(next, along, ivec2(0), ahead, along);
                    time = line2;
                    held = line2_curvature;
                }
                accept(ways_to(sight, places, half_of == 0 ? 15u : 3u, SCAN, may_renew, time, held),
                       SCAN, may_renew, time, held);
                if (half_of == 0) {
                    line1.time = time;
                    line1.curvature = held;
                } else {
                    line2 = time;
                    line2_curvature = held;
                }
            }
        } else
#endif
        {
            if (passes(point, ahead)) {
                bvec4 alone = are_alone(to_middle);
                Fronts fronts =
                    earlier(update(left, middle, g1, to_left, to_middle, base_left, alone),
                            update(middle, right, g1, to_middle, to_right, base_right, alone));
                accept(fronts, SCAN, may_renew, line1.time, line1.curvature);
            }
            if (passes(next, ahead)) {
                vec2 g2 = second_line(own_gaussian, ahead);
                vec4 base = vec4(edge_length(point - along, along), edge_length(point, along),
                                 edge_length(point, along), edge_length(point + along, along));
                Ends near = Ends(line1.time.xyyz, line1.curvature.xyyz, line1.gaussian.xyyz);
                Ends far = Ends(line1.time.yzzw, line1.curvature.yzzw, line1.gaussian.yzzw);
                bvec4 alone = are_alone(sides.xyxy);
                accept(of_sides(update(near, far, g2.xyxy, l1, l2, base, alone)), SCAN, may_renew,
                       line2, line2_curvature);
            }
        }

        times.middle = line2.xy;
        curvatures.middle = line2_curvature.xy;
        passed[k & 1][lane] = vec4(line2.xy, line2_curvature.xy);
        if (writes) {
            vec4 new = texel_of(line1.time.yz, line2.xy, ahead);
            vec4 new_curvature = texel_of(line1.curvature.yz, line2_curvature.xy, ahead);
            imageStore(new_fronts, place_of(texel, TIME), new);
            if (HAS_TWO_LAYERS) imageStore(new_fronts, place_of(texel, CURVATURE), new_curvature);
            change = max(change, change_of(old, new, old_curvature, new_curvature));
            if (differ(old, new) || differ(old_curvature, new_curvature)) {
                moved |= 1u << k;
                uvec4 tags = floatBitsToUint(own_gaussian) & 15u;
                if (any(equal(tags, uvec4(1u)))) beside_holes |= 1u << k;
            }
        }
    }
    if (change > 0u) note_change(change);
    if (moved != 0u) note_moved(moved, beside_holes, line * abs(ahead) + place * along);
}
