// Implements the update of fronts with anchors, which is exact over floor plans. Nearly everywhere, all neighbours
// behind a point have the same anchor. Such points are updated together, four at once. Other points are updated one
// after another.
// Twin: crates/surface/src/update/anchored.rs, where the update is explained.

#include "shared/processor.glsl"
#include "shared/surface_image.glsl"
#include "update/anchors.glsl"
#include "update/splits.glsl"
#include "update/corner.glsl"

// A path to a point: the arrival time there, the anchor's number, and the arrival time at the anchor.
struct Way {
    float time;
    uint anchor;
    float start;
};

const Way NO_WAY = Way(FAR, 0u, FAR);

// An anchor, with what its own front tells about the path to it.
struct Anchor {
    uint number;
    vec2 place;  // column and row: whole numbers, except for sources
    float time;  // arrival time; FAR if the anchor has not been reached
    uint before; // number of its own anchor; its own number if it is a source or has not been reached
};

// The fronts at the three neighbours behind a point, and their anchors. Neighbours 0 and 1 are the ends of the first
// triangle, 1 and 2 those of the second.
struct Known {
    vec3 time;
    uvec3 anchor;
    vec3 start;    // arrival time at the anchor
    vec3 col, row; // column and row of the anchor
    uvec3 before;  // anchor of the anchor
};

// Returns the shorter of two paths. Of two equally long ones, it returns the path whose anchor is reached later: on one
// line, this is the last corner that the path passes.
Way shorter(Way a, Way b) {
    bool as_long = !is_shorter(a.time, b.time) && !is_shorter(b.time, a.time);
    bool second = as_long ? b.start > a.start : b.time < a.time;
    if (second) return b;
    return a;
}

// Returns the difference between the numbers of a point and of the point below it.
int points_in_row() {
    return imageSize(edges).x;
}

uint number_at(ivec2 point) {
    return uint(row_major(point, points_in_row()));
}

// Returns the grid point with a number. It divides floats, since integer division is slow on devices. Rounding may give
// an adjacent row, which is corrected. No image has enough rows for a larger error.
ivec2 point_of(uint anchor) {
    int row = points_in_row();
    int y = int(float(anchor) / float(row));
    int x = int(anchor) - y * row;
    if (x < 0) return ivec2(x + row, y - 1);
    if (x >= row) return ivec2(x - row, y + 1);
    return ivec2(x, y);
}

// Returns the lengths of straight lines that extend over `cols` columns and `rows` rows.
vec4 lengths_of(vec4 cols, vec4 rows) {
    vec3 m = metric();
    return sqrt(rows * (m.x * rows + (m.y + m.y) * cols) + m.z * cols * cols);
}

float length_of(vec2 to) {
    vec3 m = metric();
    return sqrt(to.y * (m.x * to.y + (m.y + m.y) * to.x) + m.z * to.x * to.x);
}

// Returns twice the signed area of the triangle between two steps. `precise` forbids fused multiply-adds, so that the
// area between a step and itself is exactly zero.
float area_of(vec2 a, vec2 b) {
    precise float area = a.x * b.y - a.y * b.x;
    return area;
}

// Returns the anchor with a number.
Anchor anchor_of(uint number) {
    if (number >= FIRST_INSIDE) {
        vec4 source = source_inside(number - FIRST_INSIDE);
        return Anchor(number, source.xy, source.z, number);
    }
    ivec2 point = point_of(number);
    vec2 front = front_at(point);
    return Anchor(number, vec2(point), front.x, front.x < FAR ? number_of(front.y) : number);
}

// Returns the straight path over `step` from an anchor that is reached at `start`.
Way way_from(vec2 step, float start, uint anchor) {
    return Way(start + length_of(step), anchor, start);
}

// Returns the side of the step `border` on which `step` lies: 1, -1, or 0 if both lie on one line. The result is exact
// for steps between grid points.
int side_of(vec2 border, vec2 step) {
    if (border == floor(border) && step == floor(step)) {
        ivec2 a = ivec2(border);
        ivec2 b = ivec2(step);
        return sign(a.x * b.y - a.y * b.x);
    }
    return int(sign(area_of(border, step)));
}

// Returns the step in one of the eight directions. It computes the step, since lavapipe would read a table for inactive
// invocations too, at indices out of bounds.
ivec2 step_of(int to) {
    return ivec2(int(0x83u >> to & 1u) - int(0x38u >> to & 1u),
                 int(0xe0u >> to & 1u) - int(0x0eu >> to & 1u));
}

