// Fronts that know their anchor: exact over floor plans. Four points at once where all points behind have
// one anchor and no hole is beside them, which is nearly everywhere; elsewhere one after another.
// Include after update.glsl. Twin: src/update/anchored.rs, where it is explained.
//
// The including shader defines
//     vec2 front_at(ivec2 point)          arrival time and numbered value at any point of the grid
//     vec4 edges_at(ivec2 point)          the lengths stored at a point: see texel.glsl
//     int points_in_row()                 from a point's number to that of the point below it
//     vec3 metric()                       of rows, of both, of columns
//     vec4 source_inside(uint number)     column, row and time of a source inside a cell

#include "anchor_number.glsl"

// How a point is reached: when, from which anchor, and when that was.
struct Way {
    float time;
    uint anchor;
    float start;
};

const Way NO_WAY = Way(FAR, 0u, FAR);

// A neighbour, and its anchor.
struct End {
    ivec2 point;
    float time; // FAR if it has not been reached
    bool has_all; // its edges
    uint anchor;
    float start; // when the anchor was reached
    uint before; // from which anchor: itself, if that is a source or not known to be reached
};

// What four points see of the three neighbours each that a scan has just passed: before it, beside it
// and after it.
struct Sight {
    Ends ends[3];
    vec4 edges[3]; // to them
};

// Where the points are: the first, how much further the second and the third, and the scan's way.
struct Places {
    ivec2 first, to_second, to_third;
    ivec2 ahead, along;
};

// Two points of a line, from the fronts and the edges of its update: left triangles in xy, right
// triangles in zw.
Sight sight_of_two(Ends behind, vec4 l1, vec4 l2) {
    Sight sight;
    sight.ends[0] = Ends(behind.time.xyxy, behind.curvature.xyxy, behind.gaussian.xyxy);
    sight.ends[1] = Ends(behind.time.yzyz, behind.curvature.yzyz, behind.gaussian.yzyz);
    sight.ends[2] = Ends(behind.time.zwzw, behind.curvature.zwzw, behind.gaussian.zwzw);
    sight.edges[0] = l1.xyxy;
    sight.edges[1] = l1.zwzw;
    sight.edges[2] = l2.zwzw;
    return sight;
}

bool is_shorter(float a, float b) {
    return a < b * (1.0 - ALIKE * PRECISION);
}

// The shorter of two ways; of two that are as long, on one line, that from the corner passed last.
Way shorter(Way a, Way b) {
    bool as_long = !is_shorter(a.time, b.time) && !is_shorter(b.time, a.time);
    bool second = as_long ? b.start > a.start : b.time < a.time;
    if (second) return b;
    return a;
}

uint number_at(ivec2 point) {
    return uint(point.y * points_in_row() + point.x);
}

ivec2 point_of(uint anchor) {
    int row = points_in_row();
    return ivec2(int(anchor) % row, int(anchor) / row);
}

// Column and row: whole numbers, but for sources.
vec2 place_of_anchor(uint anchor) {
    if (anchor >= FIRST_INSIDE) return source_inside(anchor - FIRST_INSIDE).xy;
    return vec2(point_of(anchor));
}

// Lengths of straight lines.
vec4 lengths_of(vec4 cols, vec4 rows) {
    vec3 m = metric();
    return sqrt(rows * (m.x * rows + (m.y + m.y) * cols) + m.z * cols * cols);
}

float length_of(vec2 to) {
    vec3 m = metric();
    return sqrt(to.y * (m.x * to.y + (m.y + m.y) * to.x) + m.z * to.x * to.x);
}

// Twice the area between two steps.
float area_of(vec2 a, vec2 b) {
    return a.x * b.y - a.y * b.x;
}

// When an anchor was reached, FAR if it has not been, and from which: from itself, if that is not known.
float of_anchor(uint anchor, out uint before) {
    before = anchor;
    if (anchor >= FIRST_INSIDE) return source_inside(anchor - FIRST_INSIDE).z;
    vec2 front = front_at(point_of(anchor));
    if (front.x < FAR) before = number_of(front.y);
    return front.x;
}

// The way to a point from an anchor that was reached at some time.
Way way_from(ivec2 point, float start, uint anchor) {
    return Way(start + length_of(place_of_anchor(anchor) - vec2(point)), anchor, start);
}

