// Implements fronts that carry their curvature, with a tag. The surface value at a point is the surface's Gaussian
// curvature there, with another tag. See tag.glsl.
// Twin: the curved front in src/update, where the formulas are explained.

// Returns the curvature of a front at the end of a ray. `curvature` is its curvature there if the surface were
// developable, `gaussian` the mean Gaussian curvature along the ray, and `ray` the ray's length.
vec4 bent(vec4 curvature, vec4 gaussian, vec4 ray) {
    vec4 x = curvature * ray;
    return curvature - gaussian * ray * (1.0 - x + x * x * (1.0 / 3.0));
}

// Returns the fronts at x0 from fronts at x1 and x2. `g0` is the Gaussian curvature at x0. `alone` tells
// where only one of x1 and x2 is present, across the grid's diagonal. `causal` tells where x0 must not depend
// on neighbours that arrive later. The shape is seen from the end at which the front arrives later. `h` is
// its height, and `upright` tells whether no angle is obtuse by more than a few degrees.
Fronts curved_in(Shape shape, vec4 h, bvec4 upright, EndFronts end1, EndFronts end2, vec4 g0, vec4 l1, vec4 l2, vec4 c,
                 bvec4 alone, bvec4 causal) {
    bvec4 swap = lessThan(end1.time, end2.time);
    vec4 t = mix(end1.time, end2.time, swap);
    vec4 near_t = mix(end2.time, end1.time, swap);
    vec4 k = mix(end1.carried, end2.carried, swap);
    vec4 near_k = mix(end2.carried, end1.carried, swap);
    vec4 g = mix(end1.surface, end2.surface, swap);
    vec4 near_g = mix(end2.surface, end1.surface, swap);
    vec4 l = mix(l1, l2, swap);
    vec4 near_l = mix(l2, l1, swap);
    vec4 p = shape.foot;
    vec4 d = (near_t - t) * shape.per_base;
    bvec4 from_beside = both(lessThan(abs(k * c), vec4(ABOUT_STRAIGHT)), greaterThan(d, vec4(-FROM_SOURCE)));
    bvec4 beside = both(greaterThanEqual(near_k, vec4(SOURCE_CURVATURE)), from_beside);
    vec4 near_kappa = mix(near_k, k, beside) * c;
    vec4 passed = near_kappa / max(1.0 - near_kappa * d, FOCUS);
    vec4 far_kappa = mix(passed, k * c, lessThan(k, vec4(SOURCE_CURVATURE)));
    vec4 kappa = 0.5 * (passed + far_kappa);
    vec4 cos_a = 0.5 * kappa * ((1.0 - d) * (1.0 + d)) - d;
    vec4 sin_a = sqrt(max((1.0 - cos_a) * (1.0 + cos_a), 0.0));
    vec4 crossing = cos_a * h + sin_a * p;
    vec4 width = sin_a + kappa * h;
    bvec4 of_one = both(greaterThan(d, vec4(-ALONG_BASE)), lessThanEqual(kappa * (1.0 - d), vec4(STRADDLING)));
    bvec4 is_front = both(both(shape.whole, of_one), greaterThan(width, vec4(0.0)));
    bvec4 after_x1 = greaterThanEqual(crossing, vec4(0.0));
    vec4 n = kappa * (shape.side * shape.side) + (h * sin_a - p * cos_a) * 2.0;
    vec4 root = sqrt(max(1.0 + kappa * n, 0.0));
    vec4 least = mix(vec4(0.0), d, both(upright, not(causal)));
    vec4 rise = max(n / (1.0 + root), least);
    vec4 by_far = t + l;
    vec4 by_near = near_t + near_l;
    vec4 later = t + t * (CLEARLY_LATER * PRECISION);
    vec4 time = t + c * rise;
    bvec4 crosses = both(both(is_front, after_x1), lessThanEqual(crossing, width));
    bvec4 is_first = both(lessThanEqual(time, min(by_far, by_near)), either(not(causal), greaterThanEqual(time, later)));
    bvec4 inside = both(crosses, is_first);
    vec4 far_spread = max(1.0 + far_kappa * rise, FOCUS);
    vec4 near_spread = max(1.0 + near_kappa * (rise - d), FOCUS);
    vec4 spread = far_spread * near_spread;

    // The front that arrives along an edge, taken from the edge that brings it first.
    vec4 grazing = GRAZING * width;
    bvec4 from_far = lessThanEqual(by_far, by_near);
    vec4 edge = mix(near_l, l, from_far);
    vec4 edge_g = mix(near_g, g, from_far);
    bvec4 reaches_far = both(from_far, greaterThanEqual(crossing, -grazing));
    bvec4 is_known = either(not(causal), lessThan(later, by_near));
    bvec4 past_near = both(lessThanEqual(crossing, width + grazing), is_known);
    bvec4 reaches_near = both(not(from_far), past_near);
    bvec4 ahead = both(is_front, either(reaches_far, reaches_near));
    bvec4 turns = both(either(shape.whole, alone), not(ahead));
    bvec4 is_corner = notEqual(tags_of(edge_g) & DIFFRACTS, uvec4(0u));
    bvec4 starts_anew = both(notEqual(tags_of(edge_g) & LACKING, uvec4(0u)), either(either(from_far, is_known), is_corner));
    vec4 edge_k = mix(near_k, k, from_far);

    // Where a border bends away from the front, the fan of rays that it turns is often narrower than a cell.
    vec4 fan = vec4(0.0);
    bvec4 in_fan = bvec4(false);
    bvec4 is_source = both(turns, starts_anew);
    bvec4 to_border = notEqual(tags_of(g0) & LACKING, uvec4(0u));
    if (any(to_border)) {
        vec4 beyond = mix(crossing - width, -crossing, from_far);
        bvec4 from_border = equal(tags_of(edge_g) & (LACKING | DIFFRACTS), uvec4(LACKING));
        bvec4 bends_away = both(greaterThan(beyond, vec4(0.0)), either(from_far, is_known));
        bvec4 opens = both(both(is_front, both(from_border, to_border)), bends_away);
        fan = beyond * FAN * shape.per_base;
        bvec4 is_narrow = both(opens, lessThan(fan * edge, h));
        in_fan = both(is_narrow, greaterThan(fan * max(1.0 + edge_k * edge, FOCUS), abs(edge_k) * h));
        is_source = both(either(is_source, opens), not(is_narrow));
    }
    edge_k = mix(edge_k, vec4(SOURCE_CURVATURE), is_source);

    // The place where the ray crosses the base, the ray's length and the curvature share one division, both for rays
    // through the triangle and for rays along an edge.
    vec4 weighted = (width - crossing) * far_kappa * near_spread + crossing * near_kappa * far_spread;
    vec4 dividend = mix(mix(edge_k, fan, in_fan), weighted * shape.per_base, inside);
    vec4 per = 1.0 / mix(mix(max(1.0 + edge_k * edge, FOCUS), h, in_fan), width * spread, inside);
    vec4 share = crossing * spread * per;
    vec4 ray = mix(edge, c * (root * h * spread * per), inside);
    vec4 gaussian = mix(edge_g, g + share * (near_g - g), inside);
    vec4 curvature = bent(dividend * per, 0.5 * (g0 + gaussian), ray);
    return Fronts(mix(mix(by_near, by_far, from_far), time, inside), curvature, shape.whole);
}

