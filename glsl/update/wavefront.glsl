// Selects the kind of front. Only this file asks for WAVEFRONT itself; others ask for HAS_CURVATURE, HAS_ANCHORS and
// CARRIES. Each kind has a file of its own. It defines what the fronts carry besides their arrival time, how they are
// updated, compared and accepted, and how their changes are measured. A kind adds a case to each function below that
// it implements differently. Twins: Wavefront in src/update, and its kinds there and in
// src/cpu.

// Kind of front: PLANAR, CIRCULAR, CURVED or ANCHORED. The build compiles large shaders once for each kind, with the
// kind as a macro. With a specialization constant, drivers would spend time on the code of all kinds.
#ifndef WAVEFRONT
layout(constant_id = 2) const int WAVEFRONT = PLANAR;
#endif

// Whether the slowness of the surface varies. Fronts are then planar or curved.
layout(constant_id = 12) const int SLOWED = 0;

// Shaders that update maps set the next three variables.
//
// Whether an update takes nothing from a neighbour that is reached later. This is needed where fronts may meet.
bool causal = false;
// Whether exact seeds are kept.
bool holds = true;
// Limit of arrival times. Points that fronts would reach later count as unreached.
float latest = NO_LIMIT;

#include "update/tag.glsl"
#include "update/triangle.glsl"
#include "update/planar.glsl"
#include "update/circular.glsl"
#include "update/curved.glsl"
#include "update/slowed.glsl"
#include "update/anchored.glsl"

const bool HAS_CURVATURE = WAVEFRONT == CURVED;
// Whether updates follow paths back to their anchors, beyond the neighbours of a point (anchored_ways.glsl).
const bool HAS_ANCHORS = WAVEFRONT == ANCHORED;
// Whether fronts carry a value besides their arrival time, in the layer CARRIED. Their updates read the surface values.
const bool CARRIES = HAS_CURVATURE || HAS_ANCHORS;

// Returns the fronts at x0, given the surface value and the slowness there. Their times are FAR or later if
// neither x1 nor x2 is reached. Anchored fronts are treated as circular ones inside a triangle.
Fronts update(EndFronts end1, EndFronts end2, vec4 surface, vec4 slowness, vec4 l1, vec4 l2, vec4 c, bvec4 alone) {
    if (SLOWED != 0) {
        if (HAS_CURVATURE) return curved_slowed(end1, end2, surface, slowness, l1, l2, c, alone);
        return Fronts(planar_slowed(end1, end2, slowness, l1, l2, c), vec4(0.0), bvec4(false));
    }
    if (HAS_CURVATURE) return curved(end1, end2, surface, l1, l2, c, alone, bvec4(causal));
    vec4 time = WAVEFRONT == PLANAR ? planar(end1.time, end2.time, l1, l2, c)
                                    : circular(end1.time, end2.time, l1, l2, c);
    return Fronts(time, vec4(0.0), bvec4(false));
}

// Returns the fronts at x0 as update() does, through triangles whose shapes are already known. The slowness is 1.
Fronts update_on(Face face, EndFronts end1, EndFronts end2, vec4 surface, bvec4 alone) {
    bvec4 swap = lessThan(end1.time, end2.time);
    Shape shape = seen_from(face, swap);
    vec4 height = mix(face.height_x1, face.height_x2, swap);
    if (HAS_CURVATURE) {
        return curved_in(shape, height, face.upright, end1, end2, surface, face.l1, face.l2, face.base, alone,
                         bvec4(causal));
    }
    vec4 time;
    if (WAVEFRONT == PLANAR) {
        time = planar_in(face.from_x1, end1.time, end2.time, face.l1, face.l2, face.base);
    } else {
        time = circular_in(shape, height, end1.time, end2.time, face.l1, face.l2, face.base);
    }
    return Fronts(time, vec4(0.0), bvec4(false));
}

// Returns the curvature of a front over the base of a triangle, in units of 1 over the base. `time` is the arrival time
// at the end that is reached later. `carried` has the carried values at that end and at the other one. `d` is the time
// at the other end less `time`, in units of the base.
float curvature_over_base(float time, vec2 carried, float d, float base) {
    if (HAS_CURVATURE) return base_curvature(carried.x, carried.y, d, base);
    return WAVEFRONT == PLANAR ? 0.0 : circular_curvature(time, base);
}

// Returns the earlier of two fronts at each point.
Fronts earlier(Fronts a, Fronts b) {
    if (CARRIES) return earlier_curved(a, b);
    return Fronts(min(a.time, b.time), vec4(0.0), bvec4(false));
}

// Returns whether triangles are obtuse at x0, given the slowness there.
bvec4 are_obtuse_at_x0(EndFronts end1, EndFronts end2, vec4 slowness, vec4 l1, vec4 l2, vec4 c) {
    if (SLOWED != 0) return are_obtuse_on_surface(l1, l2, c, slowness, end1.slowness, end2.slowness);
    return are_obtuse(l1, l2, c);
}