// Returns the side of a ray to a corner on which the corner's hole lies: 1, -1, or 0 if there are holes on
// both sides.
int shadow_of(vec2 ray, ivec2 corner) {
    uint blocked = blocked_eighths(surface_at(corner));
    bool left = false;
    bool right = false;
    for (int eighth = 0; eighth < 8; eighth++) {
        float side = area_of(ray, vec2(step_of(eighth) + step_of((eighth + 1) & 7)));
        bool is_blocked = (blocked >> eighth & 1u) != 0u;
        left = left || (is_blocked && side > 0.0);
        right = right || (is_blocked && side < 0.0);
    }
    return int(left) - int(right);
}

// The shape of the path from an anchor to an end of a base.
struct Detour {
    bool known;
    uint corner; // first corner at which it bends; the end's own anchor if the path is straight or not known
    vec2 border; // step from the anchor to that corner
    bool winds;  // whether the path bends to both sides
};

// Returns the shape of the path from an anchor, reached at `start`, to an end of a base. It follows the
// anchors of the end back, one after another.
Detour detour_of(Anchor anchor, float start, vec2 point, Known ends, int end) {
    vec2 place = vec2(ends.col[end], ends.row[end]);
    vec2 ahead = point - place;
    vec2 ray = place - anchor.place;
    uint at = ends.anchor[end];
    uint before = ends.before[end];
    Detour found = Detour(false, at, ray, false);
    bool left = false;
    bool right = false;
    int lines = 1;
    bool goes_back = before != anchor.number && before != at;
    while (goes_back) {
        Anchor next = anchor_of(before);
        goes_back = next.time < FAR && !is_shorter(next.time, start);
        if (goes_back) {
            vec2 come = place - next.place;
            int turn = side_of(come, ahead);
            left = left || turn > 0;
            right = right || turn < 0;
            vec2 to_next = next.place - anchor.place;
            if (side_of(to_next, ray) != 0) {
                found.corner = before;
                found.border = to_next;
            }
            at = before;
            before = next.before;
            place = next.place;
            ahead = come;
            ray = to_next;
            lines++;
            goes_back = lines < LINES_BACK && before != anchor.number && before != at;
        }
    }
    found.known = before == anchor.number;
    int turn = side_of(ray, ahead);
    found.winds = (left || turn > 0) && (right || turn < 0);
    if (!found.known) {
        found.corner = ends.anchor[end];
        found.border = vec2(ends.col[end], ends.row[end]) - anchor.place;
        found.winds = false;
    }
    return found;
}

// Returns the eighths on both sides of one of the eight directions, as bits.
uint beside(int to) {
    return 1u << to | 1u << ((to + 7) & 7);
}

// Returns the direction of a step along a column or row.
int axis_of(bool by_cols, float step) {
    return by_cols ? (step > 0.0 ? 0 : 4) : (step > 0.0 ? 6 : 2);
}

// Returns whether the straight line from a point to an anchor, given as a step, crosses no hole. The line is followed
// from one grid line to the next: from column to column if it passes more columns than rows, otherwise from row to row.
bool is_clear(ivec2 point, vec2 step) {
    bool by_cols = abs(step.x) >= abs(step.y);
    int ahead = axis_of(by_cols, by_cols ? step.x : step.y);
    int toward = axis_of(!by_cols, by_cols ? step.y : step.x);
    float lines = max(abs(step.x), abs(step.y));
    float aside = min(abs(step.x), abs(step.y));
    int eighth = toward == ((ahead + 2) & 7) ? ahead : (ahead + 7) & 7;

    // Where the line runs along edges, the cell on at least one side of each edge must be present.
    bool on_edges = aside == 0.0 || aside == lines;
    int diagonal = toward == ((ahead + 2) & 7) ? ahead + 1 : (ahead + 7) & 7;
    int edge = aside == 0.0 ? ahead : diagonal;
    // Otherwise the cells on both sides of each edge that the line crosses must be present. At a grid point on the
    // line, both eighths through which the line passes must be.
    uint through_point = 1u << eighth | 1u << ((eighth + 4) & 7);
    float beyond = 0.0;
    float left = lines;
    bool clear = true;
    while (clear && left > 0.0) {
        if (on_edges) {
            clear = (blocked_eighths(surface_at(point)) & beside(edge)) != beside(edge);
            point += step_of(edge);
            left -= 1.0;
        } else {
            // `beyond` is the offset of the line from `point` on the next grid line, times the total number of grid
            // lines. The product is exact if the anchor is a grid point.
            beyond += aside * min(left, 1.0);
            ivec2 next = point + step_of(toward);
            if (beyond > lines) clear = (blocked_eighths(surface_at(next)) & beside(ahead)) == 0u;
            if (beyond >= lines) {
                point = next;
                beyond -= lines;
            }
            point += step_of(ahead);
            left -= 1.0;
            uint way = beyond == 0.0 ? through_point : beside(toward);
            if (left > 0.0) clear = clear && (blocked_eighths(surface_at(point)) & way) == 0u;
        }
    }
    return clear;
}