Fronts curved(EndFronts end1, EndFronts end2, vec4 g0, vec4 l1, vec4 l2, vec4 c, bvec4 alone, bvec4 causal) {
    bvec4 swap = lessThan(end1.time, end2.time);
    Shape shape = shape_of(mix(l1, l2, swap), mix(l2, l1, swap), c);
    return curved_in(shape, sqrt(max(shape.height_squared, 0.0)), are_upright(shape), end1, end2, g0, l1, l2, c, alone,
                     causal);
}

// Returns the curvature of a front over a base, in units of 1 over the base. `k` is the curvature at the end that the
// front reaches later, and `near_k` the curvature at the other end. `d` is the time at the other end less the time at
// the later end, in units of the base.
float base_curvature(float k, float near_k, float d, float base) {
    bool beside = near_k >= SOURCE_CURVATURE && abs(k * base) < ABOUT_STRAIGHT && d > -FROM_SOURCE;
    float near_kappa = (beside ? k : near_k) * base;
    float passed = near_kappa / max(1.0 - near_kappa * d, FOCUS);
    return 0.5 * (passed + (k < SOURCE_CURVATURE ? k * base : passed));
}

// Returns whether fronts arrive at the same time as others, up to rounding.
bvec4 together(vec4 time, vec4 other) {
    return lessThanEqual(abs(time - other), TOGETHER * PRECISION * time);
}

