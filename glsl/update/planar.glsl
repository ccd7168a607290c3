// Implements straight fronts, which carry only their arrival time (paper, section 3).
// Twin: the planar front in src/update.

// Returns the arrival times at x0, given the times `t1` at x1 and `t2` at x2. A front through the triangle arrives no
// earlier than the later of both times.
vec4 planar_in(Shape shape, vec4 t1, vec4 t2, vec4 l1, vec4 l2, vec4 c) {
    vec4 along_edge = edge_step(t1, t2, l1, l2);
    vec4 p = shape.foot;
    vec4 d = (t2 - t1) * shape.per_base;
    bvec4 after_x1 = lessThanEqual(d * shape.side, p);
    bvec4 before_x2 = greaterThanEqual(d * shape.other, p - 1.0);
    bvec4 upwind = both(shape.whole, both(after_x1, before_x2));
    vec4 across = max(shape.height_squared * ((1.0 - d) * (1.0 + d)), 0.0);
    vec4 inside = max(t1 + c * (p * d + sqrt(across)), max(t1, t2));
    return min(along_edge, mix(along_edge, inside, upwind));
}

vec4 planar(vec4 t1, vec4 t2, vec4 l1, vec4 l2, vec4 c) {
    return planar_in(shape_of(l1, l2, c), t1, t2, l1, l2, c);
}
