// The front at x0 where two arcs of different curvature touch on the base of its triangle.
// Include after update.glsl and front.glsl. Twin: src/update/two_arcs.rs, where the formulas are explained.

// A triangle, with the fronts at x1 and x2 and the surface's Gaussian curvature at x0, x1 and x2.
struct Base {
    vec2 time;
    vec2 curvature;
    vec3 gaussian;
    vec2 sides; // to x1 and x2
    float base;
};

// A point on the other side of the base from x0, and the front there.
struct Across {
    float time;
    float curvature;
    vec2 sides; // to x1 and x2
};

// A circular front at the time when it arrives at a place.
struct Arc {
    vec2 place;
    vec2 ahead; // the direction of its ray there
    float curvature;
};

float excess(Arc arc, vec2 to) {
    vec2 way = to - arc.place;
    return arc.curvature * dot(way, way) + 2.0 * dot(arc.ahead, way);
}

// How many times as far from the centre another place is.
float spread_of(Arc arc, vec2 to) {
    return sqrt(max(1.0 + arc.curvature * excess(arc, to), 0.0));
}

// How much later it arrives there.
float rise_of(Arc arc, vec2 to) {
    return excess(arc, to) / (1.0 + spread_of(arc, to));
}

// The direction of the ray there, times the spread.
vec2 ray_of(Arc arc, vec2 to) {
    return arc.ahead + arc.curvature * (to - arc.place);
}

// Positive if b points to the right of a, which is the side of x1 for what runs upwards.
float clockwise(vec2 a, vec2 b) {
    return a.y * b.x - a.x * b.y;
}

// The foot of the corner over the base, from x2, and the square of its height, in units of the base;
// that is not positive where an edge is missing.
vec2 corner_over(vec2 sides, float base) {
    vec2 side = sides * (1.0 / base);
    // Compilers that factor out squares round otherwise than the twin.
    precise float foot = 0.5 * ((side.y * side.y - side.x * side.x) + 1.0);
    float height_squared = (side.y - foot) * (side.y + foot);
    bool exists = base < FAR && height_squared < FAR;
    return vec2(foot, exists ? height_squared : -1.0);
}

// Whether the fronts at both ends of bases are arcs of different curvature.
bvec4 are_two_arcs(Ends end1, Ends end2) {
    vec4 k1 = end1.curvature;
    vec4 k2 = end2.curvature;
    vec4 bend = (k2 - k1) - k1 * k2 * (end1.time - end2.time);
    bvec4 apart = greaterThan(abs(bend), ARCS_APART * max(abs(k1), abs(k2)));
    bvec4 reached = lessThan(max(end1.time, end2.time), vec4(FAR));
    return both(both(apart, reached), lessThan(max(k1, k2), vec4(SOURCE_CURVATURE)));
}

// Whether a point across a base is of the same arc as one of its ends, all given by time and curvature.
bool is_of_same(vec2 end, vec2 other, vec2 across) {
    vec2 spreads = max(1.0 - vec2(other.y, across.y) * (vec2(other.x, across.x) - end.x), FOCUS);
    float apart = ARCS_ALIKE * abs(other.y - end.y * spreads.x);
    return across.x < FAR && abs(across.y - end.y * spreads.y) * spreads.x <= apart * spreads.y;
}

const vec3 NO_ARRIVAL = vec3(FAR, 0.0, 2.0);

