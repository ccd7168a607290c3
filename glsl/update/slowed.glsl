// Implements updates where the slowness differs between the corners of a triangle. The slowness is linear along each
// edge, and an edge costs its length times the mean slowness of its ends. Lengths `l1`, `l2` and `c` are such costs.
// Twin: crates/surface/src/update/slowed.rs, where the formulas are explained.

// Returns 1 where the slowness jumps at one of three points, else 0. `a`, `b` and `c` are their slownesses, which have
// the tag JUMPS beside a jump.
vec4 jump_of(vec4 a, vec4 b, vec4 c) {
    return vec4(notEqual((tags_of(a) | tags_of(b) | tags_of(c)) & JUMPS, uvec4(0u)));
}

// Returns where the slownesses at the corners of a triangle differ so much that a single step does not find the place
// where the ray crosses the base.
bvec4 are_uneven(vec4 s0, vec4 s1, vec4 s2) {
    vec4 range = max(max(s1, s2), s0) - min(min(s1, s2), s0);
    return greaterThan(range, EVEN_CORNERS * (s1 + s2));
}

// Returns the shape of a triangle on the surface from the costs of its edges. `of_side` and `of_other` are the mean
// slownesses along these two edges, divided by the mean slowness along the base.
Shape shape_on_surface(vec4 side, vec4 other, vec4 base, vec4 of_side, vec4 of_other) {
    Shape shape = shape_of(side / of_side, other / of_other, base);
    shape.whole = both(shape.whole, lessThan(max(max(side, other), base), vec4(FAR)));
    return shape;
}

// Returns whether triangles are obtuse at x0 on the surface, without the slowness. `s0`, `s1` and `s2` are the
// slownesses at x0, x1 and x2, by which the costs of the edges are divided.
bvec4 are_obtuse_on_surface(vec4 l1, vec4 l2, vec4 c, vec4 s0, vec4 s1, vec4 s2) {
    vec4 per_base_slowness = 1.0 / (s1 + s2);
    Shape shape = shape_on_surface(l1, l2, c, (s0 + s1) * per_base_slowness, (s0 + s2) * per_base_slowness);
    vec4 squares = shape.side * shape.side + shape.other * shape.other;
    return both(lessThan(c, vec4(FAR)), lessThan(squares, vec4(OBTUSE)));
}

// Costs of the rays from the base to x0, in units of the cost of the base. The ray from the place w of the base costs
// sqrt((w - foot)^2 + height^2) (near + slope w). Places count from 0 at one end of the base to 1 at the other end.
// `near` is the mean slowness along the ray from place 0, divided by the mean slowness along the base. `slope` is the
// same for the ray from place 1, less `near`. `uneven` tells where the slowness is uneven (are_uneven()).
struct Rays {
    vec4 foot, height;
    vec4 near, slope;
    bvec4 uneven;
};

// Arrival time of a front along the base, in units of the cost of the base: the time of a circular front of curvature
// `kappa`, less a bulge. The derivative of the circle's time along the base is `-cos_a` at the later end. `bulge` is the
// part of the time's second derivative that a smoothly varying slowness adds to that of the circle.
struct Slope {
    vec4 kappa, cos_a, sin_a, bulge;
};

// Returns the places that the law of refraction gives for straight fronts, whose times along the base rise by `d`.
vec4 refracted_place(Rays rays, vec4 d) {
    vec4 across = rays.near + rays.slope * clamp(rays.foot, 0.0, 1.0);
    vec4 steepest = mix(vec4(STEEPEST), vec4(STEEPEST_GUESS), rays.uneven);
    vec4 cosine = clamp(-(d + rays.slope * rays.height) / across, -steepest, steepest);
    return clamp(rays.foot + rays.height * cosine / sqrt((1.0 - cosine) * (1.0 + cosine)), 0.0, 1.0);
}

// Returns the next places by a step of Newton's method for straight fronts.
vec4 next_place(Rays rays, vec4 d, vec4 place) {
    vec4 from_foot = place - rays.foot;
    vec4 squared_height = rays.height * rays.height;
    vec4 squared = from_foot * from_foot + squared_height;
    vec4 mean = rays.near + rays.slope * place;
    vec4 falls = d * sqrt(squared) + mean * from_foot + rays.slope * squared;
    vec4 convex = squared_height * mean;
    vec4 bends = convex + 2.0 * rays.slope * from_foot * squared;
    return clamp(place - falls * squared / max(bends, 0.25 * convex), 0.0, 1.0);
}

