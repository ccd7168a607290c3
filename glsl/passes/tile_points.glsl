// Scans a tile with one point of a line for each invocation. This suits GPUs: an invocation has half as much work
// between two barriers as with a pair of points. It computes the values of the next line that do not depend on times
// while it waits for its neighbours on this line. Included by tile_round.glsl.
//
// An invocation keeps the front that it has written on the line behind. With WITH_SHUFFLES it reads the two fronts
// beside this front from the registers of its neighbours. Without WITH_SHUFFLES, and between subgroups, neighbours pass
// their fronts through shared memory.
//
// An update takes four triangles. Here the left triangle is in x and the right one in z. The components y and w are
// constants, and compilers for GPUs remove their computation.

// Length of the edges of the unused triangles in y and w. With equal edges they are not obtuse.
const float UNUSED_LENGTH = 1.0;

// Front, surface value and slowness at a point.
struct Seen {
    float time, carried, surface, slowness;
};

// Values at a point and behind it that the scan does not change before it updates the point.
struct Stored {
    Edges edges;
    Seen own;
    // The neighbours diagonally behind. Their fronts are not valid before know_neighbours() has set them.
    Seen before, after;
    // At an end of the line: the neighbour diagonally behind that lies outside the tile.
    Seen outside;
};

// Stored values of a point, and the shapes of its triangles, which can be computed before the fronts behind are known.
struct Prepared {
    Stored stored;
    vec4 l1, l2, base;
    bvec4 obtuse;
    Face face;
};

vec4 sided(float left, float right, float other) {
    return vec4(left, other, right, other);
}

Seen seen_in_tile(int copy, int at) {
    Seen seen = Seen(times[copy * AREA + at], 0.0, 0.0, 0.0);
    if (CARRIES) {
        seen.carried = carried[copy * AREA + at];
        seen.surface = surface[at];
    }
    if (SLOWED != 0) seen.slowness = slowness[at];
    return seen;
}

Stored stored_at(ivec2 at, ivec2 ahead, ivec2 along, int copy, StoredLengths all, inout vec4 lengths_behind) {
    bool is_last = gl_LocalInvocationID.x == TILE - 1;
    return Stored(edges_of(at, ahead, along, all, lengths_behind), seen_in_tile(copy, spot(at)),
                  seen_in_tile(copy, spot(at - ahead - along)), seen_in_tile(copy, spot(at - ahead + along)),
                  seen_in_tile(copy, spot(at - ahead + (is_last ? along : -along))));
}

Prepared prepare(Stored stored) {
    Prepared next;
    next.stored = stored;
    Edges edges = stored.edges;
    next.l1 = sided(edges.left, edges.middle, UNUSED_LENGTH);
    next.l2 = sided(edges.middle, edges.right, UNUSED_LENGTH);
    next.base = sided(edges.base_left, edges.base_right, UNUSED_LENGTH);
    next.obtuse = bvec4(false);
    if (SLOWED == 0 && !HAS_ANCHORS) {
        next.obtuse = are_obtuse(next.l1, next.l2, next.base);
        next.face = face_of(next.l1, next.l2, next.base, next.obtuse);
    }
    return next;
}

// Returns the front at a point, given the three points behind it. All four components are equal.
Fronts update_point(Prepared now, Seen before, Seen behind, Seen after, Places places) {
    EndFronts near = EndFronts(sided(before.time, behind.time, 0.0), sided(before.carried, behind.carried, 0.0),
                     sided(before.surface, behind.surface, 0.0), sided(before.slowness, behind.slowness, UNUSED_LENGTH));
    EndFronts far = EndFronts(sided(behind.time, after.time, 0.0), sided(behind.carried, after.carried, 0.0),
                    sided(behind.surface, after.surface, 0.0), sided(behind.slowness, after.slowness, UNUSED_LENGTH));
    vec4 own = sided(now.stored.own.surface, now.stored.own.surface, 0.0);
    vec4 slow = sided(now.stored.own.slowness, now.stored.own.slowness, UNUSED_LENGTH);
    bvec4 alone = bvec4(now.l1.z >= FAR);
    Fronts both_sides;
    if (SLOWED != 0) {
        both_sides = update_acute(near, far, own, slow, now.l1, now.l2, now.base, alone);
        now.obtuse = are_obtuse_at_x0(near, far, slow, now.l1, now.l2, now.base);
    } else {
        both_sides = update_on(now.face, near, far, own, alone);
    }
    Fronts fronts = earlier(Fronts(both_sides.time.xxxx, both_sides.carried.xxxx, both_sides.whole.xxxx),
                            Fronts(both_sides.time.zzzz, both_sides.carried.zzzz, both_sides.whole.zzzz));
    bvec4 right = bvec4(now.obtuse.z, false, false, false);
    add_parts(places, bvec4(now.obtuse.x, false, false, false), right, fronts);
    return fronts;
}

// Returns the paths to a point x0 as fronts with anchors, given the three points behind it. Only component x is used.
Fronts ways_to_point(Prepared now, Seen before, Seen behind, Seen after, Places places, uint scan, bool renews) {
    EndFronts ends = EndFronts(vec4(before.time, behind.time, after.time, FAR),
                     vec4(before.carried, behind.carried, after.carried, 0.0),
                     vec4(before.surface, behind.surface, after.surface, 0.0), vec4(0.0));
    return ways_to(sight_of_pair(ends, now.l1, now.l2), places, 1u, scan, renews, vec4(now.stored.own.time),
                   vec4(now.stored.own.carried));
}

