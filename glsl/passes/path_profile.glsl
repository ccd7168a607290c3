// Describes arrival times along an edge, and finds where the straight line on which the front arrives first
// at a place crosses the edge. Times are in units of the cell's longest edge, and relative to the time at the
// edge's first end. So single precision suffices where the source is far away.
// Twin: crates/geometry/src/paths, where the choices are explained.

#include "shared/times.glsl"

struct Profile {
    float first; // time since the start, at the first end
    float last;  // at the other end
    float rise;  // difference of their squares
    vec2 bends;  // second differences at both ends
    float size;  // length of the edge
};

// The place where a straight line crosses an edge.
struct Crossing {
    float share;
    float time; // relative to the time at the first end
    float distance;
};

// Returns the excess of the squared time over its value at the first end, and the first two derivatives of
// the excess.
vec3 excess(Profile profile, float share) {
    float rest = 1.0 - share;
    float left = profile.bends.x;
    float right = profile.bends.y;
    float bend = (1.0 + rest) * left + (1.0 + share) * right;
    float sixth = 1.0 / 6.0;
    float value = share * (profile.rise - rest * sixth * bend);
    float slope =
        profile.rise - sixth * ((rest - share) * bend + share * rest * (right - left));
    return vec3(value, slope, rest * left + share * right);
}

// Returns the time less the time at the first end, from the excess of the squared time.
float since_first(Profile profile, float value) {
    float square = max(profile.first * profile.first + value, 0.0);
    float sum = profile.first + sqrt(square);
    return sum > 0.0 ? max(value, -profile.first * profile.first) / sum : 0.0;
}

// Returns whether the time in the middle of the edge differs from the times at its ends by at most half the
// length of the edge, with a margin.
bool is_distance(Profile profile) {
    float middle = since_first(profile, excess(profile, 0.5).x);
    float most = (0.5 + MARGIN) * profile.size;
    return abs(middle) <= most && abs(profile.last - profile.first - middle) <= most;
}

// Returns the second derivative by the share of an edge of a value that rises by `rise` along the edge, and by
// `beyond` from one end to the next point, whose distance is `ratio` lengths of the edge. Both are counted from that end.
float second_difference(float beyond, float rise, float ratio) {
    return 2.0 * (beyond / ratio + rise) / (1.0 + ratio);
}

// Returns the profile of an edge. The second and third of four points in line are the ends of the edge.
// `ratios` are the lengths of the edges before and behind it, as parts of its own. `start` and `unit` make times
// comparable with lengths. `square` is the squared length of the edge.
Profile profile_of(vec4 times, vec2 ratios, float start, float unit, float square) {
    vec4 since = max(times - start, 0.0) / unit;
    vec4 steps = (max(times, start) - max(times.y, start)) / unit;
    vec4 excesses = steps * (since + since.y);
    Profile profile;
    profile.first = since.y;
    profile.last = since.z;
    profile.rise = excesses.z;
    profile.size = sqrt(square);
    float left = second_difference(excesses.x, profile.rise, ratios.x);
    float right = second_difference(excesses.w - profile.rise, -profile.rise, ratios.y);
    bool has_left = is_reached(times.x) && ratios.x >= 1.0 / MOST_UNEVEN && ratios.x <= MOST_UNEVEN;
    bool has_right = is_reached(times.w) && ratios.y >= 1.0 / MOST_UNEVEN && ratios.y <= MOST_UNEVEN;
    if (has_left && has_right) {
        float small = abs(left) < abs(right) ? left : right;
        float large = abs(left) < abs(right) ? right : left;
        bool is_smooth = small * large > 0.0 && abs(large) < KINK * abs(small);
        // Each second difference is that at the mean of its three points.
        float slope = (right - left) / (1.0 + ratios.x + ratios.y);
        vec2 at_ends = vec2(left, right) + vec2(ratios.x - 1.0, 1.0 - ratios.y) * slope;
        profile.bends = is_smooth ? at_ends : vec2(small);
    } else if (has_left || has_right) {
        profile.bends = vec2(has_left ? left : right);
    } else {
        float nearer = min(since.y, since.z);
        bool one_front = abs(profile.rise) >= square || nearer * nearer >= square;
        profile.bends = vec2(one_front ? 2.0 * square : 0.0);
    }
    if (!is_distance(profile)) profile.bends = vec2(0.0);
    return profile;
}

// Returns the time at a share of the edge.
float time_along(Profile profile, float share) {
    float time = since_first(profile, excess(profile, share).x);
    float other = profile.last - profile.first - (1.0 - share) * profile.size;
    return max(time, max(-share * profile.size, other));
}

// Returns the squared distance between the place and a point of the edge, and its first two derivatives.
vec3 away(vec2 ends, float square, float share) {
    float skew = ends.y - ends.x;
    return vec3(ends.x + share * (skew - (1.0 - share) * square),
                skew - (1.0 - 2.0 * share) * square, 2.0 * square);
}

// Returns the first two derivatives of the square root of a value.
vec2 derivatives(vec3 square, float least) {
    float value = max(square.x, least);
    float half_inverse = 0.5 * inversesqrt(value);
    return half_inverse * vec2(square.y, square.z - 0.5 * square.y * square.y / value);
}

// Returns the first two derivatives, along the edge, of the arrival time at the place through a point of the
// edge.
vec2 slope_and_bend(Profile profile, vec2 ends, float square, float share) {
    float least = 1e-12 * square;
    vec3 time = excess(profile, share);
    time.x += profile.first * profile.first;
    return derivatives(time, least) + derivatives(away(ends, square, share), least);
}

// Returns the crossing at a share of the edge.
Crossing crossing_at(Profile profile, vec2 ends, float square, float share) {
    float apart = sqrt(max(away(ends, square, share).x, 0.0));
    return Crossing(share, time_along(profile, share), apart);
}

// Returns where the straight line on which the front arrives first at a place crosses the edge. `ends` are
// the squared distances of the edge's ends from the place. The method is Newton's, within brackets.
Crossing crossing(Profile profile, vec2 ends, float square) {
    float low = slope_and_bend(profile, ends, square, 0.0).x;
    float high = slope_and_bend(profile, ends, square, 1.0).x;
    float share;
    if (low < 0.0 && high > 0.0) {
        float left = 0.0;
        float right = 1.0;
        share = low / (low - high);
        for (int i = 0; i < 30; i++) {
            vec2 here = slope_and_bend(profile, ends, square, share);
            if (here.x < 0.0) {
                left = share;
            } else {
                right = share;
            }
            float next = share - here.x / here.y;
            if (!(next > left && next < right)) next = 0.5 * (left + right);
            float change = abs(next - share);
            share = next;
            if (change < 1e-5) break;
        }
    } else {
        float later = profile.last - profile.first + sqrt(ends.y) - sqrt(ends.x);
        share = later >= 0.0 ? 0.0 : 1.0;
    }
    return crossing_at(profile, ends, square, share);
}
