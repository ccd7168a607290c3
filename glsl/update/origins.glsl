// Implements the curved update, for four triangles at once, where fronts of several origins meet. On maps with several
// sources a front carries the number of its origin in place of a curvature, as long as its time agrees with the length
// of the straight line from the origin.
// Twin: crates/surface/src/update/sight.rs, where the formulas are explained. The twin computes distances in double precision.

#include "update/anchors.glsl"

// Whether fronts of the map carry numbers of origins.
layout(constant_id = 14) const int NAMED = 0;

bvec4 are_numbers(vec4 carried) {
    return lessThanEqual(carried, vec4(-FIRST_ORIGIN));
}

// The origins of four fronts as seen from x0, in columns and rows. An origin is a point or a segment.
struct Sighted {
    vec4 col, row;             // from x0 to one end
    vec4 extent_col, extent_row; // from that end to the other
    vec4 start;                // time at which the front leaves the origin; FAR if the origin is not known
};

// Returns the origins of fronts, as seen from the points of a site.
Sighted sighted_from(vec4 carried, Site site) {
    Sighted all = Sighted(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(FAR));
    for (int i = 0; i < 4; i++) {
        if (carried[i] > -FIRST_ORIGIN) continue;
        uint number = (floatBitsToUint(-carried[i]) - floatBitsToUint(FIRST_ORIGIN)) >> 4;
        vec4 ends = origin_ends(number);
        all.col[i] = ends.x - site.col[i];
        all.row[i] = ends.y - site.row[i];
        all.extent_col[i] = ends.z;
        all.extent_row[i] = ends.w;
        all.start[i] = origin_start(number);
    }
    return all;
}

// A step in the plane of a triangle: the multiples of the steps x0 x1 and x0 x2 of which it is the sum.
struct Parts {
    vec4 first, second;
};

// Scalar products of the steps x0 x1 and x0 x2: of the first with itself, of both, and of the second with itself.
struct Plane {
    vec4 first, both, second;
};

// Returns the parts of steps that are given in columns and rows.
Parts parts_of(Site site, vec4 col, vec4 row) {
    vec4 per_area = 1.0 / (site.first_row * site.second_col - site.first_col * site.second_row);
    return Parts((row * site.second_col - col * site.second_row) * per_area,
                 (site.first_row * col - site.first_col * row) * per_area);
}

// Returns the scalar products of two steps.
vec4 dot_in(Plane plane, Parts a, Parts b) {
    return a.first * (plane.first * b.first + plane.both * b.second)
         + a.second * (plane.both * b.first + plane.second * b.second);
}

// The ray to a place from the nearest point of a source.
struct Ray {
    Parts step; // from that point to the place
    vec4 size;
    bvec4 is_beside; // whether the ray starts between the source's ends, at a right angle to the source
};

// Returns the ray to a place from the nearest point of a source. `to` is the step from x0 to one end of the source,
// `extent` the step from there to the other end, and `per_square` is 1 over the squared length of `extent`, or 0 for a
// point. `place` is the place relative to x0, as parts.
Ray ray_to(Plane plane, Parts to, Parts extent, vec4 per_square, vec2 place) {
    Parts from_end = Parts(place.x - to.first, place.y - to.second);
    vec4 foot = clamp(dot_in(plane, from_end, extent) * per_square, 0.0, 1.0);
    Parts step = Parts(from_end.first - foot * extent.first, from_end.second - foot * extent.second);
    vec4 size = sqrt(max(dot_in(plane, step, step), 0.0));
    return Ray(step, size, both(greaterThan(foot, vec4(0.0)), lessThan(foot, vec4(1.0))));
}

// Returns the length of ray `b` less that of ray `a`. It is computed from the difference of their steps, since the
// difference of the lengths would lose digits.
vec4 longer(Plane plane, Ray a, Ray b) {
    Parts apart = Parts(b.step.first - a.step.first, b.step.second - a.step.second);
    Parts sum = Parts(b.step.first + a.step.first, b.step.second + a.step.second);
    vec4 sizes = a.size + b.size;
    return mix(vec4(0.0), dot_in(plane, apart, sum) / sizes, greaterThan(sizes, vec4(0.0)));
}

// Returns the curvature of a front at the distance `away` from its source: from a point, or where `is_beside` is set
// from a straight line.
vec4 curvature_at(vec4 away, bvec4 is_beside, vec4 gaussian) {
    vec4 bend = gaussian * away;
    bvec4 is_off = greaterThan(away, vec4(0.0));
    vec4 round = min(1.0 / mix(vec4(1.0), away, is_off), SOURCE_CURVATURE) - bend * (1.0 / 3.0);
    return mix(mix(vec4(SOURCE_CURVATURE), round, is_off), -bend, is_beside);
}