// Returns whether an anchor is visible from x0, given one end of the base, `point`. The end's path shows which corner
// may hide the anchor: the first corner on the path from the anchor to the end. The corner's shadow lies behind the
// corner, on the side of its hole. If the end lies in this shadow, an x0 in the shadow does not see the anchor. An x0
// outside of it does, unless the end's path winds between holes. In all other cases another corner may hide the anchor,
// but only if the straight line to the end would be shorter than the end's path. Then the straight line from x0 is
// followed over the grid.
bool sees(vec2 x0, vec2 point, Anchor anchor, float start, Known ends, int end) {
    Detour detour = detour_of(anchor, start, point, ends, end);
    int shadow = 0;
    if (detour.known && detour.corner < FIRST_INSIDE) shadow = shadow_of(detour.border, point_of(detour.corner));
    // If x0 lies on the border of the shadow, the path past the corner is as long. Then this anchor is rejected in
    // favour of the end's own anchor, which knows the corners that come next, unless the corner is that anchor itself.
    bool is_own = detour.corner == ends.anchor[end];
    bool is_told = shadow != 0 && (is_own || side_of(detour.border, point - anchor.place) * shadow > 0);
    int of_x0 = side_of(detour.border, x0 - anchor.place) * shadow;
    if (is_told && (of_x0 > 0 || (of_x0 == 0 && !is_own))) return false;
    if (is_told && !detour.winds) return true;
    // Times are compared last, since their rounding hides small detours.
    bool is_hidden = is_shorter(start + length_of(point - anchor.place), ends.time[end]);
    return !is_hidden || is_clear(ivec2(x0), anchor.place - x0);
}

// Returns the arrival times at an anchor. `known` is the time stored there. A neighbour with the arrival time `time` at
// the distance `straight` from the anchor implies the time `time - straight`. If both agree up to rounding, the result
// is the known time. Otherwise the anchor's front may have changed, and the result is the implied time.
vec4 start_of(float known, vec4 time, vec4 straight) {
    vec4 follows = time - straight;
    return mix(follows, vec4(known), lessThanEqual(abs(known - follows), ALIKE_AT_ANCHOR * PRECISION * time));
}

