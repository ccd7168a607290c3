// Scans a block of lines of texels in a rotated raster scan (paper, section 5.3 and figure 3, second row).
// Lines are rows for the scans down and up, and columns for the scans right and left.
//
// One invocation is one texel of each line. It updates the texel's first line of points from the line behind.
// It updates the second line from the first. For that it also computes the two neighbouring points of the
// first line. Between lines of a block, neighbours exchange their results in shared memory. At both ends of a
// workgroup a neighbour is missing, so the results of one more texel become invalid with each line. The
// workgroup beside it computes these texels too, and writes them.
//
// Twin: crates/cpu/src/twins/scan.rs.
//
// The including shader defines
//     ivec3 place_of(ivec2 texel, int layer)            texel and layer in the images of fronts
//     bool renews_fronts()                              whether fronts are renewed
//     void note_change(uint change)                     records a change, in units of the last place
//     bool passes(ivec2 point, ivec2 ahead)             whether the scan visits a point's line
//     void note_moved(uint moved, uint further, ivec2 texel)
//                                                       records the lines in which a front has changed
//                                                       at all. Bit 0 is the line of `texel`. `further`
//                                                       has the lines in which such a point sees points
//                                                       beyond its neighbours, or may be seen from there:
//                                                       with anchors a point that lacks an edge,
//                                                       otherwise a point of an obtuse triangle
//     int LINES                                         largest number of lines of texels in a block
//     int PAIRS                                         whether the opposite scan is at work in the other half
//                                                       of the grid at the same time
// and WITH_ANCHORS if fronts may have anchors.

// Direction of the scan: one of the four unit steps.
layout(constant_id = 0) const int AHEAD_X = 0;
layout(constant_id = 1) const int AHEAD_Y = 1;

#include "update/wavefront.glsl"
#include "shared/edge_image.glsl"
#include "shared/surface_image.glsl"
#include "shared/groups.glsl"

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray old_fronts;
// This image is read on the line behind the block, which an earlier dispatch has written. For the parts of
// obtuse triangles it is also read on lines of the block that this workgroup has written. It is not read
// where the opposite scan is at work at the same time.
layout(set = 2, binding = 0, rgba32f) uniform restrict coherent image2DArray new_fronts;

layout(push_constant) uniform Block {
    int line;  // first row or column of texels, in the order of the scan
    int lines; // number of lines, in one block or in several
    int first; // first texel visited in each line
    int count; // number of texels visited in each line
    int last;  // last texel of a line of the grid
    int pitch; // number of blocks of a scan, see blocks.glsl
    int note;  // number of the first block in the recording, for profiles, or negative
    int in_turn; // whether one workgroup visits several blocks in turn, and skips those that are not due
    int middle; // with PAIRS the first row or column of texels of the grid's last half
};

// First line of the block, and its number of lines.
int block_line;
int block_lines;

const ivec2 ahead = ivec2(AHEAD_X, AHEAD_Y);
const ivec2 along = ivec2(AHEAD_Y * AHEAD_Y, AHEAD_X * AHEAD_X);
// Number of the scan, from 1 in the order of an iteration.
const uint SCAN = AHEAD_Y != 0 ? (AHEAD_Y > 0 ? 1u : 2u) : (AHEAD_X > 0 ? 3u : 4u);
// Number of texels at each end of a workgroup that another workgroup writes.
const int HALO = LINES - 1;
// Fronts of the line of points just updated, for the neighbours. Two buffers alternate.
shared vec4 passed[2][gl_WorkGroupSize.x];

bool differ(vec4 a, vec4 b) {
    return any(notEqual(floatBitsToUint(a), floatBitsToUint(b)));
}

// Values on the line of points behind the texel's first line, at points -2 to 3. The texel's own points have
// the places 0 and 1.
struct Behind {
    vec2 left, middle, right;
};

// Returns the lengths of the edges that lead along `step` from four points in a line, of which `point` is the
// second.
vec4 edge_lengths(ivec2 point, ivec2 step) {
    return vec4(edge_length(point - along, step), edge_length(point, step),
                edge_length(point + along, step), edge_length(point + 2 * along, step));
}

// Returns a layer at points -1 to 2 of the texel's first line.
vec4 first_line_old(ivec2 texel, int layer) {
    ivec3 at = place_of(texel, layer);
    ivec3 side = ivec3(along, 0);
    return vec4(first_line(imageLoad(old_fronts, at - side), ahead).y,
                first_line(imageLoad(old_fronts, at), ahead),
                first_line(imageLoad(old_fronts, at + side), ahead).x);
}

