#version 450
#extension GL_GOOGLE_include_directive : require
// One round of the tiles on its list: iterations of four rotated scans inside each tile, in shared
// memory, the points around it standing still; then the tiles beside a side that has changed are
// put on the list of the next round.
// One workgroup is one tile; one invocation is two neighbouring points of a line of one of the four
// scans, which run at once on copies of their own. Each tile's fronts lie in one of the two images
// and are written to the other, so that a round does not depend on the order of its workgroups.
// Twin: src/cpu/twins/tile_rounds.rs.

#include "constants.glsl"
#include "texel.glsl"
#include "update.glsl"
#include "front.glsl"
#include "progress.glsl"
#include "tiles.glsl"
#include "anchors.glsl"

layout(local_size_x_id = 3, local_size_y = 4) in;

// Iterations inside a tile, at most.
layout(constant_id = 4) const int INNER = 4;

layout(set = 0, binding = 0, rgba32f) uniform readonly restrict image2D edges;
layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2D gaussians;
// Each image is bound twice, so that reads and writes can be told apart.
layout(set = 0, binding = 2, rgba32f) uniform readonly image2DArray fronts_1;
layout(set = 0, binding = 3, rgba32f) uniform readonly image2DArray fronts_0;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2DArray new_fronts_0;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2DArray new_fronts_1;

layout(push_constant) uniform Round {
    ivec2 texels; // columns and rows of texels, without the border
    uint round;
};

// A tile with the points around it that its own see.
const int SIDE = TILE + 2;
const int AREA = SIDE * SIDE;
const int OWN_TEXELS = TEXELS * TEXELS;
const int INVOCATIONS = 2 * TILE;
// Texels of the tile for each invocation.
const int SHARE = (OWN_TEXELS + INVOCATIONS - 1) / INVOCATIONS;

shared vec4 lengths[AREA];
shared float bends[HAS_TWO_LAYERS ? AREA : 1];
// Four copies, one for each scan.
shared float times[4 * AREA];
shared float curvatures[HAS_TWO_LAYERS ? 4 * AREA : 1];
shared uint change;
shared uint border_change;
shared uint woken; // sides beyond which the next round visits a tile: 3 x 3 bits

int spot(ivec2 at) {
    return at.y * SIDE + at.x;
}

float edge_length(ivec2 at, ivec2 step) {
    bool here = stored_here(step);
    return stored_length(lengths[spot(here ? at : at + step)], here ? step : -step);
}

// What front_at() is asked for: in which of the copies, while which of its lines is updated, beside a tile
// whose first point in shared memory is `corner`.
int copy_here;
ivec2 line_here;
ivec2 axis_here;
ivec2 corner;

// In and around the tile as the copy has it; beyond, and on the line that is being written, as it was before
// the round.
vec2 front_at(ivec2 point) {
    ivec2 at = point - corner;
    ivec2 from_line = (at - line_here) * axis_here;
    bool is_near = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(SIDE)));
    if (is_near && from_line.x + from_line.y != 0) {
        int from = copy_here * AREA + spot(at);
        return vec2(times[from], curvatures[HAS_TWO_LAYERS ? from : 0]);
    }
    ivec2 texel = point / 2;
    ivec2 tile_grid = tiles_of(texels);
    ivec2 owner = clamp((texel - BORDER) / TEXELS, ivec2(0), tile_grid - 1);
    uint state = atomicOr(tiles[owner.y * tile_grid.x + owner.x], 0u);
    vec4 time;
    vec4 held;
    if (image_before(state, round) == 1u) {
        time = imageLoad(fronts_1, ivec3(texel, TIME));
        held = imageLoad(fronts_1, ivec3(texel, CURVATURE));
    } else {
        time = imageLoad(fronts_0, ivec3(texel, TIME));
        held = imageLoad(fronts_0, ivec3(texel, CURVATURE));
    }
    int i = 2 * (point.y & 1) + (point.x & 1);
    return vec2(time[i], held[i]);
}

float gaussian_at(ivec2 point) {
    return imageLoad(gaussians, point / 2)[2 * (point.y & 1) + (point.x & 1)];
}

int points_in_row() {
    return imageSize(edges).x;
}

#include "anchored.glsl"