// The front at x0, from a point y of the same arc as x2: its time and curvature, and how much the edge
// from y to x2 lies along the ray there; that is more than 1 if there is no such front.
vec3 arrival(Base triangle, Across y) {
    float t2 = triangle.time.y;
    float c = triangle.base;
    vec2 above = corner_over(triangle.sides, c);
    vec2 below = corner_over(y.sides, c);
    float per_base = 1.0 / c;
    bool known_shape = above.y > 0.0 && below.y > 0.0;
    vec2 x1 = vec2(1.0, 0.0);
    vec2 x0 = vec2(above.x, sqrt(max(above.y, 0.0)));
    vec2 place_of_y = vec2(below.x, -sqrt(max(below.y, 0.0)));
    float d1 = (triangle.time.x - t2) * per_base;
    float dy = (y.time - t2) * per_base;
    float k1 = triangle.curvature.x * c;
    float k2 = triangle.curvature.y * c;
    if (!known_shape) return NO_ARRIVAL;

    // The ray at x2.
    float len = y.sides.y * per_base;
    float cosine = (dy - 0.5 * k2 * (len * len - dy * dy)) / len;
    if (abs(cosine) > 1.0 + ARCS_BESIDE) return NO_ARRIVAL;
    float rounding = ALONG_A_RAY * PRECISION * max(triangle.time.x, t2) * per_base;
    if ((1.0 - abs(cosine)) * len <= rounding) cosine = cosine < 0.0 ? -1.0 : 1.0;
    float doubt = abs(cosine);
    float sine = sqrt(max((1.0 - cosine) * (1.0 + cosine), 0.0));
    vec2 towards_y = (1.0 / len) * place_of_y;
    vec2 aside = sine * vec2(-towards_y.y, towards_y.x);
    Arc known = Arc(vec2(0.0), cosine * towards_y + aside, k2);
    Arc other = Arc(vec2(0.0), cosine * towards_y - aside, k2);
    float early = rise_of(known, x1) - d1;
    float other_early = rise_of(other, x1) - d1;
    if (abs(other_early) < abs(early)) {
        known = other;
        early = other_early;
    }

    // That of x1 touches it.
    float rise = rise_of(known, x1);
    float spread = spread_of(known, x1);
    float bend = (k2 - k1) - 0.5 * k1 * k2 * (rise + d1);
    float half_squared = early * bend / (2.0 * spread);
    if (!(half_squared >= -ARCS_TOUCHING && half_squared <= 1.0)) return NO_ARRIVAL;
    half_squared = max(half_squared, 0.0);
    cosine = 1.0 - 2.0 * half_squared;
    sine = 2.0 * sqrt(half_squared * (1.0 - half_squared));
    bool is_fan = bend > 0.0;
    if (!is_fan) sine = -sine;
    vec2 turned = (1.0 / spread) * ray_of(known, x1);
    vec2 ahead = vec2(cosine * turned.x - sine * turned.y, sine * turned.x + cosine * turned.y);
    Arc touching = Arc(x1, ahead, k1);

    // The ray on which they touch, and whether x1, x2 and x0 lie where they should.
    float per = 1.0 / (k1 - k2 + k1 * k2 * d1);
    vec2 between = k1 * k2 * per * x1 + k1 * per * known.ahead - k2 * per * touching.ahead;
    Arc fan = touching;
    if (is_fan) fan = known;
    bool parts = clockwise(between, ray_of(fan, x1)) >= -ARCS_BESIDE
              && clockwise(between, ray_of(fan, vec2(0.0))) <= ARCS_BESIDE;
    bool inside = clockwise(known.ahead, x0) >= -ARCS_BESIDE
               && clockwise(touching.ahead, x0 - x1) <= ARCS_BESIDE;
    Arc arc = known;
    float start = t2;
    if (clockwise(between, ray_of(fan, x0)) > 0.0) {
        arc = touching;
        start = triangle.time.x;
    }
    vec2 ray = ray_of(arc, x0);
    if (!(fan.curvature > 0.0 && ray.y > 0.0 && parts && inside)) return NO_ARRIVAL;

    // How it is bent on its way from the base.
    float spread_at_x0 = spread_of(arc, x0);
    float way = c * x0.y * spread_at_x0 / ray.y;
    float share = x0.x - x0.y * ray.x / ray.y;
    float gaussian = 0.5 * (triangle.gaussian.x + triangle.gaussian.z
                            + share * (triangle.gaussian.y - triangle.gaussian.z));
    float curvature = arc.curvature * per_base / spread_at_x0;
    return vec3(start + c * rise_of(arc, x0), bent(vec4(curvature), vec4(gaussian), vec4(way)).x, doubt);
}

// The same if y is of the arc of x1 instead, alike with both ends exchanged.
vec3 arrival_with(bool of_x1, Base triangle, Across y) {
    if (of_x1) {
        triangle = Base(triangle.time.yx, triangle.curvature.yx, triangle.gaussian.xzy,
                        triangle.sides.yx, triangle.base);
        y.sides = y.sides.yx;
    }
    return arrival(triangle, y);
}

// Whether a front arrives no later than along an edge, after all that it comes from, and no further from
// the front of the mean curvature than two arcs do that touch.
bool arrives(float time, Base triangle, float mean) {
    vec2 along = triangle.time + triangle.sides;
    float latest = min(along.x, along.y) * (1.0 + 16.0 * PRECISION);
    vec2 k = triangle.curvature;
    float apart = (k.y - k.x) - k.x * k.y * (triangle.time.x - triangle.time.y);
    bool touches = abs(time - mean) <= abs(apart) * triangle.base * triangle.base;
    return touches && time <= latest && time > triangle.time.x && time > triangle.time.y;
}