// Returns the next places by a step of Newton's method, on the line of the base beyond its ends too.
vec4 place_beyond(Slope front, Rays rays, vec4 place) {
    vec4 squared = rays.height * rays.height;
    vec4 n = (front.kappa * place - front.cos_a * 2.0) * place;
    vec4 per_root = 1.0 / sqrt(max(1.0 + front.kappa * n, 1e-4));
    vec4 along = front.kappa * place - front.cos_a;
    vec4 from_foot = place - rays.foot;
    vec4 per_distance = 1.0 / sqrt(from_foot * from_foot + squared);
    vec4 mean = rays.near + rays.slope * place;
    vec4 cosine = from_foot * per_distance;
    vec4 squared_distance = from_foot * from_foot + squared;
    vec4 falls = along * per_root - front.bulge * (0.5 - place) + mean * cosine + rays.slope * (squared_distance * per_distance);
    vec4 spreads = max(front.kappa, 0.0) * (front.sin_a * front.sin_a) * (per_root * per_root * per_root);
    vec4 convex = spreads + squared * mean * (per_distance * per_distance * per_distance);
    vec4 bends = convex + 2.0 * rays.slope * cosine + front.bulge;
    return place - falls / max(bends, 0.25 * convex);
}

// Returns the costs of the rays from places of the base.
vec4 cost_of_ray(Rays rays, vec4 place) {
    vec4 from_foot = place - rays.foot;
    return sqrt(from_foot * from_foot + rays.height * rays.height) * (rays.near + rays.slope * place);
}

// Returns the time from the front's arrival at the later end of the base until it arrives at x0 through a place.
vec4 rise_through(Slope front, Rays rays, vec4 place) {
    vec4 n = (front.kappa * place - front.cos_a * 2.0) * place;
    vec4 root = sqrt(max(1.0 + front.kappa * n, 1e-4));
    return n / (1.0 + root) - 0.5 * front.bulge * (place * (1.0 - place)) + cost_of_ray(rays, place);
}

// Returns the curvatures of fronts after lengths in which they spread as on a plane, 0 where they would meet their focus.
vec4 spread_by(vec4 curvature, vec4 length) {
    vec4 goes_on = 1.0 + curvature * length;
    return mix(curvature / goes_on, vec4(0.0), lessThan(goes_on, vec4(FOCUS)));
}

// Returns the arrival times at x0 of straight fronts, given the slowness `s0` at x0.
vec4 planar_slowed(EndFronts end1, EndFronts end2, vec4 s0, vec4 l1, vec4 l2, vec4 c) {
    vec4 along_edge = edge_step(end1.time, end2.time, l1, l2);
    vec4 per_base_slowness = 1.0 / (end1.slowness + end2.slowness);
    vec4 from_x1 = (s0 + end1.slowness) * per_base_slowness;
    vec4 from_x2 = (s0 + end2.slowness) * per_base_slowness;
    Shape shape = shape_on_surface(l1, l2, c, from_x1, from_x2);
    vec4 d = (end2.time - end1.time) * shape.per_base;
    // Where there is no triangle, the following values are discarded, but NaN could spread from them.
    vec4 height = sqrt(mix(vec4(1.0), shape.height_squared, shape.whole));
    Rays rays = Rays(shape.foot, height, from_x1, from_x2 - from_x1, are_uneven(s0, end1.slowness, end2.slowness));
    vec4 place = next_place(rays, d, refracted_place(rays, d));
    if (any(rays.uneven)) {
        place = mix(place, next_place(rays, d, next_place(rays, d, place)), rays.uneven);
    }
    bvec4 within = both(greaterThan(place, vec4(0.0)), lessThan(place, vec4(1.0)));
    vec4 time = max(end1.time + c * (d * place + cost_of_ray(rays, place)), max(end1.time, end2.time));
    return min(along_edge, mix(along_edge, time, both(shape.whole, within)));
}