// Whether the invocations of the points before and after this one on the line are in this invocation's subgroup.
bool has_before = false;
bool has_after = false;
// Whether each line of the workgroup lies in a single subgroup.
bool are_lines_whole = false;
// Whether any line is divided between subgroups.
shared uint divided;

// The device chooses which invocations form a subgroup. So invocations find out by exchanging their numbers with their
// neighbours. The caller executes a barrier after each of the first two of the following three functions.
void reset_subgroup_flags() {
    divided = 0u;
}

void find_subgroup_neighbours() {
#ifdef WITH_SHUFFLES
    int number = int(gl_LocalInvocationIndex);
    int before = subgroupShuffleUp(number, 1u);
    int after = subgroupShuffleDown(number, 1u);
    // A subgroup may have fewer invocations than its size.
    uint place_after = subgroupShuffleDown(gl_SubgroupInvocationID, 1u);
    has_before = gl_SubgroupInvocationID > 0u && before == number - 1;
    has_after = gl_SubgroupInvocationID + 1u < gl_SubgroupSize && after == number + 1
                && place_after == gl_SubgroupInvocationID + 1u;
    int place = int(gl_LocalInvocationID.x);
    if (place > 0 && !has_before || place < TILE - 1 && !has_after) atomicOr(divided, 1u);
#endif
}

void read_subgroup_flags() {
#ifdef WITH_SHUFFLES
    are_lines_whole = divided == 0u;
#endif
}

// Makes the fronts that are written on a line visible to all invocations of the scan.
void end_line() {
#ifdef WITH_SHUFFLES
    if (are_lines_whole) {
        subgroupMemoryBarrierShared();
        subgroupBarrier();
        return;
    }
#endif
    barrier();
}

// Returns the neighbours diagonally behind, `before` and `after` the point, with the fronts that the scan has written
// there. `behind` is the point behind, at `at_behind` in the window.
void know_neighbours(Prepared now, Seen behind, ivec2 at_behind, ivec2 along, int copy, out Seen before, out Seen after) {
    before = now.stored.before;
    after = now.stored.after;
    int place = int(gl_LocalInvocationID.x);
#ifdef WITH_SHUFFLES
    before.time = subgroupShuffleUp(behind.time, 1u);
    after.time = subgroupShuffleDown(behind.time, 1u);
    if (CARRIES) {
        before.carried = subgroupShuffleUp(behind.carried, 1u);
        after.carried = subgroupShuffleDown(behind.carried, 1u);
    }
    if (place == 0) {
        before.time = now.stored.outside.time;
        before.carried = now.stored.outside.carried;
    }
    if (place == TILE - 1) {
        after.time = now.stored.outside.time;
        after.carried = now.stored.outside.carried;
    }
    if (are_lines_whole) return;
#endif
    if (!has_before) {
        int from = copy * AREA + spot(at_behind - along);
        before.time = times[from];
        if (CARRIES) before.carried = carried[from];
    }
    if (!has_after) {
        int from = copy * AREA + spot(at_behind + along);
        after.time = times[from];
        if (CARRIES) after.carried = carried[from];
    }
}

// Runs one of the four scans over its copy of the tile. When it returns, all invocations see the fronts that it has
// written.
void run_scan(int copy, bool may_renew) {
    const bool SEES_FURTHER = SPLITS != 0 || HAS_ANCHORS;
    ivec2 ahead = ahead_of(copy);
    ivec2 along = along_of(copy);
    ivec2 at = (1 + int(gl_LocalInvocationID.x)) * along + first_line_of_tile(ahead);
    copy_here = copy;
    vec4 lengths_behind = vec4(0.0);
    if (EDGES_SHARED == 0) lengths_behind = lengths_in_image(at - ahead);
    Seen behind = seen_in_tile(copy, spot(at - ahead));
    Prepared now = prepare(stored_at(at, ahead, along, copy, lengths_around(at, ahead, along), lengths_behind));
    StoredLengths all_next = lengths_around(at + ahead, ahead, along);
    for (int line = 0; line < TILE; line++) {
        Seen before;
        Seen after;
        know_neighbours(now, behind, at - ahead, along, copy, before, after);
        Stored next = stored_at(line + 1 < TILE ? at + ahead : at, ahead, along, copy, all_next, lengths_behind);
        all_next = lengths_around(line + 2 < TILE ? at + 2 * ahead : at, ahead, along);

        Places places = Places(window + at, along, ivec2(0), ahead, along);
        Fronts fronts;
        if (HAS_ANCHORS) {
            fronts = ways_to_point(now, before, behind, after, places, uint(copy) + 1u, may_renew);
        } else {
            fronts = update_point(now, before, behind, after, places);
        }
        vec4 time = vec4(now.stored.own.time);
        vec4 held = vec4(now.stored.own.carried);
        accept(fronts, uint(copy) + 1u, may_renew, time, held);
        // Parts of obtuse triangles and anchors may read points of this line, so all invocations read before any
        // writes.
        if (SEES_FURTHER) end_line();
        times[copy * AREA + spot(at)] = time.x;
        if (CARRIES) carried[copy * AREA + spot(at)] = held.x;
        behind = Seen(time.x, held.x, now.stored.own.surface, now.stored.own.slowness);
        now = prepare(next);
        if (SEES_FURTHER || !are_lines_whole) end_line();
        at += ahead;
    }
    barrier();
}
