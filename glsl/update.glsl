// The update of a point x0 from two neighbours x1 and x2, for four triangles at once.
// Twins: src/update/planar.rs and src/update/point_source.rs, where the formulas are explained.

layout(constant_id = 2) const bool POINT_SOURCE = true;

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

// The arrival time at x0: FAR or later if neither x1 nor x2 is reached.
vec4 update(vec4 t1, vec4 t2, vec4 l1, vec4 l2, vec4 c) {
    return POINT_SOURCE ? point_source(t1, t2, l1, l2, c) : planar(t1, t2, l1, l2, c);
}