void load(ivec2 tile, ivec2 tile_grid) {
    ivec2 first = TEXELS * tile + BORDER - 1; // the texel before the tile's first
    uint state_of_own = atomicOr(tiles[tile.y * tile_grid.x + tile.x], 0u);
    for (uint i = gl_LocalInvocationIndex; i < (TEXELS + 2) * (TEXELS + 2); i += INVOCATIONS) {
        ivec2 in_tile = ivec2(int(i) % (TEXELS + 2), int(i) / (TEXELS + 2));
        ivec2 texel = min(first + in_tile, texels + 2 * BORDER - 1);
        ivec2 owner = clamp((texel - BORDER + TEXELS) / TEXELS - 1, ivec2(0), tile_grid - 1);
        uint state = owner == tile ? state_of_own
                                   : atomicOr(tiles[owner.y * tile_grid.x + owner.x], 0u);
        vec4 time;
        vec4 curvature = vec4(0.0);
        if (image_before(state, round) == 1u) {
            time = imageLoad(fronts_1, ivec3(texel, TIME));
            if (HAS_TWO_LAYERS) curvature = imageLoad(fronts_1, ivec3(texel, CURVATURE));
        } else {
            time = imageLoad(fronts_0, ivec3(texel, TIME));
            if (HAS_TWO_LAYERS) curvature = imageLoad(fronts_0, ivec3(texel, CURVATURE));
        }
        vec4 gaussian = vec4(0.0);
        if (HAS_TWO_LAYERS) gaussian = imageLoad(gaussians, texel);
        for (int j = 0; j < 4; j++) {
            ivec2 at = 2 * in_tile - 1 + ivec2(j & 1, j >> 1);
            if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(SIDE)))) continue;
            for (int copy = 0; copy < 4; copy++) times[copy * AREA + spot(at)] = time[j];
            if (HAS_TWO_LAYERS) {
                for (int copy = 0; copy < 4; copy++) {
                    curvatures[copy * AREA + spot(at)] = curvature[j];
                }
                bends[spot(at)] = gaussian[j];
            }
        }
    }
    ivec2 last = 2 * (texels + 2 * BORDER) - 1;
    for (uint i = gl_LocalInvocationIndex; i < AREA; i += INVOCATIONS) {
        lengths[i] = imageLoad(edges, min(2 * first + 1 + ivec2(int(i) % SIDE, int(i) / SIDE), last));
    }
}

// One line of one scan: points `at` and `at + along`.
void advance(ivec2 at, ivec2 ahead, ivec2 along, int copy, bool may_renew) {
    ivec2 behind = at - ahead;
    ivec2 next = at + along;
    vec4 time_behind;
    vec4 curvature_behind = vec4(0.0);
    vec4 bend_behind = vec4(0.0);
    for (int i = 0; i < 4; i++) {
        int from = spot(behind + (i - 1) * along);
        time_behind[i] = times[copy * AREA + from];
        if (HAS_TWO_LAYERS) {
            curvature_behind[i] = curvatures[copy * AREA + from];
            bend_behind[i] = bends[from];
        }
    }
    // Left triangles in xy, right triangles in zw.
    vec2 sides = vec2(edge_length(at, -ahead), edge_length(next, -ahead));
    vec4 l1 = vec4(edge_length(at, -ahead - along), edge_length(next, -ahead - along), sides);
    vec4 l2 = vec4(sides, edge_length(at, -ahead + along), edge_length(next, -ahead + along));
    int a = copy * AREA + spot(at);
    int b = copy * AREA + spot(next);
    vec4 time = vec2(times[a], times[b]).xyxy;
    vec4 curvature = vec4(0.0);
    if (HAS_TWO_LAYERS) curvature = vec2(curvatures[a], curvatures[b]).xyxy;
    Fronts fronts;
    if (HAS_ANCHORS) {
        copy_here = copy;
        line_here = at;
        axis_here = abs(ahead);
        Sight sight = sight_of_two(Ends(time_behind, curvature_behind, bend_behind), l1, l2);
        Places two = Places(corner + at, along, ivec2(0), ahead, along);
        fronts = ways_to(sight, two, 3u, uint(copy) + 1u, may_renew, time, curvature);
    } else {
        Ends near = Ends(time_behind.xyyz, curvature_behind.xyyz, bend_behind.xyyz);
        Ends far = Ends(time_behind.yzzw, curvature_behind.yzzw, bend_behind.yzzw);
        vec4 bases = vec4(edge_length(behind - along, along), edge_length(behind, along),
                          edge_length(behind + along, along), 0.0);
        vec2 own_bend = HAS_TWO_LAYERS ? vec2(bends[spot(at)], bends[spot(next)]) : vec2(0.0);
        fronts = of_sides(update(near, far, own_bend.xyxy, l1, l2, bases.xyyz, are_alone(sides.xyxy)));
    }
    accept(fronts, uint(copy) + 1u, may_renew, time, curvature);
    times[a] = time.x;
    times[b] = time.y;
    if (HAS_TWO_LAYERS) {
        curvatures[a] = curvature.x;
        curvatures[b] = curvature.y;
    }
}

