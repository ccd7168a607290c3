// Computes the metric of the surface from the lengths of its edges. If there is a slowness, lengths are travel times.
// crates/geometry/src/directions/frame.rs computes a metric for the same purpose from positions, or takes the metric that is
// given. So it is no twin.

#include "shared/edge_image.glsl"

// The metric at a place, in steps of columns (c) and rows (r).
struct Metric {
    float cc;
    float rr;
    float cr;
};

// Returns the mean square of the lengths of two edges that lie in line. If only one exists, this is its square; if
// neither does, -1.
float mean_square(float a, float b) {
    if (a >= FAR && b >= FAR) return -1.0;
    if (a >= FAR) return b * b;
    return b >= FAR ? a * a : 0.5 * (a * a + b * b);
}

// Returns the metric at a grid point from the lengths of the edges to its neighbours: `own` to the east, north,
// north-east and north-west, as stored at the point, and `others` to the west, south, south-west and south-east. `unit`
// is the unit of length.
Metric metric_of_edges(vec4 own, vec4 others, float unit) {
    own /= unit;
    others /= unit;
    // Edges that do not exist keep the length FAR.
    vec4 far = vec4(0.5 * (FAR / unit));
    own = mix(own, vec4(FAR), greaterThanEqual(own, far));
    others = mix(others, vec4(FAR), greaterThanEqual(others, far));
    Metric metric;
    metric.cc = mean_square(own.x, others.x);
    metric.rr = mean_square(own.y, others.y);
    float falling = mean_square(own.w, others.w);
    float rising = mean_square(own.z, others.z);
    metric.cr = 0.0;
    if (falling >= 0.0 && rising >= 0.0) {
        metric.cr = 0.25 * (falling - rising);
    } else if (falling >= 0.0) {
        metric.cr = 0.5 * (falling - metric.cc - metric.rr);
    } else if (rising >= 0.0) {
        metric.cr = 0.5 * (metric.cc + metric.rr - rising);
    }
    return metric;
}

// Returns the metric at a grid point in units of `unit`, a length that is comparable with the point's edges. A
// component of the metric is not positive where no edge leads along columns or rows.
Metric metric_of_point(ivec2 at, float unit) {
    ivec2 point = point_at(at);
    return metric_of_edges(imageLoad(edges, point), edges_to_point(point), unit);
}

// Returns whether a metric is positive definite, with columns and rows far enough from parallel for single precision.
bool is_usable(Metric metric) {
    return metric.cc > 0.0 && metric.rr > 0.0
        && metric.cc * metric.rr - metric.cr * metric.cr > 1e-6 * metric.cc * metric.rr;
}

// Returns the longest edge along columns and rows at a point, or 0 if there is none.
float longest_edge(ivec2 at) {
    float longest = 0.0;
    for (int i = 0; i < 8; i += 2) {
        float size = edge_length(point_at(at), NEIGHBOURS[i]);
        if (size < FAR) longest = max(longest, size);
    }
    return longest;
}

// Returns the scalar product of two steps of columns and rows.
float product(Metric metric, vec2 a, vec2 b) {
    return metric.cc * a.x * b.x + metric.cr * (a.x * b.y + a.y * b.x) + metric.rr * a.y * b.y;
}

// Returns the step whose scalar products with a step of one column and with a step of one row are given.
vec2 raised(Metric metric, vec2 lower) {
    float whole = metric.cc * metric.rr - metric.cr * metric.cr;
    return vec2(metric.rr * lower.x - metric.cr * lower.y, metric.cc * lower.y - metric.cr * lower.x) / whole;
}