// Returns the curved fronts at x0, given the Gaussian curvature `g0` and the slowness `s0` there. `alone` tells where
// only one of x1 and x2 is present, across the grid's diagonal.
Fronts curved_slowed(EndFronts end1, EndFronts end2, vec4 g0, vec4 s0, vec4 l1, vec4 l2, vec4 c, bvec4 alone) {
    bvec4 swap = lessThan(end1.time, end2.time);
    vec4 t = mix(end1.time, end2.time, swap);
    vec4 near_t = mix(end2.time, end1.time, swap);
    vec4 k = mix(end1.carried, end2.carried, swap);
    vec4 near_k = mix(end2.carried, end1.carried, swap);
    vec4 g = mix(end1.surface, end2.surface, swap);
    vec4 near_g = mix(end2.surface, end1.surface, swap);
    vec4 l = mix(l1, l2, swap);
    vec4 near_l = mix(l2, l1, swap);
    vec4 s = mix(end1.slowness, end2.slowness, swap);
    vec4 near_s = mix(end2.slowness, end1.slowness, swap);
    vec4 jump = jump_of(s0, end1.slowness, end2.slowness);
    vec4 per_base_slowness = 1.0 / (s + near_s);
    vec4 own = (s0 + s0) * per_base_slowness;
    vec4 far = (s + s) * per_base_slowness;
    vec4 near = (near_s + near_s) * per_base_slowness;
    vec4 from_far = 0.5 * (own + far);
    vec4 from_near = 0.5 * (own + near);
    Shape shape = shape_on_surface(l, near_l, c, from_far, from_near);
    vec4 p = shape.foot;
    vec4 h = sqrt(mix(vec4(1.0), shape.height_squared, shape.whole));
    vec4 d = (near_t - t) * shape.per_base;
    bvec4 from_beside = both(lessThan(abs(k * c), vec4(ABOUT_STRAIGHT)), greaterThan(d, vec4(-FROM_SOURCE)));
    bvec4 beside = both(greaterThanEqual(near_k, vec4(SOURCE_CURVATURE)), from_beside);
    vec4 own_kappa = k * c * (1.0 + jump * (far * far - 1.0));
    vec4 near_kappa = mix(near_k * c * (1.0 + jump * (near * near - 1.0)), own_kappa, beside);
    vec4 passed = near_kappa / max(1.0 - near_kappa * d, FOCUS);
    vec4 far_kappa = mix(passed, own_kappa, lessThan(k, vec4(SOURCE_CURVATURE)));
    vec4 kappa = 0.5 * (passed + far_kappa);
    vec4 cos_a = 0.5 * kappa * ((1.0 - d) * (1.0 + d)) - d;
    vec4 sin_a = sqrt(max((1.0 - cos_a) * (1.0 + cos_a), 0.0));
    vec4 width = sin_a + kappa * h;
    bvec4 of_one = both(greaterThan(d, vec4(-ALONG_BASE)), lessThanEqual(kappa * (1.0 - d), vec4(STRADDLING)));
    bvec4 is_front = both(both(shape.whole, of_one), greaterThan(width, vec4(0.0)));
    vec4 along = clamp(d, -1.0, 1.0);
    vec4 across = sqrt(max((1.0 - along) * (1.0 + along), 0.0));
    vec4 rises = (own - (far + p * (near - far))) / h;
    vec4 bulge = (1.0 - jump) * (along * (near - far) - across * rises);
    Rays rays = Rays(p, h, from_far, from_near - from_far, are_uneven(s0, end1.slowness, end2.slowness));
    Slope front = Slope(kappa, cos_a, sin_a, bulge);
    vec4 guess = clamp((cos_a * h + sin_a * p) / max(width, 1e-6), 0.0, 1.0);
    // Where the slowness jumps, the guess is the place of a straight front instead.
    guess = guess + (refracted_place(rays, d) - guess) * jump;
    vec4 beyond = place_beyond(front, rays, guess);
    if (any(rays.uneven)) {
        vec4 next = clamp(place_beyond(front, rays, clamp(beyond, 0.0, 1.0)), 0.0, 1.0);
        beyond = mix(beyond, place_beyond(front, rays, next), rays.uneven);
    }
    vec4 place = clamp(beyond, 0.0, 1.0);
    vec4 rise = rise_through(front, rays, place);
    vec4 by_far = t + l;
    vec4 by_near = near_t + near_l;
    vec4 later = t + t * (CLEARLY_LATER * PRECISION);
    vec4 least = mix(vec4(0.0), d, both(are_upright(shape), bvec4(!causal)));
    vec4 time = t + c * max(rise, least);
    bvec4 within = both(greaterThan(place, vec4(0.0)), lessThan(place, vec4(1.0)));
    bvec4 is_first = both(lessThanEqual(time, min(by_far, by_near)), either(bvec4(!causal), greaterThanEqual(time, later)));
    bvec4 inside = both(both(is_front, within), is_first);

    // The front that arrives along an edge, taken from the edge that brings it first.
    bvec4 is_from_far = lessThanEqual(by_far, by_near);
    vec4 edge = mix(near_l, l, is_from_far);
    vec4 edge_g = mix(near_g, g, is_from_far);
    vec4 edge_s = mix(near, far, is_from_far);
    bvec4 reaches_far = both(is_from_far, greaterThanEqual(beyond, vec4(-GRAZING)));
    bvec4 is_known = either(bvec4(!causal), lessThan(later, by_near));
    bvec4 past_near = both(lessThanEqual(beyond, vec4(1.0 + GRAZING)), is_known);
    bvec4 reaches_near = both(not(is_from_far), past_near);
    bvec4 ahead = both(is_front, either(reaches_far, reaches_near));
    bvec4 turns = both(either(shape.whole, alone), not(ahead));
    bvec4 is_corner = notEqual(tags_of(edge_g) & DIFFRACTS, uvec4(0u));
    bvec4 starts_anew = both(notEqual(tags_of(edge_g) & LACKING, uvec4(0u)), either(either(is_from_far, is_known), is_corner));
    vec4 edge_k = mix(near_k, k, is_from_far);

    // The fan of rays that a border turns, as in curved.glsl, from the shape of the front without the bulge.
    vec4 sight = cos_a * h + sin_a * p;
    vec4 past = mix(sight - width, -sight, is_from_far);
    vec4 fan = past * FAN * shape.per_base;
    bvec4 from_border = equal(tags_of(edge_g) & (LACKING | DIFFRACTS), uvec4(LACKING));
    bvec4 to_border = notEqual(tags_of(g0) & LACKING, uvec4(0u));
    bvec4 bends_away = both(greaterThan(past, vec4(0.0)), either(is_from_far, is_known));
    bvec4 opens = both(both(is_front, both(from_border, to_border)), bends_away);
    bvec4 is_narrow = both(opens, lessThan(fan * edge, h));
    bvec4 in_fan = both(is_narrow, greaterThan(fan * max(1.0 + edge_k * edge, FOCUS), abs(edge_k) * h));
    bvec4 is_source = both(either(both(turns, starts_anew), opens), not(is_narrow));
    edge_k = mix(edge_k, vec4(SOURCE_CURVATURE), is_source);

    vec4 from = far + place * (near - far);
    vec4 spreads = 1.0 + jump * (1.0 / (from * own) - 1.0);
    vec4 spread = max(rise, 0.0) * spreads;
    vec4 far_end = spread_by(far_kappa, spread);
    vec4 near_end = spread_by(near_kappa, spread - d * spreads);
    vec4 per_own = 1.0 / (own * own);
    vec4 through = (far_end + place * (near_end - far_end)) * shape.per_base * (1.0 + jump * (per_own - 1.0));
    vec4 edge_spread = edge * (1.0 + jump * (edge_s / own - 1.0));
    vec4 by_edge = mix(spread_by(edge_k, edge_spread), fan / h, in_fan) * (1.0 + jump * (edge_s * edge_s * per_own - 1.0));
    vec4 from_foot = place - p;
    vec4 ray_length = sqrt(from_foot * from_foot + h * h);
    vec4 ray = mix(edge, c * ray_length * (from_far + place * (from_near - from_far)), inside);
    vec4 gaussian = mix(edge_g, g + place * (near_g - g), inside);
    gaussian = (0.5 * (g0 + gaussian)) * (1.0 - jump);
    vec4 curvature = bent(mix(by_edge, through, inside), gaussian, ray);
    return Fronts(mix(mix(by_near, by_far, is_from_far), time, inside), curvature, shape.whole);
}