// The front at one end of a base, as seen from its origin.
struct FromOrigin {
    bvec4 is_known;    // the front carries the number of its origin
    bvec4 is_in_sight; // its time agrees with the straight line from the origin, up to IN_SIGHT
    bvec4 is_on_line;  // its time agrees up to ON_LINE, which is little more than rounding
    vec4 curvature;
    Ray ray;           // ray from the origin to x0
    bvec4 crosses;     // the ray crosses the base
    vec4 crossing;     // share of the base that lies before the crossing
    vec4 time;         // arrival time at x0 along the line
    vec4 other;        // arrival time at the other end
    vec4 start;        // time at which the front leaves the origin; 0 if the origin is not known
};

// Rounding of a time for these comparisons, as a multiple of its unit in the last place.
const float SIGHT_ROUNDING = 16.0;

// Returns the fronts at one end of the bases as seen from their origins. `here` has the parts of the step from x0 to
// this end, and `there` those of the step to the other end.
FromOrigin from_origin(Plane plane, vec4 base, Site site, Sighted sighted, EndFronts end, vec2 here, vec2 there) {
    FromOrigin from;
    from.is_known = lessThan(sighted.start, vec4(FAR));
    from.start = mix(vec4(0.0), sighted.start, from.is_known);
    Parts to = parts_of(site, sighted.col, sighted.row);
    Parts extent = parts_of(site, sighted.extent_col, sighted.extent_row);
    vec4 square = dot_in(plane, extent, extent);
    bvec4 is_line = greaterThan(square, vec4(0.0));
    vec4 per_square = mix(vec4(0.0), 1.0 / mix(vec4(1.0), square, is_line), is_line);
    from.ray = ray_to(plane, to, extent, per_square, vec2(0.0));
    Ray to_end = ray_to(plane, to, extent, per_square, here);
    Ray to_other = ray_to(plane, to, extent, per_square, there);
    vec4 rounding = SIGHT_ROUNDING * PRECISION * abs(end.time);
    vec4 late = abs(end.time - from.start - to_end.size);
    vec4 reach = to_end.size + base;
    from.is_in_sight = both(from.is_known, lessThanEqual(late, IN_SIGHT * reach + rounding));
    from.is_on_line = lessThanEqual(late, ON_LINE * reach + rounding);
    vec4 of_source = curvature_at(end.time - from.start, to_end.is_beside, end.surface);
    from.curvature = mix(end.carried, of_source, from.is_known);
    vec4 along_first = -from.ray.step.first;
    vec4 along_second = -from.ray.step.second;
    vec4 all = along_first + along_second;
    vec4 least = -PAST_EDGE * abs(all);
    from.crosses = both(greaterThan(all, vec4(0.0)),
                        both(greaterThanEqual(along_first, least), greaterThanEqual(along_second, least)));
    from.crossing = clamp(along_second / mix(vec4(1.0), all, greaterThan(all, vec4(0.0))), 0.0, 1.0);
    from.time = end.time + longer(plane, to_end, from.ray);
    from.other = end.time + longer(plane, to_end, to_other);
    return from;
}

// Returns the value that a front carries at x0. It is the number of the origin if `time` agrees with the straight line
// from there, and the surface is flat enough for the curvature to follow from the distance. Otherwise it is the
// curvature.
vec4 carried_on(FromOrigin from, vec4 time, vec4 number, vec4 gaussian, vec4 base) {
    vec4 away = time - from.start;
    bvec4 is_straight = lessThanEqual(abs(away - from.ray.size), IN_SIGHT * (from.ray.size + base));
    bvec4 is_flat = lessThanEqual(abs(gaussian * away * away), vec4(BENDS_MOST));
    return mix(curvature_at(away, from.ray.is_beside, gaussian), number, both(is_straight, is_flat));
}

// Replaces the arriving front by another one where `comes` is set and the other front is not later.
void take_where_first(inout Fronts arrival, bvec4 comes, vec4 time, vec4 carried) {
    bvec4 is_first = both(comes, lessThanEqual(time, arrival.time));
    arrival.time = mix(arrival.time, time, is_first);
    arrival.carried = mix(arrival.carried, carried, is_first);
    arrival.whole = either(is_first, arrival.whole);
}

