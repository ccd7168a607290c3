// The update of a point x0 from two neighbours x1 and x2, for four triangles at once.
// Twins: planar.rs, point_source.rs and curved.rs in src/update, where the formulas are explained.

// 0 planar, 1 point source, 2 curved, 3 with anchors (anchored.glsl): Wavefront in src/update/mod.rs.
layout(constant_id = 2) const int WAVEFRONT = 0;
const bool HAS_ANCHORS = WAVEFRONT == 3;
// Whether fronts carry anything beside their arrival time: their curvature, or the number of their anchor.
const bool HAS_TWO_LAYERS = WAVEFRONT >= 2;

// Distance from 1 to the next number.
const float PRECISION = 1.1920929e-7;

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

bvec4 both(bvec4 a, bvec4 b) {
    return bvec4(uvec4(a) & uvec4(b));
}

bvec4 either(bvec4 a, bvec4 b) {
    return bvec4(uvec4(a) | uvec4(b));
}

// The Dijkstra step along an edge (paper, eq. 16).
vec4 edge_step(vec4 t1, vec4 t2, vec4 l1, vec4 l2) {
    return min(t1 + l1, t2 + l2);
}

// A triangle in units of its base, seen from one end of it.
struct Shape {
    vec4 per_base;       // 1 over the length of the base
    vec4 side;           // from this end of the base to x0
    vec4 other;          // from the other end to x0
    vec4 foot;           // from this end to the foot of x0 on the base
    vec4 height_squared; // of x0 over the base
    bvec4 whole;         // all three edges exist and enclose an area
};

Shape shape_of(vec4 side, vec4 other, vec4 base) {
    Shape shape;
    shape.per_base = 1.0 / base;
    shape.side = side * shape.per_base;
    shape.other = other * shape.per_base;
    shape.foot = 0.5 * ((shape.side * shape.side - shape.other * shape.other) + 1.0);
    shape.height_squared = (shape.side - shape.foot) * (shape.side + shape.foot);
    bvec4 exists = both(lessThan(shape.height_squared, vec4(FAR)), lessThan(base, vec4(FAR)));
    shape.whole = both(greaterThan(shape.height_squared, vec4(0.0)), exists);
    return shape;
}

vec4 planar(vec4 t1, vec4 t2, vec4 l1, vec4 l2, vec4 c) {
    vec4 along_edge = edge_step(t1, t2, l1, l2);
    Shape shape = shape_of(l1, l2, c);
    vec4 p = shape.foot;
    vec4 d = (t2 - t1) * shape.per_base;
    bvec4 after_x1 = lessThanEqual(d * shape.side, p);
    bvec4 before_x2 = greaterThanEqual(d * shape.other, p - 1.0);
    bvec4 upwind = both(shape.whole, both(after_x1, before_x2));
    vec4 across = max(shape.height_squared * ((1.0 - d) * (1.0 + d)), 0.0);
    vec4 inside = t1 + c * (p * d + sqrt(across));
    return min(along_edge, mix(along_edge, inside, upwind));
}

vec4 point_source(vec4 t1, vec4 t2, vec4 l1, vec4 l2, vec4 c) {
    vec4 along_edge = edge_step(t1, t2, l1, l2);
    bvec4 swap = lessThan(t1, t2);
    vec4 t = mix(t1, t2, swap);
    vec4 near = mix(t2, t1, swap);
    Shape shape = shape_of(mix(l1, l2, swap), mix(l2, l1, swap), c);
    vec4 p = shape.foot;
    vec4 h = sqrt(max(shape.height_squared, 0.0));
    vec4 d = (near - t) * shape.per_base;
    vec4 kappa = c / max(t, 0.25 * c);
    vec4 cos_a = 0.5 * kappa * ((1.0 - d) * (1.0 + d)) - d;
    vec4 sin_a = sqrt(max((1.0 - cos_a) * (1.0 + cos_a), 0.0));
    vec4 crossing = cos_a * h + sin_a * p;
    vec4 width = sin_a + kappa * h;
    bvec4 in_front = both(greaterThanEqual(d, vec4(-1.0)), lessThanEqual(cos_a, vec4(1.0)));
    bvec4 after_x1 = greaterThanEqual(crossing, vec4(0.0));
    bvec4 before_x2 = lessThanEqual(crossing, width);
    bvec4 upwind = both(both(shape.whole, in_front), both(after_x1, before_x2));
    vec4 n = kappa * (shape.side * shape.side) + (h * sin_a - p * cos_a) * 2.0;
    vec4 inside = t + c * (n / (1.0 + sqrt(max(1.0 + kappa * n, 0.0))));
    return min(along_edge, mix(along_edge, inside, upwind));
}

// Curvature at the end of a ray, from what it would be on a developable surface.
vec4 bent(vec4 curvature, vec4 gaussian, vec4 ray) {
    vec4 x = curvature * ray;
    return curvature - gaussian * ray * (1.0 - x + x * x * (1.0 / 3.0));
}

