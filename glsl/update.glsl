// The update of a point x0 from two neighbours x1 and x2, for four triangles at once.
// Twins: planar.rs, point_source.rs and curved.rs in src/update, where the formulas are explained.

// 0 planar, 1 point source, 2 curved: Wavefront in src/update/mod.rs.
layout(constant_id = 2) const int WAVEFRONT = 0;

// Fronts at x1 or x2 of four triangles.
struct Ends {
    vec4 time;
    vec4 curvature;
    vec4 gaussian; // of the surface, tagged where waves diffract
};

// Fronts that arrive at x0 of four triangles.
struct Fronts {
    vec4 time;
    vec4 curvature;
    bvec4 whole; // come from whole triangles, and decide between equal times
};

// The Dijkstra step along an edge (paper, eq. 16).
vec4 edge_step(vec4 t1, vec4 t2, vec4 l1, vec4 l2) {
    return min(t1 + l1, t2 + l2);
}

// Whether all three edges exist, and together are the sides of a triangle with an area.
bvec4 is_proper(vec4 l1, vec4 l2, vec4 c) {
    vec4 longest = max(max(l1, l2), c);
    bvec4 exist = lessThan(longest, vec4(FAR));
    bvec4 enclose = lessThan(longest + longest, l1 + l2 + c);
    return bvec4(uvec4(exist) & uvec4(enclose));
}

vec4 planar(vec4 t1, vec4 t2, vec4 l1, vec4 l2, vec4 c) {
    vec4 along_edge = edge_step(t1, t2, l1, l2);
    vec4 skew = l1 * l1 - l2 * l2;
    vec4 cc = c * c;
    vec4 latest = 0.5 * (cc + skew) / l1;
    vec4 earliest = 0.5 * (skew - cc) / l2;
    vec4 t = min(t1, t2 - earliest);
    vec4 d = min(t2 - t, latest);
    vec4 p = 0.5 * (cc + skew) / c;
    vec4 across = max((l1 - p) * (l1 + p), 0.0) * max((c - d) * (c + d), 0.0);
    vec4 inside = min(along_edge, t + (p * d + sqrt(across)) / c);
    return mix(along_edge, inside, is_proper(l1, l2, c));
}

vec4 point_source(vec4 t1, vec4 t2, vec4 l1, vec4 l2, vec4 c) {
    vec4 along_edge = edge_step(t1, t2, l1, l2);
    bvec4 swap = lessThan(t1, t2);
    vec4 t = mix(t1, t2, swap);
    vec4 near = mix(t2, t1, swap);
    vec4 l = mix(l1, l2, swap);
    vec4 other = mix(l2, l1, swap);
    vec4 p = 0.5 * ((l * l - other * other) + c * c) / c;
    vec4 h = sqrt(max((l - p) * (l + p), 0.0));
    vec4 d = max(near - t, -c);
    vec4 kappa = 1.0 / max(t, 0.25 * c);
    vec4 cos_a = (0.5 * kappa * ((c - d) * (c + d)) - d) / c;
    vec4 sin_a = sqrt(max((1.0 - cos_a) * (1.0 + cos_a), 0.0));
    vec4 crossing = cos_a * h + sin_a * p;
    vec4 n = kappa * (l * l) + (h * sin_a - p * cos_a) * 2.0;
    vec4 inside = min(along_edge, t + n / (1.0 + sqrt(max(1.0 + kappa * n, 0.0))));
    bvec4 in_front = lessThanEqual(cos_a, vec4(1.0));
    bvec4 after_x1 = greaterThanEqual(crossing, vec4(0.0));
    bvec4 before_x2 = lessThanEqual(crossing, c * (sin_a + kappa * h));
    uvec4 upwind = uvec4(in_front) & uvec4(after_x1) & uvec4(before_x2);
    return mix(along_edge, inside, bvec4(upwind & uvec4(is_proper(l1, l2, c))));
}

// Curvature of a front of a developable surface a time later.
vec4 shifted(vec4 curvature, vec4 later) {
    return curvature / max(1.0 + curvature * later, FOCUS);
}

// Curvature of a front after a ray of some length.
vec4 carried(vec4 curvature, vec4 gaussian, vec4 ray) {
    vec4 bend = gaussian * (ray * ray);
    vec4 cosine = 1.0 - 0.5 * bend;
    vec4 sine = ray * (1.0 - bend * (1.0 / 6.0));
    return (curvature * cosine - gaussian * sine) / max(cosine + curvature * sine, FOCUS);
}

bvec4 both(bvec4 a, bvec4 b) {
    return bvec4(uvec4(a) & uvec4(b));
}

bvec4 either(bvec4 a, bvec4 b) {
    return bvec4(uvec4(a) | uvec4(b));
}

