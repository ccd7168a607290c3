// Scans a tile with two neighbouring points of a line for each invocation, which updates them from four triangles at
// once. This suits CPUs, where each invocation of a workgroup adds to the cost of a barrier. Included by
// tile_round.glsl.

// Updates the points `at` and `at + along` of a line of one scan.
void advance(ivec2 at, ivec2 ahead, ivec2 along, int copy, bool may_renew) {
    ivec2 behind = at - ahead;
    ivec2 next = at + along;
    EndFronts ends;
    ends.carried = vec4(0.0);
    ends.surface = vec4(0.0);
    ends.slowness = vec4(0.0);
    for (int i = 0; i < 4; i++) {
        int from = spot(behind + (i - 1) * along);
        ends.time[i] = times[copy * AREA + from];
        if (CARRIES) {
            ends.carried[i] = carried[copy * AREA + from];
            ends.surface[i] = surface[from];
        }
        if (SLOWED != 0) ends.slowness[i] = slowness[from];
    }
    // Left triangles are in xy, right triangles in zw.
    vec2 sides = vec2(edge_in_tile(at, -ahead), edge_in_tile(next, -ahead));
    vec4 l1 = vec4(edge_in_tile(at, -ahead - along), edge_in_tile(next, -ahead - along), sides);
    vec4 l2 = vec4(sides, edge_in_tile(at, -ahead + along), edge_in_tile(next, -ahead + along));
    int a = copy * AREA + spot(at);
    int b = copy * AREA + spot(next);
    vec4 time = vec2(times[a], times[b]).xyxy;
    vec4 held = vec4(0.0);
    if (CARRIES) held = vec2(carried[a], carried[b]).xyxy;
    Fronts fronts;
    copy_here = copy;
    Places pair = Places(window + at, along, ivec2(0), ahead, along);
    if (HAS_ANCHORS) {
        fronts = ways_to(sight_of_pair(ends, l1, l2), pair, 3u, uint(copy) + 1u, may_renew, time, held);
    } else {
        vec4 bases = vec4(edge_in_tile(behind - along, along), edge_in_tile(behind, along),
                          edge_in_tile(behind + along, along), 0.0);
        vec2 own = CARRIES ? vec2(surface[spot(at)], surface[spot(next)]) : vec2(0.0);
        vec2 slow = SLOWED != 0 ? vec2(slowness[spot(at)], slowness[spot(next)]) : vec2(0.0);
        fronts = update_pair(ends, own, slow, l1, l2, bases.xyyz);
        bvec4 obtuse = are_obtuse_in_pair(ends, slow, l1, l2, bases.xyyz);
        add_parts(pair, obtuse, obtuse.zwxy, fronts);
    }
    accept(fronts, uint(copy) + 1u, may_renew, time, held);
    // Parts of obtuse triangles and anchors may read points of this line, so all invocations read before any writes.
    if (SPLITS != 0 || HAS_ANCHORS) barrier();
    times[a] = time.x;
    times[b] = time.y;
    if (CARRIES) {
        carried[a] = held.x;
        carried[b] = held.y;
    }
}

// Runs one of the four scans over its copy of the tile. When it returns, all invocations see the fronts that it has
// written.
void run_scan(int copy, bool may_renew) {
    ivec2 ahead = ahead_of(copy);
    ivec2 along = along_of(copy);
    ivec2 start = (1 + 2 * int(gl_LocalInvocationID.x)) * along + first_line_of_tile(ahead);
    for (int line = 0; line < TILE; line++) {
        advance(start + line * ahead, ahead, along, copy, may_renew);
        barrier();
    }
}

// Subgroups are not used here. The interface is that of tile_points.glsl.
void reset_subgroup_flags() {}
void find_subgroup_neighbours() {}
void read_subgroup_flags() {}
