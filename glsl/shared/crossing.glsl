// Finds where the map takes a value on an edge between grid points. A squared time is represented by its
// excess over the squared time at the edge's first end. The excess is computed as the product of a difference
// and a sum. In single precision, the difference of two squares would lose its digits.
// Twin: crates/geometry/src/arrivals.rs.

// The excess of the squared time over its value at the first end of an edge, along the edge.
struct Profile {
    float rise;    // at the other end
    vec2 bends;    // second differences at both ends
    bool fronts_meet;
    vec2 ahead;    // where fronts meet: slope and second difference of the front from the first end
    vec2 behind;   // and of the front from the other end
};

// Returns the value of a profile at a share of the edge.
float value(Profile profile, float s) {
    float rest = 1.0 - s;
    if (profile.fronts_meet) {
        float ahead = s * profile.ahead.x + 0.5 * s * (s + 1.0) * profile.ahead.y;
        float behind = rest * profile.behind.x + 0.5 * rest * (rest + 1.0) * profile.behind.y;
        return min(ahead, profile.rise + behind);
    }
    float bend = ((2.0 - s) * profile.bends.x + (1.0 + s) * profile.bends.y) / 3.0;
    return s * profile.rise - 0.5 * s * rest * bend;
}

// Returns where a profile takes a value between its values at 0 and 1. The method is regula falsi in the
// Illinois variant.
float solve(Profile profile, float target) {
    float a = 0.0;
    float b = 1.0;
    float at_a = value(profile, a) - target;
    float at_b = value(profile, b) - target;
    if (at_a == 0.0 || at_b == 0.0 || (at_a < 0.0) == (at_b < 0.0)) {
        return abs(at_a) <= abs(at_b) ? a : b;
    }
    float enough = 1e-6 * abs(at_b - at_a);
    for (int i = 0; i < 40; i++) {
        float s = (a * at_b - b * at_a) / (at_b - at_a);
        float at_s = value(profile, s) - target;
        if (at_s == 0.0 || abs(b - a) < 1e-6) return s;
        if ((at_s < 0.0) == (at_b < 0.0)) {
            at_a *= 0.5;
        } else {
            a = b;
            at_a = at_b;
        }
        b = s;
        at_b = at_s;
        if (abs(at_b) <= enough) return b;
    }
    return b;
}

// Returns where on the edge from a point (0) to its neighbour (1) the map has the value `time`, which lies
// between the values at the two ends.
float crossing(ivec2 from, ivec2 step, float time, float start) {
    float here = time_at(from);
    float since = here - start;
#define EXCESS(t) (((t) - here) * ((t) - start + since))
    float before = time_at(from - step);
    float after = time_at(from + 2 * step);
    bool has_before = is_reached(before);
    bool has_after = is_reached(after);
    float target = EXCESS(time);
    Profile profile;
    profile.rise = EXCESS(time_at(from + step));
    profile.fronts_meet = false;
    profile.bends = vec2(0.0);
    before = EXCESS(before);
    after = EXCESS(after);
    float p = before + profile.rise;
    float q = after - 2.0 * profile.rise;
    if (has_before && has_after && p < 0.0 && q < 0.0) {
        // Two fronts meet on this edge. Each is extrapolated from its own side, and the earlier of the two is
        // used.
        float far_before = time_at(from - 2 * step);
        float far_after = time_at(from + 3 * step);
        if (!is_reached(far_before) || !is_reached(far_after)) return solve(profile, target);
        vec2 ahead = vec2(-before, EXCESS(far_before) - 2.0 * before);
        vec2 behind =
            vec2(profile.rise - after, profile.rise - 2.0 * after + EXCESS(far_after));
        if (ahead.x + ahead.y < profile.rise || profile.rise + behind.x + behind.y < 0.0) {
            return solve(profile, target);
        }
        profile.fronts_meet = true;
        profile.ahead = ahead;
        profile.behind = behind;
    } else if (has_before && has_after) {
        // Near a kink on one side, the points of the other side are more accurate.
        bool smooth_here = abs(p - q) <= 0.5 * (abs(p) + abs(q));
        profile.bends = smooth_here ? vec2(p, q) : vec2(abs(p) < abs(q) ? p : q);
    } else if (has_before || has_after) {
        profile.bends = vec2(has_before ? p : q);
    }
#undef EXCESS
    return solve(profile, target);
}