// Returns the earlier of two fronts at each point. Of fronts that arrive together, one from a whole triangle is
// preferred. If that does not decide, the flatter front is preferred, since its ray runs straight on.
Fronts earlier_curved(Fronts a, Fronts b) {
    bvec4 alike = equal(uvec4(a.whole), uvec4(b.whole));
    bvec4 flatter = both(alike, lessThan(b.carried, a.carried));
    bvec4 knows = either(both(b.whole, not(a.whole)), flatter);
    bvec4 ties = together(a.time, b.time);
    bvec4 second = either(both(not(ties), lessThan(b.time, a.time)), both(ties, knows));
    return Fronts(min(a.time, b.time), mix(a.carried, b.carried, second),
                  either(both(not(second), a.whole), both(second, b.whole)));
}

// Replaces the present fronts (`time`, `curvature`) by those that a scan brings, where the new ones arrive earlier. Of
// fronts that arrive together, one from a whole triangle is preferred, then one that is flatter by more than
// BENT_APART. If `renews` is set, a present front that the same scan brought is replaced too, at an earlier or later
// time, unless only rounding has changed it. `scan` is counted from 1.
void accept_curved(Fronts fronts, uint scan, bool renews, inout vec4 time, inout vec4 curvature) {
    vec4 tagged = with_tags(fronts.carried, mix(uvec4(scan), uvec4(scan | WHOLE), fronts.whole));
    uvec4 tag_before = tags_of(curvature);
    bvec4 whole_before = greaterThanEqual(tag_before, uvec4(WHOLE));
    bvec4 alike = equal(uvec4(fronts.whole), uvec4(whole_before));
    bvec4 apart = greaterThan(curvature - tagged, abs(tagged) * BENT_APART);
    bvec4 flatter = both(alike, apart);
    bvec4 knows = either(both(fronts.whole, not(whole_before)), flatter);
    bvec4 reached = lessThan(time, vec4(FAR));
    bvec4 ties = both(reached, together(fronts.time, time));
    vec4 rounding = abs(tagged) * (BENT_AGAIN * PRECISION);
    bvec4 bends_alike = both(alike, lessThanEqual(abs(curvature - tagged), rounding));
    bvec4 is_new = not(both(ties, bends_alike));
    bvec4 comes_again = both(both(bvec4(renews), reached), equal(tag_before & SCAN_OF_TAG, uvec4(scan)));
    bvec4 first = either(both(not(ties), lessThan(fronts.time, time)), both(ties, knows));
    // Exact seeds stay: where two fronts meet, an update may take them for one front, which arrives too early.
    bvec4 held = both(both(reached, bvec4(holds)), equal(tag_before & SCAN_OF_TAG, uvec4(EXACT)));
    bvec4 accepted = either(both(first, not(held)), both(comes_again, is_new));
    curvature = mix(curvature, tagged, accepted);
    vec4 arrival = mix(fronts.time, min(time, fronts.time), ties);
    time = mix(time, arrival, accepted);
}

// Returns whether the front (`time`, `curvature`) is kept in place of the other one at the same point.
bool is_first_curved(float time, float curvature, float other, float other_curvature) {
    bool whole = tag_of(curvature) >= WHOLE;
    bool other_whole = tag_of(other_curvature) >= WHOLE;
    bool knows = whole != other_whole ? whole : curvature < other_curvature;
    return together(vec4(other), vec4(time)).x ? knows : time < other;
}

// Returns the largest change of curvature at four points as an equivalent change of times, in units of the last place.
uint change_of_curvature(vec4 before, vec4 curvature, vec4 time) {
    vec4 bends = abs(curvature - before) * time;
    float bend = max(max(bends.x, bends.y), max(bends.z, bends.w)) * (CURVATURE_COUNTS / PRECISION);
    // A larger change than this limit would mean that a front has reached the point for the first time.
    return uint(min(bend, 1.0 / PRECISION));
}