// Returns whether the triangles between a pair of points of a line and the four points behind are obtuse; see
// update_pair().
bvec4 are_obtuse_in_pair(EndFronts behind, vec2 slowness, vec4 l1, vec4 l2, vec4 c) {
    if (SLOWED != 0) return are_obtuse_on_surface(l1, l2, c, slowness.xyxy, behind.slowness.xyyz, behind.slowness.yzzw);
    return are_obtuse(l1, l2, c);
}

// Returns the bases of triangles, or FAR for obtuse ones. Updates then use only their edges; see splits.glsl.
vec4 bases_of_acute(bvec4 obtuse, vec4 c) {
    return mix(c, vec4(FAR), obtuse);
}

// Returns the fronts at x0 as update() does. `c` has the bases of obtuse triangles too.
Fronts update_acute(EndFronts end1, EndFronts end2, vec4 surface, vec4 slowness, vec4 l1, vec4 l2, vec4 c, bvec4 alone) {
    bvec4 obtuse = are_obtuse_at_x0(end1, end2, slowness, l1, l2, c);
    return update(end1, end2, surface, slowness, l1, l2, bases_of_acute(obtuse, c), alone);
}

// Returns the fronts at four points through the two triangles that each sees behind it, given the bases of
// these triangles.
Fronts update_four(NeighboursBehind sight, vec4 surface, vec4 slowness, vec4 base_left, vec4 base_right) {
    bvec4 alone = are_alone(sight.edges[1]);
    return earlier(update_acute(sight.ends[0], sight.ends[1], surface, slowness, sight.edges[0], sight.edges[1], base_left,
                                alone),
                   update_acute(sight.ends[1], sight.ends[2], surface, slowness, sight.edges[1], sight.edges[2], base_right,
                                alone));
}

// Returns the fronts at a pair of points of a line from the four points behind: at the first point in x and z, at the
// second one in y and w. In `l1`, `l2` and `base`, left triangles are in xy and right ones in zw.
Fronts update_pair(EndFronts behind, vec2 surface, vec2 slowness, vec4 l1, vec4 l2, vec4 base) {
    EndFronts near = EndFronts(behind.time.xyyz, behind.carried.xyyz, behind.surface.xyyz, behind.slowness.xyyz);
    EndFronts far = EndFronts(behind.time.yzzw, behind.carried.yzzw, behind.surface.yzzw, behind.slowness.yzzw);
    Fronts sided = update_acute(near, far, surface.xyxy, slowness.xyxy, l1, l2, base, are_alone(l1.zwzw));
    return earlier(Fronts(sided.time.xyxy, sided.carried.xyxy, sided.whole.xyxy),
                   Fronts(sided.time.zwzw, sided.carried.zwzw, sided.whole.zwzw));
}

// Replaces the present fronts (`time`, `carried`) by those that a scan brings, where the new ones come first. If
// `renews` is set, later fronts may also replace fronts that the same scan brought before. `scan` is counted from 1.
void accept(Fronts fronts, uint scan, bool renews, inout vec4 time, inout vec4 carried) {
    bvec4 too_late = both(greaterThan(fronts.time, vec4(latest)), greaterThanEqual(time, vec4(FAR)));
    fronts.time = mix(fronts.time, vec4(FAR), too_late);
    if (HAS_CURVATURE) {
        accept_curved(fronts, scan, renews, time, carried);
    } else if (HAS_ANCHORS) {
        accept_anchored(fronts, scan, renews, time, carried);
    } else {
        time = min(time, fronts.time);
    }
}

// Returns whether the front (`time`, `carried`) is kept in place of the other one. Different scans brought the two.
bool is_first(float time, float carried, float other, float other_carried) {
    bool first = time < other;
    if (HAS_CURVATURE) first = is_first_curved(time, carried, other, other_carried);
    if (HAS_ANCHORS) first = is_shorter(time, other);
    return first;
}

// Whether a point that takes the carried value of one of two fronts still keeps the earlier of both times. Anchored
// fronts do not, since their time follows from their anchor.
const bool KEEPS_EARLIER_TIME = !HAS_ANCHORS;

// Replaces the present front at a point by another one if is_first() prefers the other one, or if no front has been
// found yet.
void take_first(float other, float other_carried, inout bool found, inout float time, inout float carried) {
    bool takes_other = !found || is_first(other, other_carried, time, carried);
    if (takes_other) carried = other_carried;
    bool keeps = KEEPS_EARLIER_TIME ? found && !(other < time) : !takes_other;
    if (!keeps) time = other;
    found = true;
}

// Returns the largest change of four fronts: the change of an arrival time in units of the last place, or the weight of
// a change of the carried value. Fronts later than `latest` before and after the change do not count.
uint change_of(vec4 old_time, vec4 time, vec4 old_carried, vec4 carried) {
    bvec4 late = greaterThan(min(old_time, time), vec4(latest));
    time = mix(time, old_time, late);
    carried = mix(carried, old_carried, late);
    uvec4 old_bits = floatBitsToUint(old_time);
    uvec4 bits = floatBitsToUint(time);
    uint units = largest(max(old_bits, bits) - min(old_bits, bits));
    if (HAS_CURVATURE) return max(units, change_of_curvature(old_carried, carried, time));
    if (HAS_ANCHORS) return max(units, change_of_anchor(old_carried, carried));
    return units;
}
