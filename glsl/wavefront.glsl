// The kinds of front, and the one place that asks which it is. A kind is a file: what its fronts carry beside
// their arrival time, and how they are updated, compared, accepted, and their changes measured. It is a line here
// in each function for which it has a way of its own.
// Include after constants.glsl. Twins: Wavefront in src/update, and its kinds there and in src/cpu.

// One of PLANAR, CIRCULAR, CURVED and ANCHORED.
layout(constant_id = 2) const int WAVEFRONT = PLANAR;

// Whether the surface has a slowness that is not the same everywhere: then fronts are straight or carry their
// curvature.
layout(constant_id = 12) const int SLOWED = 0;

// Whether fronts hang on nothing that arrives later, as where several may meet. Shaders of maps set it.
bool causal = false;
// Whether seeds that are exact are held.
bool holds = true;

#include "tag.glsl"
#include "triangle.glsl"
#include "planar.glsl"
#include "circular.glsl"
#include "curved.glsl"
#include "slowed.glsl"
#include "anchored.glsl"

const bool HAS_CURVATURE = WAVEFRONT == CURVED;
// Whether updates follow ways back to their anchors, beyond the neighbours of a point (anchored_ways.glsl).
const bool HAS_ANCHORS = WAVEFRONT == ANCHORED;
// Whether fronts carry anything beside their arrival time, which then has the layer CARRIED, and ask what the
// surface brings.
const bool CARRIES = HAS_CURVATURE || HAS_ANCHORS;

// The fronts at x0, given what the surface brings there and its slowness: at FAR or later if neither x1 nor x2 is reached.
// Within a triangle a front with an anchor is a circular one.
Fronts update(Ends end1, Ends end2, vec4 surface, vec4 slowness, vec4 l1, vec4 l2, vec4 c, bvec4 alone) {
    if (SLOWED != 0) {
        if (HAS_CURVATURE) return curved_slowed(end1, end2, surface, slowness, l1, l2, c, alone);
        return Fronts(planar_slowed(end1, end2, slowness, l1, l2, c), vec4(0.0), bvec4(false));
    }
    if (HAS_CURVATURE) return curved(end1, end2, surface, l1, l2, c, alone, bvec4(causal));
    vec4 time = WAVEFRONT == PLANAR ? planar(end1.time, end2.time, l1, l2, c)
                                    : circular(end1.time, end2.time, l1, l2, c);
    return Fronts(time, vec4(0.0), bvec4(false));
}

// The curvature of a front over the base of a triangle, in units of the base. Given are the time at the later end,
// what is carried there and at the other end, and how far the other end's time exceeds this one, in the same unit.
float curvature_over_base(float time, vec2 carried, float d, float base) {
    if (HAS_CURVATURE) return base_curvature(carried.x, carried.y, d, base);
    return WAVEFRONT == PLANAR ? 0.0 : circular_curvature(time, base);
}

// The earlier of two fronts at each point.
Fronts earlier(Fronts a, Fronts b) {
    if (CARRIES) return earlier_curved(a, b);
    return Fronts(min(a.time, b.time), vec4(0.0), bvec4(false));
}

// Whether triangles are obtuse at x0, given the slowness there.
bvec4 are_split(Ends end1, Ends end2, vec4 slowness, vec4 l1, vec4 l2, vec4 c) {
    if (SLOWED != 0) return are_obtuse_on_surface(l1, l2, c, slowness, end1.slowness, end2.slowness);
    return are_obtuse(l1, l2, c);
}

// The same of the triangles of a pair of points of a line from the four points behind: see update_pair().
bvec4 are_split_of_pair(Ends behind, vec2 slowness, vec4 l1, vec4 l2, vec4 c) {
    if (SLOWED != 0) return are_obtuse_on_surface(l1, l2, c, slowness.xyxy, behind.slowness.xyyz, behind.slowness.yzzw);
    return are_obtuse(l1, l2, c);
}

// The bases of triangles, but of obtuse ones, whose edges alone count: see splits.glsl.
vec4 without_faces(bvec4 obtuse, vec4 c) {
    return mix(c, vec4(FAR), obtuse);
}

// The fronts at four points through the two triangles that each sees behind it, given these triangles' bases.
Fronts update_four(Sight sight, vec4 surface, vec4 slowness, vec4 base_left, vec4 base_right) {
    bvec4 alone = are_alone(sight.edges[1]);
    bvec4 left = are_split(sight.ends[0], sight.ends[1], slowness, sight.edges[0], sight.edges[1], base_left);
    bvec4 right = are_split(sight.ends[1], sight.ends[2], slowness, sight.edges[1], sight.edges[2], base_right);
    return earlier(update(sight.ends[0], sight.ends[1], surface, slowness, sight.edges[0], sight.edges[1],
                          without_faces(left, base_left), alone),
                   update(sight.ends[1], sight.ends[2], surface, slowness, sight.edges[1], sight.edges[2],
                          without_faces(right, base_right), alone));
}

// The same at a pair of points of a line, each twice, from the four points behind: left triangles in xy, right
// ones in zw.
Fronts update_pair(Ends behind, vec2 surface, vec2 slowness, vec4 l1, vec4 l2, vec4 base) {
    Ends near = Ends(behind.time.xyyz, behind.carried.xyyz, behind.surface.xyyz, behind.slowness.xyyz);
    Ends far = Ends(behind.time.yzzw, behind.carried.yzzw, behind.surface.yzzw, behind.slowness.yzzw);
    base = without_faces(are_split_of_pair(behind, slowness, l1, l2, base), base);
    Fronts sided = update(near, far, surface.xyxy, slowness.xyxy, l1, l2, base, are_alone(l1.zwzw));
    return earlier(Fronts(sided.time.xyxy, sided.carried.xyxy, sided.whole.xyxy),
                   Fronts(sided.time.zwzw, sided.carried.zwzw, sided.whole.zwzw));
}

// Which fronts points keep: those that are there, or those that a scan, numbered from 1, brings. Those that it
// has brought before may be renewed.
void accept(Fronts fronts, uint scan, bool renews, inout vec4 time, inout vec4 carried) {
    if (HAS_CURVATURE) {
        accept_curved(fronts, scan, renews, time, carried);
    } else if (HAS_ANCHORS) {
        accept_anchored(fronts, scan, renews, time, carried);
    } else {
        time = min(time, fronts.time);
    }
}

// Whether of two fronts at one point, each brought by another scan, the first is kept.
bool is_first(float time, float carried, float other, float other_carried) {
    bool first = time < other;
    if (HAS_CURVATURE) first = is_first_curved(time, carried, other, other_carried);
    if (HAS_ANCHORS) first = is_shorter(time, other);
    return first;
}

// Whether the earlier of two times is kept, whichever of the two fronts is: not where a time belongs to what is
// carried.
const bool KEEPS_EARLIER_TIME = !HAS_ANCHORS;

// How much fronts have changed: the largest difference of arrival times in units of the last
// place, or what a change of what they carry counts beside it.
uint change_of(vec4 old_time, vec4 time, vec4 old_carried, vec4 carried) {
    uvec4 old_bits = floatBitsToUint(old_time);
    uvec4 bits = floatBitsToUint(time);
    uint units = largest(max(old_bits, bits) - min(old_bits, bits));
    if (HAS_CURVATURE) return max(units, change_of_curvature(old_carried, carried, time));
    if (HAS_ANCHORS) return max(units, change_of_anchor(old_carried, carried));
    return units;
}

#ifdef WITH_ORIGINS
#include "anchors.glsl"
#include "origins.glsl"
#endif