// Returns the shortest path to the i-th of four points, given the three neighbours behind each. The path may come along
// an edge: from the neighbour if that is a corner, otherwise from the neighbour's anchor on the same line. Or it comes
// straight through a triangle, from the anchor of one of its ends or from an earlier anchor on the path to that end.
//
// Each case is written once, in a loop over the bits of the cases left to examine. lavapipe runs all lanes through all
// code, so that each copy would cost time, and it does not unroll loops over bits. No loop has its test at the end:
// lavapipe would then overwrite the results of lanes that leave the loop earlier than others.
Way reach(ivec2 point, NeighboursBehind sight, Places places, int i) {
    vec2 x0 = vec2(point);
    vec2 ahead = vec2(places.ahead);
    vec2 along = vec2(places.along);
    Way best = NO_WAY;
    Known ends = Known(vec3(0.0), uvec3(0u), vec3(0.0), vec3(0.0), vec3(0.0), uvec3(0u));
    uint reached = 0u;
    uint corners = 0u;
    for (int k = 0; k < 3; k++) {
        ends.time[k] = sight.ends[k].time[i];
        ends.anchor[k] = number_of(sight.ends[k].carried[i]);
        if (ends.time[k] < FAR && sight.edges[k][i] < FAR) reached |= 1u << k;
        if (are_corners(vec4(sight.ends[k].surface[i])).x) corners |= 1u << k;
    }
    uint left = reached;
    while (left != 0u) {
        int k = findLSB(left);
        left &= left - 1u;
        Anchor anchor = anchor_of(ends.anchor[k]);
        vec2 edge = float(k - 1) * along - ahead;
        vec2 ray = anchor.place - x0;
        float start = start_of(anchor.time, vec4(ends.time[k]), vec4(length_of(ray - edge))).x;
        ends.start[k] = start;
        ends.col[k] = anchor.place.x;
        ends.row[k] = anchor.place.y;
        ends.before[k] = anchor.before;
        bool bends = (corners >> k & 1u) != 0u;
        bool goes_on = area_of(edge, ray) == 0.0 && dot(edge, ray) >= dot(edge, edge);
        Way way = way_from(ray, start, anchor.number);
        if (bends) way = way_from(edge, ends.time[k], number_at(point + ivec2(edge)));
        if (bends || goes_on) best = shorter(best, way);
    }

    // Two bits for each triangle: whether to try the anchors of its first end and of its second end. If both ends have
    // the same anchor, all points between them see this anchor, and no other one is tried.
    bvec2 of_one = equal(ends.anchor.xy, ends.anchor.yz);
    left = (reached & 3u) == 3u ? (of_one.x ? 1u : 3u) : 0u;
    left |= (reached & 6u) == 6u ? (of_one.y ? 4u : 12u) : 0u;
    int first = 0; // first end of the triangle
    int last = 0;  // end whose anchors are tried
    int lines = 0;
    int bends = 0;
    bool goes_back = false;
    vec2 went = vec2(0.0); // step from the anchor to the place examined before it
    Anchor anchor = Anchor(0u, vec2(0.0), FAR, 0u);
    Way way = NO_WAY;
    while (goes_back || left != 0u) {
        bool comes = false;
        while (!comes && (goes_back || left != 0u)) {
            uint number = anchor.before;
            vec2 from = anchor.place;
            lines++;
            if (!goes_back) {
                int bit = findLSB(left);
                left &= left - 1u;
                first = bit >> 1;
                last = first + (bit & 1);
                number = ends.anchor[last];
                from = x0 + float(last - 1) * along - ahead;
                lines = 0;
                bends = 0;
            }
            anchor = anchor_of(number);
            vec2 goes = from - anchor.place;
            if (goes_back && side_of(goes, went) != 0) bends++;
            went = goes;
            vec2 ray = anchor.place - x0;
            way = way_from(ray, lines == 0 ? ends.start[last] : anchor.time, number);
            vec2 e1 = float(first - 1) * along - ahead;
            vec2 e2 = e1 + along;
            vec2 parts = area_of(e1, e2) * vec2(area_of(ray, e2), area_of(e1, ray));
            bool is_end = ray == e1 || ray == e2;
            bool beyond_base = !is_end && parts.x >= 0.0 && parts.y >= 0.0 && parts.x + parts.y >= 1.0;
            bool is_near = way.start < FAR && bends <= BENDS_BACK;
            comes = beyond_base && is_near && !is_shorter(best.time, way.time);
            bool may_go_back = lines < LINES_BACK && ends.anchor[first] != ends.anchor[first + 1];
            goes_back = may_go_back && is_near && anchor.before != number;
        }
        uint asked = ends.anchor[first] != anchor.number ? 1u << first : 0u;
        asked |= ends.anchor[first + 1] != anchor.number ? 2u << first : 0u;
        if (!comes) asked = 0u;
        while (asked != 0u) {
            int end = findLSB(asked);
            asked &= asked - 1u;
            vec2 edge = float(end - 1) * along - ahead;
            comes = sees(x0, x0 + edge, anchor, way.start, ends, end);
            if (!comes) asked = 0u;
        }
        if (comes) best = shorter(best, way);
    }
    return best;
}

// Returns a mask with a bit for each component that is true.
uint bits_of(bvec4 which) {
    uvec4 each = mix(uvec4(0u), uvec4(1u, 2u, 4u, 8u), which);
    return each.x | each.y | each.z | each.w;
}

