// Determines the distance of the points that split an obtuse triangle.
// Twin: crates/surface/src/obtuse/reach.rs, where the reduced basis is explained.

// Limit of the squares of a triangle's sides at x0, as a part of the square of its base, for which any obtuse angle
// counts, but for rounding.
const float EXACTLY = 1.0 - 1e-5;
// Part of the square of the shorter side below which two sides are at a right angle.
const float RIGHT_ANGLE = 5e-6;
// Largest number of steps by which a basis is reduced. Each at least halves the longer side, up to the last one.
const int REDUCTION_STEPS = 32;
// Largest distance that is told apart.
const int MOST_SKEW = 255;

int farthest(ivec2 step) {
    return max(abs(step.x), abs(step.y));
}

// Replaces two steps by the shortest step and the shortest one in another direction. `squares` are those of their
// lengths, and `along` is their scalar product. Returns false if a step would be too long.
bool reduce(inout ivec2 short_step, inout ivec2 long_step, inout vec2 squares, inout float along) {
    for (int i = 0; i < REDUCTION_STEPS; i++) {
        if (squares.y < squares.x) {
            squares = squares.yx;
            ivec2 other = short_step;
            short_step = long_step;
            long_step = other;
        }
        float times = round(along / squares.x);
        if (times == 0.0) break;
        if (!(abs(times) < float(MOST_SKEW))) return false;
        long_step -= int(times) * short_step;
        squares.y += times * (times * squares.x - 2.0 * along);
        along -= times * squares.x;
    }
    return true;
}

// Returns the distance in rows and columns of the farthest step of the reduced basis of a triangle, whose sides are two
// steps, and whose sides and base have the given squares.
int reach_of_basis(ivec2 short_step, ivec2 long_step, vec3 squares) {
    float along = 0.5 * (squares.x + squares.y - squares.z);
    if (!reduce(short_step, long_step, squares.xy, along)) return MOST_SKEW;
    ivec2 third = long_step - (along > 0.0 ? short_step : -short_step);
    int reach = max(farthest(short_step), farthest(long_step));
    return abs(along) > RIGHT_ANGLE * squares.x ? max(reach, farthest(third)) : reach;
}

// Returns the largest distance, in rows and columns, of the points that split a triangle at x0, if the metric around it
// is that of the triangle. Returns 1 if the triangle is not obtuse or has no lengths. `squares` are those of the lengths
// of both sides at x0 and of the base.
int splits_within(ivec2 first_step, ivec2 second_step, vec3 squares) {
    bool is_there = max(squares.x, max(squares.y, squares.z)) < FAR && min(squares.x, squares.y) > 0.0;
    if (!is_there || squares.x + squares.y >= EXACTLY * squares.z) return 1;
    return min(reach_of_basis(first_step, second_step, squares), MOST_SKEW);
}