// Returns whether a texel lies in the half of the grid in which the opposite scan is at work. Fronts there are
// read as they were before both scans, since no dispatch may depend on how far the other one is.
bool is_across(ivec2 texel) {
    int line_of_texel = AHEAD_Y != 0 ? texel.y : texel.x;
    return PAIRS != 0 && (line_of_texel < middle) != (block_line < middle);
}

Behind second_lines(vec4 left, vec4 middle, vec4 right) {
    return Behind(second_line(left, ahead), second_line(middle, ahead), second_line(right, ahead));
}

// Returns a layer on the line of points behind a texel.
Behind layer_behind(ivec2 texel, int layer) {
    ivec3 at = place_of(texel - ahead, layer);
    ivec3 side = ivec3(along, 0);
    if (is_across(texel - ahead)) {
        return second_lines(imageLoad(old_fronts, at - side), imageLoad(old_fronts, at), imageLoad(old_fronts, at + side));
    }
    return second_lines(imageLoad(new_fronts, at - side), imageLoad(new_fronts, at), imageLoad(new_fronts, at + side));
}

Behind surface_behind(ivec2 texel) {
    ivec2 at = texel - ahead;
    return second_lines(surface_of(at - along), surface_of(at), surface_of(at + along));
}

Behind slowness_behind(ivec2 texel) {
    ivec2 at = texel - ahead;
    return second_lines(slowness_of(at - along), slowness_of(at), slowness_of(at + along));
}

// The two lines of points that a scan updates in a texel.
struct Lines {
    EndFronts first; // points -1 to 2
    vec4 second; // points 0 and 1, repeated
    vec4 second_carried;
};

// Fronts of the first line of points in the line of texels being updated, for the neighbours.
shared vec4 begun[gl_WorkGroupSize.x];
// Number of lines of texels of the block that are done, and whether the first line of points in the next line
// of texels is done.
int lines_done = 0;
bool has_begun = false;

// Returns the first texel of a line that this workgroup computes.
int first_of_workgroup() {
    return first + int(group_number().x) * (int(gl_WorkGroupSize.x) - 2 * HALO) - HALO;
}

// Returns the front at a point. Behind the block, this is the front that the scan has left, except in the
// half in which the opposite scan is at work. On lines of the block that are done, it is also the front that
// the scan has left, at texels that this workgroup writes. Everywhere else it is the front from before the
// scan.
vec2 front_at(ivec2 point) {
    ivec2 texel = texel_of(point);
    int lines_on = lines_ahead(texel, ahead) - block_line * (AHEAD_X + AHEAD_Y);
    int place = lines_ahead(texel, along);
    int other = place - first_of_workgroup();
    bool is_own = other >= HALO && other < int(gl_WorkGroupSize.x) - HALO && place < first + count;
    ivec2 in_texel = abs(point - first_point_of_line(texel, ahead));
    if (has_begun && is_own && lines_on == lines_done && in_texel * abs(ahead) == ivec2(0)) {
        vec4 fronts = begun[other];
        bool is_second = in_texel != ivec2(0);
        return is_second ? fronts.yw : fronts.xz;
    }
    bool is_behind = lines_on < (is_own ? lines_done : 0) && !is_across(texel);
    ivec3 time_at = place_of(texel, TIME);
    vec4 times = is_behind ? imageLoad(new_fronts, time_at) : imageLoad(old_fronts, time_at);
    vec4 carried = vec4(0.0);
    if (CARRIES) {
        ivec3 carried_at = place_of(texel, CARRIED);
        carried = is_behind ? imageLoad(new_fronts, carried_at) : imageLoad(old_fronts, carried_at);
    }
    int i = component_of(point);
    return vec2(times[i], carried[i]);
}

#include "update/splits.glsl"

#ifdef WITH_ANCHORS
#include "update/anchored_ways.glsl"