Fronts curved(Ends end1, Ends end2, vec4 g0, vec4 l1, vec4 l2, vec4 c) {
    bvec4 whole = is_proper(l1, l2, c);
    bvec4 swap = lessThan(end1.time, end2.time);
    vec4 t = mix(end1.time, end2.time, swap);
    vec4 k = mix(end1.curvature, end2.curvature, swap);
    vec4 g = mix(end1.gaussian, end2.gaussian, swap);
    vec4 l = mix(l1, l2, swap);
    vec4 near_t = mix(end2.time, end1.time, swap);
    vec4 near_k = mix(end2.curvature, end1.curvature, swap);
    vec4 near_g = mix(end2.gaussian, end1.gaussian, swap);
    vec4 near_l = mix(l2, l1, swap);
    vec4 p = 0.5 * ((l * l - near_l * near_l) + c * c) / c;
    vec4 h = sqrt(max((l - p) * (l + p), 0.0));
    vec4 lead = near_t - t;
    vec4 d = max(lead, -c);
    vec4 passed = shifted(near_k, -d);
    bvec4 bent = lessThan(k, vec4(SOURCE_CURVATURE));
    vec4 kappa = mix(passed, 0.5 * (passed + k), bent);
    vec4 cos_a = (0.5 * kappa * ((c - d) * (c + d)) - d) / c;
    vec4 sin_a = sqrt(max((1.0 - cos_a) * (1.0 + cos_a), 0.0));
    vec4 crossing = cos_a * h + sin_a * p;
    vec4 width = c * (sin_a + kappa * h);
    bvec4 in_front = both(lessThanEqual(cos_a, vec4(1.0)), greaterThan(width, vec4(0.0)));
    bvec4 is_front = both(both(whole, greaterThan(lead, -c)), in_front);
    vec4 grazing = GRAZING * width;
    bvec4 after_x1 = greaterThanEqual(crossing, vec4(0.0));
    bvec4 inside = both(is_front, both(after_x1, lessThanEqual(crossing, width)));

    vec4 n = kappa * (l * l) + (h * sin_a - p * cos_a) * 2.0;
    vec4 time = t + n / (1.0 + sqrt(max(1.0 + kappa * n, 0.0)));
    vec4 share = crossing / width;
    vec4 across = p - share * c;
    vec4 ray = sqrt(across * across + h * h);
    vec4 far_k = shifted(mix(kappa, k, bent), time - ray - t);
    vec4 from_k = far_k + share * (shifted(near_k, time - ray - near_t) - far_k);
    vec4 gaussian = 0.5 * (g0 + (g + share * (near_g - g)));
    vec4 curvature = carried(from_k, gaussian, ray);

    // Along the edge of the end from which it arrives first.
    bvec4 reaches_far = both(is_front, greaterThanEqual(crossing, -grazing));
    bvec4 reaches_near = both(is_front, lessThanEqual(crossing, width + grazing));
    bvec4 from_far = lessThanEqual(t + l, near_t + near_l);
    vec4 edge = mix(near_l, l, from_far);
    vec4 edge_g = mix(near_g, g, from_far);
    bvec4 reaches = either(both(from_far, reaches_far), both(not(from_far), reaches_near));
    bvec4 corner = equal(floatBitsToUint(edge_g) & 7u, uvec4(1u));
    bvec4 diffracted = both(both(whole, not(reaches)), corner);
    vec4 edge_k = mix(mix(near_k, k, from_far), vec4(SOURCE_CURVATURE), diffracted);
    vec4 edge_time = mix(near_t, t, from_far) + edge;

    return Fronts(mix(edge_time, time, inside),
                  mix(carried(edge_k, 0.5 * (g0 + edge_g), edge), curvature, inside), whole);
}

// The fronts at x0, whose surface has the Gaussian curvature g0: at FAR or later if neither x1
// nor x2 is reached.
Fronts update(Ends end1, Ends end2, vec4 g0, vec4 l1, vec4 l2, vec4 c) {
    if (WAVEFRONT == 2) return curved(end1, end2, g0, l1, l2, c);
    vec4 time = WAVEFRONT == 1 ? point_source(end1.time, end2.time, l1, l2, c)
                               : planar(end1.time, end2.time, l1, l2, c);
    return Fronts(time, vec4(0.0), bvec4(false));
}

// The earlier of two fronts at each point.
Fronts earlier(Fronts a, Fronts b) {
    bvec4 tie = both(b.whole, equal(b.time, a.time));
    bvec4 second = either(lessThan(b.time, a.time), tie);
    return Fronts(mix(a.time, b.time, second), mix(a.curvature, b.curvature, second),
                  either(both(not(second), a.whole), both(second, b.whole)));
}