// Returns the paths that a scan brings to the points whose bits are set in `points`. `time` and `held` are the present
// fronts there, and `scan` is counted from 1. A point whose neighbours are all reached later gets no path, unless
// `renews` is set and the same scan brought its present front.
Fronts ways_to(NeighboursBehind sight, Places places, uint points, uint scan, bool renews, vec4 time, vec4 held) {
    Fronts found = Fronts(vec4(FAR), vec4(0.0), bvec4(false));
    vec4 reached[3];
    bvec4 bends[3];
    vec4 behind = vec4(FAR);
    vec4 told = vec4(0.0);
    for (int k = 0; k < 3; k++) {
        reached[k] = mix(vec4(FAR), sight.ends[k].time, lessThan(sight.edges[k], vec4(FAR)));
        bends[k] = are_corners(sight.ends[k].surface);
        behind = min(behind, reached[k]);
        told = mix(told, sight.ends[k].carried, lessThan(reached[k], vec4(FAR)));
    }
    bvec4 again = both(bvec4(renews), are_of_scan(held, scan));
    bvec4 wanted = both(lessThan(behind, vec4(FAR)), either(again, lessThan(behind, time)));
    uint left = bits_of(wanted) & points;
    if (left == 0u) return found;

    // `of_one`: points whose neighbours all have one anchor. `alike`: those of them with the same anchor as the first
    // such point. They are updated together.
    bvec4 of_one = wanted;
    for (int k = 0; k < 3; k++) {
        bvec4 is_none = greaterThanEqual(reached[k], vec4(FAR));
        of_one = both(of_one, either(is_none, are_alike_but_for_tags(sight.ends[k].carried, told)));
    }
    uint first = bits_of(of_one) & left;
    float held_there = told[first != 0u ? findLSB(first) : 0];
    bvec4 alike = both(bvec4(first != 0u), both(of_one, are_alike_but_for_tags(told, vec4(held_there))));

    // The remaining points are updated one after another. On GPUs all invocations update their i-th point in the same
    // turn, or skip it: if neighbouring invocations updated different points in one turn, NVIDIA's compiler (driver
    // 580) lost some of the results. On CPUs each invocation takes its own next point, since the lanes would otherwise
    // wait in turns that none of them needs.
    left &= ~bits_of(alike);
    for (int turn = 0; turn < 4; turn++) {
        int i = turn;
        if (ON_PROCESSOR != 0) {
            if (left == 0u) break;
            i = findLSB(left);
            left &= left - 1u;
        } else if ((left >> turn & 1u) == 0u) {
            continue;
        }
        ivec2 point = places.first + to_corner(i).x * places.to_second + to_corner(i).y * places.to_third;
        Way way = reach(point, sight, places, i);
        found.time[i] = way.time;
        found.carried[i] = with_number(way.anchor);
    }

    if (first != 0u) {
        Anchor anchor = anchor_of(number_of(held_there));
        vec4 second = vec4(0.0, 1.0, 0.0, 1.0);
        vec4 third = vec4(0.0, 0.0, 1.0, 1.0);
        vec4 x = places.first.x + places.to_second.x * second + places.to_third.x * third;
        vec4 y = places.first.y + places.to_second.y * second + places.to_third.y * third;
        vec4 cols = anchor.place.x - x;
        vec4 rows = anchor.place.y - y;
        vec2 ahead = vec2(places.ahead);
        vec2 along = vec2(places.along);
        vec4 straight = lengths_of(cols, rows);
        vec4 back = -(cols * ahead.x + rows * ahead.y);
        vec4 aside = cols * along.x + rows * along.y;
        bvec4 is_behind = greaterThanEqual(back, vec4(1.0));
        vec4 start = vec4(FAR);
        for (int k = 0; k < 3; k++) {
            // A path from the anchor comes through the triangle between this neighbour and the next, or along the edge
            // to this neighbour.
            vec2 edge = float(k - 1) * along - ahead;
            vec4 from = float(k - 1) * back;
            bvec4 through = bvec4(false);
            if (k < 2) {
                through = both(lessThan(reached[k + 1], vec4(FAR)),
                               both(lessThanEqual(from, aside), lessThanEqual(aside, from + back)));
            }
            bvec4 lit = both(both(is_behind, lessThan(reached[k], vec4(FAR))),
                             either(through, both(equal(aside, from), not(bends[k]))));
            vec4 by_end = start_of(anchor.time, reached[k], lengths_of(cols - edge.x, rows - edge.y));
            start = min(start, mix(vec4(FAR), by_end, lit));
        }
        vec4 time_of_one = mix(vec4(FAR), start + straight, lessThan(start, vec4(FAR)));
        vec4 carried_of_one = vec4(held_there);
        // These paths come along an edge from a corner. Of two equally long paths on one line, the path from the last
        // corner on the line is taken.
        for (int k = 0; k < 3; k++) {
            vec2 edge = float(k - 1) * along - ahead;
            vec4 from_corner = reached[k] + length_of(edge);
            uvec4 number = uvec4(y + edge.y) * uint(points_in_row()) + uvec4(x + edge.x);
            bvec4 sooner = lessThan(from_corner * (1.0 - ALIKE * PRECISION), time_of_one);
            bvec4 comes = both(both(bends[k], sooner), lessThan(reached[k], vec4(FAR)));
            time_of_one = mix(time_of_one, from_corner, comes);
            carried_of_one = mix(carried_of_one, with_numbers(number), comes);
        }
        found.time = mix(found.time, time_of_one, alike);
        found.carried = mix(found.carried, carried_of_one, alike);
    }
    return found;
}
