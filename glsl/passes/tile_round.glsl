// Runs one round of the tiles on its list. It iterates four rotated scans inside each tile in shared memory,
// while the points around the tile stay fixed. Then it lists tiles for the next round: those that see a changed point
// of this tile, and this tile itself if it has not settled. A tile that is due much later than the first tile is not
// visited, but put on that list again.
//
// Each workgroup visits one tile. It runs four scans at once, each on its own copy of the tile's fronts. The
// invocations of a scan share the points of a line: each has two neighbouring points (tile_pairs.glsl), or with
// WITH_POINTS one (tile_points.glsl). A tile's fronts are read from one of the two images and written to the other, so
// that a round does not depend on the order of its workgroups.
//
// The including shader may define WITH_POINTS, and with it WITH_SHUFFLES. These are macros and not specialization
// constants, since drivers would spend time on code that a constant only disables.
// Twin: crates/cpu/src/twins/tile_round.rs.

#include "update/wavefront.glsl"
#include "shared/edge_image.glsl"
#include "shared/surface_image.glsl"

// Number of points along a side of a tile, and number of texels along it.
layout(constant_id = 5) const int TILE = 16;
const int TEXELS = TILE / 2;

#include "passes/tiles.glsl"

layout(local_size_x_id = 3, local_size_y = 4) in;

// Largest number of iterations inside a tile.
layout(constant_id = 4) const int INNER = 4;

#include "passes/two_images.glsl"

layout(push_constant) uniform Round {
    ivec2 texels; // columns and rows of texels, without the border
    uint round;
};

#include "passes/window.glsl"

#ifdef WITH_POINTS
const int INVOCATIONS = 4 * TILE;
#else
const int INVOCATIONS = 2 * TILE;
#endif
// Largest number of the tile's texels that one invocation handles.
const int SHARE = (OWN_TEXELS + INVOCATIONS - 1) / INVOCATIONS;
// Number of texels in and around the tile, and the largest number of them that one invocation loads.
const int TEXELS_AROUND = (TEXELS + 2) * (TEXELS + 2);
const int LOADS = (TEXELS_AROUND + INVOCATIONS - 1) / INVOCATIONS;

#include "passes/tile_edges.glsl"

shared float surface[CARRIES ? AREA : 1];
shared float slowness[SLOWED != 0 ? AREA : 1];
// Four copies, one for each scan.
shared float times[4 * AREA];
shared float carried[CARRIES ? 4 * AREA : 1];
shared uint tile_number;
shared uint tile_urgency;
shared uint states[9]; // states of the 3 x 3 tiles around this one; outside the grid, the state of the nearest tile
shared uint change;
shared uint border_change;
shared uint woken; // tiles listed for the next round: one bit for each of the 3 x 3 tiles, row by row
shared uint urgencies[9]; // urgencies of these tiles

// Number of the copy of the fronts that front_at() reads.
int copy_here;

// Returns the front at a point: in and around the tile the front of the copy `copy_here`, elsewhere the front before
// the round.
vec2 front_at(ivec2 point) {
    ivec2 at = point - window;
    if (in_grid(at, ivec2(SIDE))) {
        int from = copy_here * AREA + spot(at);
        return vec2(times[from], carried[CARRIES ? from : 0]);
    }
    ivec2 texel = texel_of(point);
    ivec2 tile_grid = tiles_of(texels);
    uint state = atomicOr(tiles[row_major(tile_with(texel, tile_grid), tile_grid.x)], 0u);
    vec4 time;
    vec4 held;
    load_fronts(image_before(state, round) == 1u, texel, time, held);
    return vec2(time[component_of(point)], held[component_of(point)]);
}

#include "update/splits.glsl"
#include "update/anchored_ways.glsl"

// Returns the step from a tile to one of the 3 x 3 tiles around it.
ivec2 neighbour(uint bit) {
    return from_row_major(int(bit), 3) - 1;
}

// Loads the number and urgency of a listed tile into shared memory, and the states of the 3 x 3 tiles around it. Each
// of the first nine invocations loads one state. Other workgroups of this pass may change these values, so they are
// read atomically: barrier() does not order accesses to buffers.
void load_states(uint entry, uint count, ivec2 tile_grid) {
    uint number = atomicOr(tiles[entry], 0u);
    ivec2 tile = from_row_major(int(number), tile_grid.x);
    ivec2 other = clamp(tile + neighbour(gl_LocalInvocationIndex), ivec2(0), tile_grid - 1);
    states[gl_LocalInvocationIndex] = atomicOr(tiles[row_major(other, tile_grid.x)], 0u);
    if (gl_LocalInvocationIndex == 0u) {
        tile_number = number;
        tile_urgency = atomicExchange(tiles[urgency_at(number, round, count)], 0u);
    }
}