// The neighbours of a point, a bit for each of the eight directions, counter-clockwise from east.
uint neighbours_of(ivec2 point) {
    vec4 here = edges_at(point);
    bvec4 to = lessThan(here, vec4(FAR)); // east, north, north-east, north-west
    return (to.x ? 1u : 0u) | (to.z ? 2u : 0u) | (to.y ? 4u : 0u) | (to.w ? 8u : 0u)
         | (edges_at(point + ivec2(-1, 0)).x < FAR ? 16u : 0u)
         | (edges_at(point + ivec2(-1, 1)).z < FAR ? 32u : 0u)
         | (edges_at(point + ivec2(0, 1)).y < FAR ? 64u : 0u)
         | (edges_at(point + ivec2(1, 1)).w < FAR ? 128u : 0u);
}

const uint AXES = 0x55u;

uint turned(uint bits, int by) {
    return (bits >> by | bits << (8 - by)) & 255u;
}

// Between which two directions one can go from a point, by the first of them: in whole cells, and halves of
// cells. Twin: is_open() in src/surface/corner.rs.
uint open_eighths(uint there) {
    uint axes = there & AXES;
    uint diagonals = there & ~AXES;
    uint next = axes & turned(axes, 2); // with the axis after it
    return next | turned(next, 7) | (axes & turned(diagonals, 1)) | (diagonals & turned(axes, 1));
}

// Whether paths can bend at a point that lacks an edge. Twin: is_corner() in src/surface/corner.rs.
bool is_corner(ivec2 point) {
    uint there = neighbours_of(point);
    uint open = open_eighths(there);
    uint beside = open | turned(open, 7);
    uint passable = (there & AXES) | (there & ~AXES & beside);
    uint ends = open | passable;
    uint blocked = (passable | beside) & ~open;
    return (blocked & (turned(ends, 1) | turned(ends, 2) | turned(ends, 3))) != 0u;
}

// The way along an edge: from its end, if that is a corner, or straight on.
Way way_along(ivec2 x0, End end) {
    if (!end.has_all && is_corner(end.point)) return way_from(x0, end.time, number_at(end.point));
    vec2 edge = vec2(end.point - x0);
    vec2 ray = place_of_anchor(end.anchor) - vec2(x0);
    bool goes_on = area_of(edge, ray) == 0.0 && dot(edge, ray) >= dot(edge, edge);
    if (goes_on) return way_from(x0, end.start, end.anchor);
    return NO_WAY;
}

// On which side of the line from one anchor to another a point is.
int side_of(ivec2 point, uint from, uint to) {
    if (max(from, to) < FIRST_INSIDE) {
        ivec2 border = point_of(to) - point_of(from);
        ivec2 step = point - point_of(from);
        return sign(border.x * step.y - border.y * step.x);
    }
    vec2 at = place_of_anchor(from);
    return int(sign(area_of(place_of_anchor(to) - at, vec2(point) - at)));
}

// The same for an anchor.
int side_of_anchor(uint anchor, uint from, uint to) {
    if (anchor < FIRST_INSIDE) return side_of(point_of(anchor), from, to);
    vec2 at = place_of_anchor(from);
    return int(sign(area_of(place_of_anchor(to) - at, place_of_anchor(anchor) - at)));
}

// The step in one of the eight directions. No table: lavapipe reads those for idle invocations too, anywhere.
ivec2 step_of(int to) {
    return ivec2(int(0x83u >> to & 1u) - int(0x38u >> to & 1u), int(0xe0u >> to & 1u) - int(0x0eu >> to & 1u));
}

// On which side of the ray from an anchor to a corner the hole is that the corner is one of: 1, -1, or 0
// if there are holes on both.
int shadow_of(uint anchor, uint corner) {
    ivec2 at = point_of(corner);
    uint open = open_eighths(neighbours_of(at));
    vec2 ray = vec2(at) - place_of_anchor(anchor);
    bool left = false;
    bool right = false;
    for (int eighth = 0; eighth < 8; eighth++) {
        float side = area_of(ray, vec2(step_of(eighth) + step_of((eighth + 1) & 7)));
        bool blocked = (open >> eighth & 1u) == 0u;
        left = left || (blocked && side > 0.0);
        right = right || (blocked && side < 0.0);
    }
    return int(left) - int(right);
}