// Updates both lines of a texel by paths to anchors. `behind` has the neighbours behind the texel's first
// line. `l1` and `l2` are the lengths of the edges from its second line to the first.
void follow_ways(ivec2 point, NeighboursBehind behind, vec4 l1, vec4 l2, bool may_renew, inout Lines own) {
    // This is a loop, since drivers are slow to compile the same code twice.
    for (int half_of = 0; half_of < 2; half_of++) {
        ivec2 at = half_of == 0 ? point : point + ahead;
        if (!passes(at, ahead)) continue;
        NeighboursBehind sight = behind;
        Places places = Places(point - along, along, 2 * along, ahead, along);
        vec4 time = own.first.time;
        vec4 carried = own.first.carried;
        if (half_of == 1) {
            sight = sight_of_pair(own.first, l1, l2);
            places = Places(at, along, ivec2(0), ahead, along);
            time = own.second;
            carried = own.second_carried;
        }
        accept(ways_to(sight, places, half_of == 0 ? 15u : 3u, SCAN, may_renew, time, carried),
               SCAN, may_renew, time, carried);
        if (half_of == 0) {
            own.first.time = time;
            own.first.carried = carried;
        } else {
            own.second = time;
            own.second_carried = carried;
        }
    }
}
#endif

// Updates both lines of a texel through triangles. `base_left` and `base_right` are the bases of the first
// line's triangles. Returns whether any triangle is obtuse.
bool pass_triangles(ivec2 point, NeighboursBehind behind, vec4 base_left, vec4 base_right, vec4 l1, vec4 l2,
                    vec2 surface, vec2 slowness, bool may_renew, inout Lines own) {
    bool any_obtuse = false;
    if (passes(point, ahead)) {
        vec4 own_slowness = own.first.slowness;
        Places four = Places(point - along, along, 2 * along, ahead, along);
        Fronts fronts = update_four(behind, own.first.surface, own_slowness, base_left, base_right);
        bvec4 left = are_obtuse_at_x0(behind.ends[0], behind.ends[1], own_slowness, behind.edges[0], behind.edges[1], base_left);
        bvec4 right = are_obtuse_at_x0(behind.ends[1], behind.ends[2], own_slowness, behind.edges[1], behind.edges[2], base_right);
        any_obtuse = any(either(left, right));
        add_parts(four, left, right, fronts);
        accept(fronts, SCAN, may_renew, own.first.time, own.first.carried);
    }
    if (SPLITS != 0) {
        begun[gl_LocalInvocationID.x] = vec4(own.first.time.yz, own.first.carried.yz);
        has_begun = true;
        barrier();
    }
    if (passes(point + ahead, ahead)) {
        vec4 base = vec4(edge_length(point - along, along), edge_length(point, along),
                         edge_length(point, along), edge_length(point + along, along));
        Places pair = Places(point + ahead, along, ivec2(0), ahead, along);
        Fronts fronts = update_pair(own.first, surface, slowness, l1, l2, base);
        bvec4 obtuse = are_obtuse_in_pair(own.first, slowness, l1, l2, base);
        any_obtuse = any_obtuse || any(obtuse);
        add_parts(pair, obtuse, obtuse.zwxy, fronts);
        accept(fronts, SCAN, may_renew, own.second, own.second_carried);
    }
    return any_obtuse;
}