// Whether of two fronts at one point, each brought by a copy's own scan, the second is kept; the time
// is the earlier one's in any case, but with anchors.
bool is_first(float time, float curvature, float best, float best_curvature) {
    if (HAS_ANCHORS) return is_shorter(time, best);
    if (!together(vec4(best), vec4(time)).x) return time < best;
    bool whole = (floatBitsToUint(curvature) & 15u) >= WHOLE;
    bool best_whole = (floatBitsToUint(best_curvature) & 15u) >= WHOLE;
    return whole != best_whole ? whole : curvature < best_curvature;
}

// Makes the four copies the same again, with the first to arrive at each point.
void merge(ivec2 in_tile, inout vec4 time, inout vec4 curvature) {
    for (int j = 0; j < 4; j++) {
        int at = spot(2 * in_tile + 1 + ivec2(j & 1, j >> 1));
        if (HAS_TWO_LAYERS) {
            bool found = false;
            for (int copy = 0; copy < 4; copy++) {
                float other = times[copy * AREA + at];
                float other_curvature = curvatures[copy * AREA + at];
                // One that the copy's own scan has not brought stands for nothing but the old one; if that has
                // been taken back, none is left.
                if (other >= FAR && !found) {
                    time[j] = other;
                    curvature[j] = other_curvature;
                }
                uint brought_by = floatBitsToUint(other_curvature) & 7u;
                if (brought_by != uint(copy) + 1u || other >= FAR) continue;
                bool second = !found || is_first(other, other_curvature, time[j], curvature[j]);
                if (second) curvature[j] = other_curvature;
                bool keeps = HAS_ANCHORS ? !second : found && !(other < time[j]);
                if (!keeps) time[j] = other;
                found = true;
            }
            for (int copy = 0; copy < 4; copy++) curvatures[copy * AREA + at] = curvature[j];
        } else {
            time[j] = min(min(times[at], times[AREA + at]),
                          min(times[2 * AREA + at], times[3 * AREA + at]));
        }
        for (int copy = 0; copy < 4; copy++) times[copy * AREA + at] = time[j];
    }
}

// The tiles that see a point of this one, as bits of 3 x 3 tiles.
uint sides_of(ivec2 at) {
    uint bits = 0u;
    bool west = at.x < 1;
    bool east = at.x >= TILE - 1;
    if (at.y < 1) bits |= west ? 0xbu : east ? 0x26u : 0x2u;
    if (at.y >= TILE - 1) bits |= west ? 0xc8u : east ? 0x1a0u : 0x80u;
    if (west) bits |= 0x8u;
    if (east) bits |= 0x20u;
    return bits;
}

// The step to one of the 3 x 3 tiles around a tile.
ivec2 neighbour(uint bit) {
    return ivec2(int(bit) % 3, int(bit) / 3) - 1;
}