// The corner at which the way from an anchor to that of an end bends first, or that of the end if it is
// straight; whether that way is known.
bool first_bend(uint anchor, End end, out uint corner) {
    uint first = end.anchor;
    uint before = end.before;
    corner = end.anchor;
    for (int i = 0; i < GENERATIONS && before != anchor; i++) {
        if (before == first) return false;
        first = before;
        if (of_anchor(first, before) >= FAR) return false;
    }
    if (before != anchor) return false;
    corner = first;
    // From the end back: the farthest of those on a line with the first.
    uint at = end.anchor;
    before = end.before;
    bool is_straight = false;
    for (int i = 0; i < GENERATIONS && at != first; i++) {
        bool is_on = side_of_anchor(at, anchor, first) == 0;
        if (!is_on) {
            corner = first;
        } else if (!is_straight) {
            corner = at;
        }
        is_straight = is_on;
        at = before;
        of_anchor(at, before);
    }
    return true;
}

// Whether x0 is out of the shadow that an end of its base lies in, as seen from an anchor: behind the
// first corner on the way from that anchor to the end, on the side of its hole. Where the end is not there,
// it lies in the shadow of another if the straight line would have been shorter, and x0 beside it.
bool sees(ivec2 x0, Way way, End end) {
    if (end.anchor == way.anchor) return true;
    uint corner;
    bool known = first_bend(way.anchor, end, corner);
    int shadow = 0;
    if (known && corner < FIRST_INSIDE) shadow = shadow_of(way.anchor, corner);
    // On the border the end's own anchor serves as well, and knows which corners come next.
    bool is_own = corner == end.anchor;
    // Not by times where it can be told by sides: their rounding hides small detours.
    int of_end = side_of(end.point, way.anchor, corner);
    if (shadow == 0 || (!is_own && of_end * shadow <= 0)) {
        if (!is_shorter(way_from(end.point, way.start, way.anchor).time, end.time)) return true;
        shadow = of_end;
    }
    int of_x0 = side_of(x0, way.anchor, corner) * shadow;
    return of_x0 < 0 || (is_own && of_x0 == 0);
}

// The shortest straight way through a triangle, from an anchor of its ends or from these' own.
Way way_through(ivec2 x0, End a, End b) {
    Way best = NO_WAY;
    if (a.time >= FAR || b.time >= FAR) return best;
    vec2 e1 = vec2(a.point - x0);
    vec2 e2 = vec2(b.point - x0);
    float turn = area_of(e1, e2);
    // Where both ends have one anchor, all that lies between is lit by it alone.
    bool of_one = a.anchor == b.anchor;
    for (int k = 0; k < (of_one ? 1 : 2); k++) {
        uint anchor = k == 0 ? a.anchor : b.anchor;
        float start = k == 0 ? a.start : b.start;
        uint before = k == 0 ? a.before : b.before;
        for (int i = 0; i <= GENERATIONS; i++) {
            vec2 ray = place_of_anchor(anchor) - vec2(x0);
            vec2 parts = turn * vec2(area_of(ray, e2), area_of(e1, ray));
            if (parts.x >= 0.0 && parts.y >= 0.0 && parts.x + parts.y >= 1.0) {
                Way way = way_from(x0, start, anchor);
                bool comes = !is_shorter(best.time, way.time);
                for (int j = 0; j < 2; j++) {
                    if (comes) comes = sees(x0, way, j == 0 ? a : b);
                }
                if (comes) best = shorter(best, way);
            }
            if (of_one || before == anchor) break;
            anchor = before;
            start = of_anchor(anchor, before);
            if (start >= FAR) break;
        }
    }
    return best;
}

// The shortest way to a point past three neighbours that follow one another.
Way reach(ivec2 x0, End ends[3]) {
    Way best = NO_WAY;
    for (int i = 0; i < 2; i++) best = shorter(best, way_through(x0, ends[i], ends[i + 1]));
    for (int i = 0; i < 3; i++) {
        if (ends[i].time < FAR) best = shorter(best, way_along(x0, ends[i]));
    }
    return best;
}

// When the anchor was reached is as it is known there, to which what follows from the neighbour is rounded;
// but the latter where the two differ, since a change must come from the neighbours.
End end_of(ivec2 point, Ends fronts, vec4 edges, int i) {
    End end = End(point, FAR, (floatBitsToUint(fronts.gaussian[i]) & 15u) != 1u, 0u, FAR, 0u);
    if (fronts.time[i] < FAR && edges[i] < FAR) {
        end.time = fronts.time[i];
        end.anchor = number_of(fronts.curvature[i]);
        float follows = end.time - length_of(place_of_anchor(end.anchor) - vec2(point));
        float known = of_anchor(end.anchor, end.before);
        end.start = abs(known - follows) <= ALIKE_AT_ANCHOR * PRECISION * end.time ? known : follows;
    }
    return end;
}