// Returns the fronts at x0 from fronts at x1 and x2 that may have different origins. Where both ends have one origin
// and their times agree with its straight line, so does the time at x0. Where the ends do not share an origin, the
// front of each end that its origin explains continues separately, if its ray crosses the base and the other end does
// not block it. The ordinary curved update gives the other fronts: through the face, or along the edges only.
Fronts curved_from_origins(EndFronts end1, EndFronts end2, vec4 g0, vec4 l1, vec4 l2, vec4 c, bvec4 alone, Site site) {
    Sighted sighted1 = sighted_from(end1.carried, site);
    Sighted sighted2 = sighted_from(end2.carried, site);
    bvec4 exists = lessThan(max(max(l1, l2), c), vec4(FAR));
    vec4 first_edge = mix(vec4(1.0), l1, exists);
    vec4 second_edge = mix(vec4(1.0), l2, exists);
    vec4 base = mix(vec4(1.0), c, exists);
    vec4 squares1 = first_edge * first_edge;
    vec4 squares2 = second_edge * second_edge;
    Plane plane = Plane(squares1, 0.5 * (squares1 + squares2 - base * base), squares2);
    FromOrigin first = from_origin(plane, base, site, sighted1, end1, vec2(1.0, 0.0), vec2(0.0, 1.0));
    FromOrigin second = from_origin(plane, base, site, sighted2, end2, vec2(0.0, 1.0), vec2(1.0, 0.0));
    bvec4 both_known = both(first.is_known, second.is_known);
    bvec4 same = both(both_known, are_alike_but_for_tags(end1.carried, end2.carried));
    bvec4 of_one = both(both(same, exists), both(first.is_in_sight, second.is_in_sight));
    // Where both times agree with the straight lines, the time at x0 follows from the line as well. The shape of the
    // front is not needed.
    bvec4 exact = both(of_one, both(first.is_on_line, second.is_on_line));
    bvec4 inexact = both(of_one, not(exact));
    bvec4 obtuse = are_obtuse(l1, l2, c);
    bvec4 apart = both(both(first.is_in_sight, second.is_in_sight), not(same));
    vec4 later = max(end1.time, end2.time);
    later = later + abs(later) * (CLEARLY_LATER * PRECISION);
    vec4 unblocked = UNBLOCKED * base;
    vec4 time1 = mix(first.time, mix(first.time, second.time, first.crossing), exact);
    bvec4 may_come = both(exists, not(inexact));
    bvec4 in_order1 = either(first.is_on_line, both(not(obtuse), either(bvec4(!causal), greaterThanEqual(time1, later))));
    bvec4 free1 = either(of_one, lessThanEqual(end2.time, first.other + unblocked));
    bvec4 comes1 = both(both(both(first.is_in_sight, first.crosses), both(free1, in_order1)), may_come);
    bvec4 in_order2 = either(second.is_on_line,
                             both(not(obtuse), either(bvec4(!causal), greaterThanEqual(second.time, later))));
    bvec4 free2 = lessThanEqual(end1.time, second.other + unblocked);
    bvec4 comes2 = both(both(both(second.is_in_sight, second.crosses), both(free2, in_order2)),
                        both(may_come, not(exact)));
    // Where the fronts at both ends continue separately, there is no common front through the face. Only the edges are
    // used.
    bvec4 faceless = either(either(apart, either(comes1, comes2)), either(exact, obtuse));
    Fronts arrival = curved(EndFronts(end1.time, first.curvature, end1.surface, vec4(0.0)),
                            EndFronts(end2.time, second.curvature, end2.surface, vec4(0.0)), g0, l1, l2,
                            bases_of_acute(faceless, c), alone, both(bvec4(causal), not(of_one)));
    bvec4 keeps_name = both(both(inexact, first.crosses), lessThan(arrival.time, vec4(FAR)));
    vec4 named = carried_on(first, arrival.time, end1.carried, g0, base);
    // A front that does not keep the number of its origin is made later by the rounding. Then a front that keeps its
    // number replaces it if both arrive together.
    vec4 rounding = abs(arrival.time) * (SIGHT_ROUNDING * PRECISION);
    bvec4 gives_way = both(not(keeps_name), either(first.is_known, second.is_known));
    arrival.time = mix(arrival.time, arrival.time + rounding, gives_way);
    arrival.carried = mix(arrival.carried, named, keeps_name);
    take_where_first(arrival, comes1, time1, carried_on(first, time1, end1.carried, g0, base));
    take_where_first(arrival, comes2, second.time, carried_on(second, second.time, end2.carried, g0, base));
    return arrival;
}