void main() {
    ivec2 tile_grid = tiles_of(texels);
    uint count = uint(tile_grid.x * tile_grid.y);
    uint number = tiles[(2u + (round & 1u)) * count + gl_WorkGroupID.x];
    ivec2 tile = ivec2(int(number) % tile_grid.x, int(number) / tile_grid.x);
    uint state = atomicOr(tiles[number], 0u);
    bool may_renew = renews != 0u;
    if (gl_LocalInvocationIndex == 0u) {
        woken = 0u;
        border_change = 0u;
    }
    corner = 2 * (TEXELS * tile + BORDER) - 1;
    load(tile, tile_grid);
    barrier();

    vec4 time_before[SHARE];
    vec4 curvature_before[SHARE];
    vec4 time[SHARE];
    vec4 curvature[SHARE];
    for (int k = 0; k < SHARE; k++) {
        int i = int(gl_LocalInvocationIndex) + k * INVOCATIONS;
        if (i >= OWN_TEXELS) break;
        for (int j = 0; j < 4; j++) {
            int at = spot(2 * ivec2(i % TEXELS, i / TEXELS) + 1 + ivec2(j & 1, j >> 1));
            time_before[k][j] = times[at];
            curvature_before[k][j] = HAS_TWO_LAYERS ? curvatures[at] : 0.0;
        }
        time[k] = time_before[k];
        curvature[k] = curvature_before[k];
    }

    int copy = int(gl_LocalInvocationID.y);
    int way = 1 - 2 * (copy & 1);
    ivec2 ahead = copy < 2 ? ivec2(0, way) : ivec2(way, 0);
    ivec2 along = copy < 2 ? ivec2(1, 0) : ivec2(0, 1);
    ivec2 start = (1 + 2 * int(gl_LocalInvocationID.x)) * along
                + (way > 0 ? 1 : TILE) * abs(ahead);
    for (int inner = 0; inner < INNER; inner++) {
        if (gl_LocalInvocationIndex == 0u) change = 0u;
        for (int line = 0; line < TILE; line++) {
            advance(start + line * ahead, ahead, along, copy, may_renew);
            barrier();
        }
        uint own_change = 0u;
        for (int k = 0; k < SHARE; k++) {
            int i = int(gl_LocalInvocationIndex) + k * INVOCATIONS;
            if (i >= OWN_TEXELS) break;
            vec4 old = time[k];
            vec4 old_curvature = curvature[k];
            merge(ivec2(i % TEXELS, i / TEXELS), time[k], curvature[k]);
            own_change = max(own_change, change_of(old, time[k], old_curvature, curvature[k]));
        }
        if (own_change > 0u) atomicMax(change, own_change);
        barrier();
        uint all_change = change;
        barrier();
        if (all_change <= tolerance) break;
    }

    // Nothing waits beyond the border of the grid.
    uint around = 0u;
    for (uint i = 0u; i < 9u; i++) {
        ivec2 other = tile + neighbour(i);
        bool exists = all(greaterThanEqual(other, ivec2(0))) && all(lessThan(other, tile_grid));
        around |= exists ? 1u << i : 0u;
    }
    bool has_reached = false;
    for (int k = 0; k < SHARE; k++) {
        int i = int(gl_LocalInvocationIndex) + k * INVOCATIONS;
        if (i >= OWN_TEXELS) break;
        ivec2 in_tile = ivec2(i % TEXELS, i / TEXELS);
        ivec2 texel = TEXELS * tile + BORDER + in_tile;
        if (any(greaterThanEqual(texel - BORDER, texels))) continue;
        if ((state & 1u) == 0u) {
            imageStore(new_fronts_1, ivec3(texel, TIME), time[k]);
            if (HAS_TWO_LAYERS) imageStore(new_fronts_1, ivec3(texel, CURVATURE), curvature[k]);
        } else {
            imageStore(new_fronts_0, ivec3(texel, TIME), time[k]);
            if (HAS_TWO_LAYERS) imageStore(new_fronts_0, ivec3(texel, CURVATURE), curvature[k]);
        }
        for (int j = 0; j < 4; j++) {
            has_reached = has_reached || (time_before[k][j] >= FAR && time[k][j] < FAR);
            uint sides = around & sides_of(2 * in_tile + ivec2(j & 1, j >> 1));
            if (sides == 0u) continue;
            uint by = change_of(vec4(time_before[k][j]), vec4(time[k][j]),
                                vec4(curvature_before[k][j]), vec4(curvature[k][j]));
            if (by > tolerance) {
                atomicOr(woken, sides);
                atomicMax(border_change, by);
            }
        }
    }
    if (has_reached) atomicOr(reached, 1u);
    barrier();

    uint wakes = woken | (change > tolerance ? 0x10u : 0u);
    if (gl_LocalInvocationIndex == 0u) {
        atomicMax(unsettled[round], max(change, border_change));
        atomicExchange(tiles[number], 2u * (round + 1u) + 1u - (state & 1u));
    }
    if (gl_LocalInvocationIndex < 9u && (wakes >> gl_LocalInvocationIndex & 1u) != 0u) {
        ivec2 other = tile + neighbour(gl_LocalInvocationIndex);
        uint wanted = uint(other.y * tile_grid.x + other.x);
        ENLIST(wanted, round + 1u, count);
    }
}
