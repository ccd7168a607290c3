#include "update/wavefront.glsl"

// Returns the place at which the ray to x0 crosses the base of its triangle, from 0 at x1 to 1 at x2. The result is 0
// or 1 if the front comes along an edge, or if one end of the base has not been reached. `times` and `carried` are the
// fronts at x1 and x2, `sides` the edges from there to x0, and `base` the length of the base.
// Twin: base_crossing in src/update.
float base_crossing(vec2 times, vec2 carried, vec2 sides, float base) {
    bool swap = times.x < times.y;
    float t = swap ? times.y : times.x;
    float near_t = swap ? times.x : times.y;
    float l = swap ? sides.y : sides.x;
    float near_l = swap ? sides.x : sides.y;
    Shape shape = shape_of(vec4(l), vec4(near_l), vec4(base));
    float d = (near_t - t) * shape.per_base.x;
    float kappa = curvature_over_base(t, swap ? carried.yx : carried, d, base);
    float h = sqrt(max(shape.height_squared.x, 0.0));
    float cos_a = 0.5 * kappa * ((1.0 - d) * (1.0 + d)) - d;
    float sin_a = sqrt(max((1.0 - cos_a) * (1.0 + cos_a), 0.0));
    float crossing = cos_a * h + sin_a * shape.foot.x;
    float width = sin_a + kappa * h;
    bool of_one = d > -ALONG_BASE && kappa * (1.0 - d) <= STRADDLING;
    bool is_front = shape.whole.x && of_one && width > 0.0;
    float along_edge = t + l <= near_t + near_l ? 0.0 : 1.0;
    float from_far = is_front ? clamp(crossing / width, 0.0, 1.0) : along_edge;
    return swap ? 1.0 - from_far : from_far;
}
