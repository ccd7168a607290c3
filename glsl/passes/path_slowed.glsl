// Finds the straight line to a side of a cell that arrives first at a place in the cell, over a slowness that is linear
// along the side.
// Twin: crates/geometry/src/paths/slowed_edge.rs.

// Number of parts in which the first arrival is searched: where fronts meet or the slowness jumps, there may be several
// minima.
const int PARTS_OF_SIDE = 8;
// Number of steps by the golden section. They leave 1e-4 of a part, which is what single precision tells.
const int GOLDEN_STEPS = 18;
const float GOLDEN = 0.61803399;

// Returns the line to a place of the side. `slowness` is that at the start of the line and at both ends of the side.
// Along the side, the time changes as the slowness adds up, which is exact for a front that runs along it.
Crossing slowed_crossing_at(Profile profile, vec2 ends, float square, vec3 slowness, float share) {
    float there = mix(slowness.y, slowness.z, share);
    float mean = 0.5 * (slowness.y + slowness.z);
    float passed = mean > 0.0 ? 0.5 * share * (slowness.y + there) / mean : share;
    float apart = sqrt(max(away(ends, square, share).x, 0.0));
    return Crossing(share, time_along(profile, passed), apart * 0.5 * (slowness.x + there));
}

float slowed_sum(Profile profile, vec2 ends, float square, vec3 slowness, float share) {
    Crossing found = slowed_crossing_at(profile, ends, square, slowness, share);
    return found.time + found.distance;
}

Crossing slowed_crossing(Profile profile, vec2 ends, float square, vec3 slowness) {
    float first = 0.0;
    float least = slowed_sum(profile, ends, square, slowness, 0.0);
    for (int i = 1; i <= PARTS_OF_SIDE; i++) {
        float share = float(i) / float(PARTS_OF_SIDE);
        float sum = slowed_sum(profile, ends, square, slowness, share);
        if (sum < least) {
            least = sum;
            first = share;
        }
    }
    float low = max(first - 1.0 / float(PARTS_OF_SIDE), 0.0);
    float high = min(first + 1.0 / float(PARTS_OF_SIDE), 1.0);
    // The place at which the sum is known, and the other inner place, whose sum this step computes.
    float known = mix(high, low, GOLDEN);
    float of_known = slowed_sum(profile, ends, square, slowness, known);
    for (int i = 0; i < GOLDEN_STEPS; i++) {
        float other = low + high - known;
        float of_other = slowed_sum(profile, ends, square, slowness, other);
        bool is_less = of_other < of_known;
        float dropped = is_less ? known : other;
        if (is_less) {
            known = other;
            of_known = of_other;
        }
        if (dropped < known) low = dropped; else high = dropped;
    }
    // An end of the search is exact.
    float best = least <= of_known ? first : known;
    return slowed_crossing_at(profile, ends, square, slowness, best);
}