Fronts curved(Ends end1, Ends end2, vec4 g0, vec4 l1, vec4 l2, vec4 c, bvec4 alone) {
    bvec4 swap = lessThan(end1.time, end2.time);
    vec4 t = mix(end1.time, end2.time, swap);
    vec4 near_t = mix(end2.time, end1.time, swap);
    vec4 k = mix(end1.curvature, end2.curvature, swap);
    vec4 near_k = mix(end2.curvature, end1.curvature, swap);
    vec4 g = mix(end1.gaussian, end2.gaussian, swap);
    vec4 near_g = mix(end2.gaussian, end1.gaussian, swap);
    vec4 l = mix(l1, l2, swap);
    vec4 near_l = mix(l2, l1, swap);
    Shape shape = shape_of(l, near_l, c);
    vec4 p = shape.foot;
    vec4 h = sqrt(max(shape.height_squared, 0.0));
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
    bvec4 in_front = both(greaterThan(d, vec4(-1.0)), lessThanEqual(cos_a, vec4(1.0)));
    bvec4 is_front = both(both(shape.whole, in_front), greaterThan(width, vec4(0.0)));
    bvec4 after_x1 = greaterThanEqual(crossing, vec4(0.0));
    vec4 n = kappa * (shape.side * shape.side) + (h * sin_a - p * cos_a) * 2.0;
    vec4 root = sqrt(max(1.0 + kappa * n, 0.0));
    vec4 rise = n / (1.0 + root);
    bvec4 crosses = both(both(is_front, after_x1), lessThanEqual(crossing, width));
    bvec4 inside = both(crosses, either(not(beside), greaterThanEqual(rise, d)));
    vec4 far_spread = max(1.0 + far_kappa * rise, FOCUS);
    vec4 near_spread = max(1.0 + near_kappa * (rise - d), FOCUS);
    vec4 spread = far_spread * near_spread;

    // Along the edge of the end from which it arrives first.
    vec4 grazing = GRAZING * width;
    vec4 by_far = t + l;
    vec4 by_near = near_t + near_l;
    bvec4 from_far = lessThanEqual(by_far, by_near);
    vec4 edge = mix(near_l, l, from_far);
    vec4 edge_g = mix(near_g, g, from_far);
    bvec4 reaches_far = both(from_far, greaterThanEqual(crossing, -grazing));
    bvec4 reaches_near = both(not(from_far), lessThanEqual(crossing, width + grazing));
    bvec4 ahead = both(is_front, either(reaches_far, reaches_near));
    bvec4 turns = both(either(shape.whole, alone), not(ahead));
    bvec4 corner = equal(floatBitsToUint(edge_g) & 15u, uvec4(1u));
    vec4 edge_k = mix(mix(near_k, k, from_far), vec4(SOURCE_CURVATURE), both(turns, corner));

    // One division serves the ray's place, its length and the curvature, whichever way it runs.
    vec4 weighted = (width - crossing) * far_kappa * near_spread + crossing * near_kappa * far_spread;
    vec4 dividend = mix(edge_k, weighted * shape.per_base, inside);
    vec4 per = 1.0 / mix(max(1.0 + edge_k * edge, FOCUS), width * spread, inside);
    vec4 share = crossing * spread * per;
    vec4 ray = mix(edge, c * (root * h * spread * per), inside);
    vec4 gaussian = mix(edge_g, g + share * (near_g - g), inside);
    vec4 curvature = bent(dividend * per, 0.5 * (g0 + gaussian), ray);
    return Fronts(mix(mix(by_near, by_far, from_far), t + c * rise, inside), curvature, shape.whole);
}

// Whether of x1 and x2 only the one across the diagonal is there, given the edges to the other, along
// an axis of the grid: fronts are then taken to have come around a hole's corner.
bvec4 are_alone(vec4 beside) {
    return greaterThanEqual(beside, vec4(FAR));
}

// The fronts at x0, whose surface has the Gaussian curvature g0: at FAR or later if neither x1
// nor x2 is reached.
Fronts update(Ends end1, Ends end2, vec4 g0, vec4 l1, vec4 l2, vec4 c, bvec4 alone) {
    if (WAVEFRONT == 2) return curved(end1, end2, g0, l1, l2, c, alone);
    vec4 time = WAVEFRONT == 0 ? planar(end1.time, end2.time, l1, l2, c)
                               : point_source(end1.time, end2.time, l1, l2, c);
    return Fronts(time, vec4(0.0), bvec4(false));
}

// Whether fronts arrive at the same time as others, but for rounding.
bvec4 together(vec4 time, vec4 other) {
    return lessThanEqual(abs(time - other), TOGETHER * PRECISION * time);
}

// The earlier of two fronts at each point. Of those that arrive together a whole triangle knows
// better, then the one that sees the ray run straight on, whose front is the flatter.
Fronts earlier(Fronts a, Fronts b) {
    vec4 time = min(a.time, b.time);
    if (WAVEFRONT < 2) return Fronts(time, vec4(0.0), bvec4(false));
    bvec4 alike = equal(uvec4(a.whole), uvec4(b.whole));
    bvec4 flatter = both(alike, lessThan(b.curvature, a.curvature));
    bvec4 knows = either(both(b.whole, not(a.whole)), flatter);
    bvec4 ties = together(a.time, b.time);
    bvec4 second = either(both(not(ties), lessThan(b.time, a.time)), both(ties, knows));
    return Fronts(time, mix(a.curvature, b.curvature, second),
                  either(both(not(second), a.whole), both(second, b.whole)));
}

// The earlier of the fronts of two points, through their left triangles in xy and their right ones in zw.
Fronts of_sides(Fronts sided) {
    return earlier(Fronts(sided.time.xyxy, sided.curvature.xyxy, sided.whole.xyxy),
                   Fronts(sided.time.zwzw, sided.curvature.zwzw, sided.whole.zwzw));
}