// Returns the i-th of the texels in and around a tile, counted from the tile's first texel.
ivec2 texel_around(int i) {
    return from_row_major(i, TEXELS + 2) - 1;
}

// The front, the surface value and the slowness at each point of a texel.
struct Held {
    vec4 time, carried, surface, slowness;
};

// Returns the values at the i-th of the texels in and around a tile.
Held held_at(int i, ivec2 tile, ivec2 tile_grid) {
    ivec2 texel = min(first_texel_of(tile) + texel_around(i), last_texel(texels));
    uint state = states[row_major(tile_with(texel, tile_grid) - tile + 1, 3)];
    Held held = Held(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    load_fronts(image_before(state, round) == 1u, texel, held.time, held.carried);
    if (CARRIES) held.surface = surface_of(texel);
    if (SLOWED != 0) held.slowness = slowness_of(texel);
    return held;
}

// Loads a tile and the points around it into shared memory. An invocation issues all its reads before it uses the
// first of them, so that it waits only once.
void load(ivec2 tile, ivec2 tile_grid) {
    Held all[LOADS];
    int first = int(gl_LocalInvocationIndex);
    for (int k = 0; k < LOADS; k++) {
        all[k] = held_at(min(first + k * INVOCATIONS, TEXELS_AROUND - 1), tile, tile_grid);
    }
    load_edges();
    for (int k = 0; k < LOADS; k++) {
        int i = first + k * INVOCATIONS;
        if (i >= TEXELS_AROUND) break;
        for (int j = 0; j < 4; j++) {
            ivec2 at = first_in_window(texel_around(i)) + to_corner(j);
            if (!in_grid(at, ivec2(SIDE))) continue;
            for (int copy = 0; copy < 4; copy++) times[copy * AREA + spot(at)] = all[k].time[j];
            if (CARRIES) {
                for (int copy = 0; copy < 4; copy++) carried[copy * AREA + spot(at)] = all[k].carried[j];
                surface[spot(at)] = all[k].surface[j];
            }
            if (SLOWED != 0) slowness[spot(at)] = all[k].slowness[j];
        }
    }
}

// Returns the row or column, as a step in the window, of the first line that a scan updates.
ivec2 first_line_of_tile(ivec2 ahead) {
    return (ahead.x + ahead.y > 0 ? 1 : TILE) * abs(ahead);
}

#ifdef WITH_POINTS
#include "passes/tile_points.glsl"
#else
#include "passes/tile_pairs.glsl"
#endif

// Makes the four copies equal again at the points of a texel: each point gets the front that arrives first.
void merge(ivec2 in_tile, inout vec4 time, inout vec4 held) {
    for (int j = 0; j < 4; j++) {
        int at = spot(first_in_window(in_tile) + to_corner(j));
        if (CARRIES) {
            bool found = false;
            for (int copy = 0; copy < 4; copy++) {
                float other = times[copy * AREA + at];
                float other_held = carried[copy * AREA + at];
                // In a copy only a front that its own scan has brought counts; any other front is from before the
                // scans. If a scan has withdrawn the front from before and no scan has brought another one, no front is
                // left.
                if (other >= FAR && !found) {
                    time[j] = other;
                    held[j] = other_held;
                }
                if (scan_of(other_held) != uint(copy) + 1u || other >= FAR) continue;
                take_first(other, other_held, found, time[j], held[j]);
            }
            for (int copy = 0; copy < 4; copy++) carried[copy * AREA + at] = held[j];
        } else {
            time[j] = min(min(times[at], times[AREA + at]),
                          min(times[2 * AREA + at], times[3 * AREA + at]));
        }
        for (int copy = 0; copy < 4; copy++) times[copy * AREA + at] = time[j];
    }
}

// Returns which tiles around this one may read the point `at` of this tile, as bits of 3 x 3 tiles.
uint sides_of(ivec2 at) {
    const int REACH = max(SPLITS, 1);
    uint bits = 0u;
    bool west = at.x < REACH;
    bool east = at.x >= TILE - REACH;
    // In a small tile a point may be close to opposite sides.
    if (at.y < REACH) bits |= 0x2u | (west ? 0x1u : 0u) | (east ? 0x4u : 0u);
    if (at.y >= TILE - REACH) bits |= 0x80u | (west ? 0x40u : 0u) | (east ? 0x100u : 0u);
    if (west) bits |= 0x8u;
    if (east) bits |= 0x20u;
    return bits;
}

void main() {
    ivec2 tile_grid = tiles_of(texels);
    uint count = uint(tile_grid.x * tile_grid.y);
    uint place = place_in_dispatch(count);
    if (place >= rounds[ROUND_WORDS * round + 3u]) return;
    uint entry = (2u + (round & 1u)) * count + place;
    if (gl_LocalInvocationIndex < 9u) load_states(entry, count, tile_grid);
    barrier();
    uint number = tile_number;
    uint urgency = tile_urgency;
    // Targets have lowered the limit since the tile was listed.
    if (due_at(urgency) > limit) return;
    if (waits(urgency, round)) {
        if (gl_LocalInvocationIndex == 0u) {
            atomicOr(tiles[entry], uint(HAS_WAITED));
            enlist(number, urgency, round + 1u, count);
            atomicAdd(rounds[ROUND_WORDS * round + 4u], 1u);
            // The map has not converged while a tile waits.
            atomicMax(unsettled[round], tolerance + 1u);
        }
        return;
    }
    ivec2 tile = from_row_major(int(number), tile_grid.x);
    uint state = states[4];
    bool may_renew = renews != 0u;
    causal = fronts_meet != 0u;
    holds = fronts_meet != FRONTS_ARE_ADDED;
    latest = limit;
    if (gl_LocalInvocationIndex == 0u) {
        atomicAdd(visited, 1u);
        woken = 0u;
        reset_subgroup_flags();
        border_change = 0u;
        for (int i = 0; i < 9; i++) urgencies[i] = 0u;
    }
    window = window_at(first_texel_of(tile));
    load(tile, tile_grid);
    barrier();
    find_subgroup_neighbours();

    vec4 time_before[SHARE];
    vec4 held_before[SHARE];
    vec4 time[SHARE];
    vec4 held[SHARE];
    for (int k = 0; k < SHARE; k++) {
        int i = int(gl_LocalInvocationIndex) + k * INVOCATIONS;
        if (i >= OWN_TEXELS) break;
        for (int j = 0; j < 4; j++) {
            int at = spot(first_in_window(from_row_major(i, TEXELS)) + to_corner(j));
            time_before[k][j] = times[at];
            held_before[k][j] = CARRIES ? carried[at] : 0.0;
        }
        time[k] = time_before[k];
        held[k] = held_before[k];
    }
    // All invocations must have read their texels before any subgroup writes the first line of a scan.
    barrier();
    read_subgroup_flags();

    int copy = int(gl_LocalInvocationID.y);
    for (int inner = 0; inner < INNER; inner++) {
        if (gl_LocalInvocationIndex == 0u) change = 0u;
        run_scan(copy, may_renew);
        uint own_change = 0u;
        for (int k = 0; k < SHARE; k++) {
            int i = int(gl_LocalInvocationIndex) + k * INVOCATIONS;
            if (i >= OWN_TEXELS) break;
            vec4 old = time[k];
            vec4 old_held = held[k];
            merge(from_row_major(i, TEXELS), time[k], held[k]);
            own_change = max(own_change, change_of(old, time[k], old_held, held[k]));
        }
        if (own_change > 0u) atomicMax(change, own_change);
        barrier();
        uint all_change = change;
        barrier();
        if (all_change <= tolerance) break;
    }

    // Bits of the tiles among the 3 x 3 that lie on the grid.
    uint around = 0u;
    for (uint i = 0u; i < 9u; i++) {
        ivec2 other = tile + neighbour(i);
        around |= in_grid(other, tile_grid) ? 1u << i : 0u;
    }
    bool has_reached = false;
    for (int k = 0; k < SHARE; k++) {
        int i = int(gl_LocalInvocationIndex) + k * INVOCATIONS;
        if (i >= OWN_TEXELS) break;
        ivec2 in_tile = from_row_major(i, TEXELS);
        ivec2 texel = first_texel_of(tile) + in_tile;
        if (is_beyond(without_border(texel), texels)) continue;
        store_fronts((state & 1u) == 0u, texel, time[k], held[k]);
        for (int j = 0; j < 4; j++) {
            has_reached = has_reached || (time_before[k][j] >= FAR && time[k][j] < FAR);
            uint by = change_of(vec4(time_before[k][j]), vec4(time[k][j]),
                                vec4(held_before[k][j]), vec4(held[k][j]));
            if (by <= tolerance) continue;
            uint changed = urgency_of(min(time_before[k][j], time[k][j]));
            atomicMax(urgencies[4], changed);
            uint sides = around & sides_of(first_point(in_tile) + to_corner(j));
            if (sides == 0u) continue;
            atomicOr(woken, sides);
            atomicMax(border_change, by);
            for (int i = 0; i < 9; i++) {
                if ((sides >> i & 1u) != 0u) atomicMax(urgencies[i], changed);
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
        uint wanted = uint(row_major(other, tile_grid.x));
        uint due = urgencies[gl_LocalInvocationIndex];
        // It can happen that a tile has not settled in its last iteration, but has the same fronts as before the round.
        // Then no change has set its urgency, and the tile keeps its previous urgency.
        enlist(wanted, due != 0u ? due : urgency, round + 1u, count);
    }
}