// Scans the block from its first line to its last.
void scan_block() {
    int lane = int(gl_LocalInvocationID.x);
    int place = int(group_number().x) * (int(gl_WorkGroupSize.x) - 2 * HALO) + lane - HALO;
    bool writes = lane >= HALO && lane < int(gl_WorkGroupSize.x) - HALO && place < count;
    // Beyond the grid, the nearest texel is computed again. No edge leads there.
    place = texel_in_line(first + place, last);
    // Lanes of the neighbours. The outermost lanes lack one, and their results are not written.
    int before = max(lane - 1, 0);
    int beyond = min(lane + 1, int(gl_WorkGroupSize.x) - 1);
    bool may_renew = renews_fronts();
    Behind zero = Behind(vec2(0.0), vec2(0.0), vec2(0.0));
    Behind times = zero;
    Behind carried = zero;
    Behind surface = zero;
    Behind slowness = zero;
    uint change = 0u;
    uint moved = 0u;
    uint further = 0u;

    for (int k = 0; k < LINES; k++) {
        if (k >= block_lines) break;
        int number = block_line + k * (AHEAD_X + AHEAD_Y);
        ivec2 texel = in_line(number, place, ahead, along);
        lines_done = k;
        has_begun = false;
        if (SPLITS != 0) memoryBarrierImage();
        if (k == 0) {
            times = layer_behind(texel, TIME);
            if (CARRIES) carried = layer_behind(texel, CARRIED);
        } else {
            barrier();
            vec4 left = passed[(k - 1) & 1][before];
            vec4 right = passed[(k - 1) & 1][beyond];
            times.left = left.xy;
            times.right = right.xy;
            carried.left = left.zw;
            carried.right = right.zw;
        }
        if (CARRIES) surface = surface_behind(texel);
        if (SLOWED != 0) slowness = slowness_behind(texel);
        ivec2 point = first_point_of_line(texel, ahead);
        NeighboursBehind behind;
        behind.ends[0] = EndFronts(vec4(times.left, times.middle), vec4(carried.left, carried.middle),
                              vec4(surface.left, surface.middle), vec4(slowness.left, slowness.middle));
        behind.ends[1] = EndFronts(vec4(times.left.y, times.middle, times.right.x),
                              vec4(carried.left.y, carried.middle, carried.right.x),
                              vec4(surface.left.y, surface.middle, surface.right.x),
                              vec4(slowness.left.y, slowness.middle, slowness.right.x));
        behind.ends[2] = EndFronts(vec4(times.middle, times.right), vec4(carried.middle, carried.right),
                              vec4(surface.middle, surface.right), vec4(slowness.middle, slowness.right));
        behind.edges[0] = edge_lengths(point, -ahead - along);
        behind.edges[1] = edge_lengths(point, -ahead);
        behind.edges[2] = edge_lengths(point, -ahead + along);
        vec4 base_left = edge_lengths(point - ahead - along, along);
        vec4 base_right = edge_lengths(point - ahead, along);

        Lines own = Lines(EndFronts(first_line_old(texel, TIME), vec4(0.0), vec4(0.0), vec4(0.0)), vec4(0.0), vec4(0.0));
        vec2 second_slowness = vec2(0.0);
        if (SLOWED != 0) {
            vec4 own_slowness = slowness_of(texel);
            own.first.slowness = vec4(first_line(slowness_of(texel - along), ahead).y,
                                      first_line(own_slowness, ahead),
                                      first_line(slowness_of(texel + along), ahead).x);
            second_slowness = second_line(own_slowness, ahead);
        }
        vec4 own_surface = vec4(0.0);
        if (CARRIES) {
            own.first.carried = first_line_old(texel, CARRIED);
            own_surface = surface_of(texel);
            own.first.surface = vec4(first_line(surface_of(texel - along), ahead).y,
                                     first_line(own_surface, ahead),
                                     first_line(surface_of(texel + along), ahead).x);
        }
        // The edges from points 0 and 1 of the second line. Left triangles are in xy, right triangles in zw.
        ivec2 next = point + ahead;
        vec2 sides = vec2(edge_length(next, -ahead), edge_length(next + along, -ahead));
        vec4 l1 = vec4(edge_length(next, -ahead - along), edge_length(next + along, -ahead - along),
                       sides);
        vec4 l2 = vec4(sides, edge_length(next, -ahead + along),
                       edge_length(next + along, -ahead + along));
        vec4 old = imageLoad(old_fronts, place_of(texel, TIME));
        vec4 old_carried = vec4(0.0);
        if (CARRIES) old_carried = imageLoad(old_fronts, place_of(texel, CARRIED));
        own.second = second_line(old, ahead).xyxy;
        own.second_carried = second_line(old_carried, ahead).xyxy;

        bool sees_further = any(notEqual(tags_of(own_surface) & LACKING, uvec4(0u)));
#ifdef WITH_ANCHORS
        if (HAS_ANCHORS) {
            follow_ways(point, behind, l1, l2, may_renew, own);
        } else
#endif
        {
            sees_further = pass_triangles(point, behind, base_left, base_right, l1, l2, second_line(own_surface, ahead),
                                          second_slowness, may_renew, own);
        }

        times.middle = own.second.xy;
        carried.middle = own.second_carried.xy;
        passed[k & 1][lane] = vec4(own.second.xy, own.second_carried.xy);
        if (writes) {
            vec4 new = texel_of_lines(own.first.time.yz, own.second.xy, ahead);
            vec4 new_carried = texel_of_lines(own.first.carried.yz, own.second_carried.xy, ahead);
            imageStore(new_fronts, place_of(texel, TIME), new);
            if (CARRIES) imageStore(new_fronts, place_of(texel, CARRIED), new_carried);
            change = max(change, change_of(old, new, old_carried, new_carried));
            bool matters = any(lessThanEqual(min(old, new), vec4(latest)));
            if (matters && (differ(old, new) || differ(old_carried, new_carried))) {
                moved |= 1u << k;
                if (sees_further) further |= 1u << k;
            }
        }
    }
    if (change > 0u) note_change(change);
    if (moved != 0u) note_moved(moved, further, in_line(block_line, place, ahead, along));
}
