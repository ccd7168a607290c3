// Implements fronts that are circles around a virtual point source. The distance from this source is the arrival time,
// so these fronts carry nothing besides their time.
// Twin: the circular front in src/update, where the formulas are explained.

// Returns the curvature of a front over a base, in units of 1 over the base. `time` is the arrival time at the end that
// the front reaches later.
float circular_curvature(float time, float base) {
    return base / max(time, 0.25 * base);
}

// Returns the arrival times at x0, given the times `t1` at x1 and `t2` at x2. `shape` is the triangle as seen from the
// end that the front reaches later, and `h` is its height over the base.
vec4 circular_in(Shape shape, vec4 h, vec4 t1, vec4 t2, vec4 l1, vec4 l2, vec4 c) {
    vec4 along_edge = edge_step(t1, t2, l1, l2);
    bvec4 swap = lessThan(t1, t2);
    vec4 t = mix(t1, t2, swap);
    vec4 near = mix(t2, t1, swap);
    vec4 p = shape.foot;
    vec4 d = (near - t) * shape.per_base;
    vec4 kappa = c / max(t, 0.25 * c);
    vec4 cos_a = 0.5 * kappa * ((1.0 - d) * (1.0 + d)) - d;
    vec4 sin_a = sqrt(max((1.0 - cos_a) * (1.0 + cos_a), 0.0));
    vec4 crossing = cos_a * h + sin_a * p;
    vec4 width = sin_a + kappa * h;
    bvec4 of_one = lessThanEqual(kappa * (1.0 - d), vec4(STRADDLING));
    bvec4 after_x1 = greaterThanEqual(crossing, vec4(0.0));
    bvec4 before_x2 = lessThanEqual(crossing, width);
    bvec4 upwind = both(both(shape.whole, of_one), both(after_x1, before_x2));
    vec4 n = kappa * (shape.side * shape.side) + (h * sin_a - p * cos_a) * 2.0;
    vec4 inside = t + c * (n / (1.0 + sqrt(max(1.0 + kappa * n, 0.0))));
    inside = mix(inside, max(inside, t), bvec4(causal));
    return min(along_edge, mix(along_edge, inside, upwind));
}

vec4 circular(vec4 t1, vec4 t2, vec4 l1, vec4 l2, vec4 c) {
    bvec4 swap = lessThan(t1, t2);
    Shape shape = shape_of(mix(l1, l2, swap), mix(l2, l1, swap), c);
    return circular_in(shape, sqrt(max(shape.height_squared, 0.0)), t1, t2, l1, l2, c);
}