bvec4 are_numbered_as(vec4 a, vec4 b) {
    return equal((floatBitsToUint(a) ^ floatBitsToUint(b)) & ~15u, uvec4(0u));
}

uint bits_of(bvec4 which) {
    uvec4 each = mix(uvec4(0u), uvec4(1u, 2u, 4u, 8u), which);
    return each.x | each.y | each.z | each.w;
}

// The ways of the first points that a scan, numbered from 1, brings them, given their fronts: none where
// all neighbours are reached later, unless it is to bring again what it has brought before.
Fronts ways_to(Sight sight, Places places, uint points, uint scan, bool renews, vec4 time, vec4 held) {
    Fronts found = Fronts(vec4(FAR), vec4(0.0), bvec4(false));
    Ends before = sight.ends[0];
    Ends beside = sight.ends[1];
    Ends after = sight.ends[2];
    vec4 behind = min(beside.time, min(before.time, after.time));
    bvec4 again = both(bvec4(renews), equal(floatBitsToUint(held) & 7u, uvec4(scan)));
    bvec4 wanted = both(lessThan(behind, vec4(FAR)), either(again, lessThan(behind, time)));
    uint left = bits_of(wanted) & points;
    if (left == 0u) return found;

    vec4 latest = max(beside.time, max(before.time, after.time));
    bvec4 of_one = both(are_numbered_as(before.curvature, beside.curvature),
                        are_numbered_as(after.curvature, beside.curvature));
    uvec4 tags = floatBitsToUint(before.gaussian) & 15u;
    tags |= floatBitsToUint(beside.gaussian) & 15u;
    tags |= floatBitsToUint(after.gaussian) & 15u;
    bvec4 open = both(both(lessThan(latest, vec4(FAR)), of_one), equal(tags, uvec4(0u)));
    uint first = bits_of(open) & left;
    if (first != 0u) {
        // The straight line from one anchor runs between the neighbours.
        float held_there = beside.curvature[findLSB(first)];
        uint anchor = number_of(held_there);
        vec2 from = place_of_anchor(anchor);
        vec4 cols = from.x - (places.first.x + places.to_second.x * vec4(0.0, 1.0, 0.0, 1.0)
                                             + places.to_third.x * vec4(0.0, 0.0, 1.0, 1.0));
        vec4 rows = from.y - (places.first.y + places.to_second.y * vec4(0.0, 1.0, 0.0, 1.0)
                                             + places.to_third.y * vec4(0.0, 0.0, 1.0, 1.0));
        vec2 ahead = vec2(places.ahead);
        uint unused;
        float known = of_anchor(anchor, unused);
        vec4 follows = beside.time - lengths_of(cols + ahead.x, rows + ahead.y);
        vec4 rounding = ALIKE_AT_ANCHOR * PRECISION * beside.time;
        vec4 start = mix(follows, vec4(known), lessThanEqual(abs(known - follows), rounding));
        vec4 ways = start + lengths_of(cols, rows);
        vec4 back = -(cols * ahead.x + rows * ahead.y);
        vec4 aside = abs(cols * float(places.along.x) + rows * float(places.along.y));
        bvec4 passes = both(lessThanEqual(aside, back), greaterThanEqual(back, vec4(1.0)));
        bvec4 alike = both(open, are_numbered_as(beside.curvature, vec4(held_there)));
        found.time = mix(vec4(FAR), ways, both(alike, passes));
        found.curvature = vec4(held_there);
        left &= ~bits_of(alike);
    }

    while (left != 0u) {
        int i = findLSB(left);
        left &= left - 1u;
        ivec2 point = places.first + (i & 1) * places.to_second + (i >> 1) * places.to_third;
        End ends[3];
        for (int k = 0; k < 3; k++) {
            ivec2 at = point - places.ahead + (k - 1) * places.along;
            ends[k] = end_of(at, sight.ends[k], sight.edges[k], i);
        }
        Way way = reach(point, ends);
        found.time[i] = way.time;
        found.curvature[i] = with_number(way.anchor);
    }
    return found;
}
