// Measures how sharply the surface turns from point to point, so that a renderer knows whether its grid
// resolves the surface.
// Twin: crates/surface/src/resolution.rs, where it is explained.

// Returns the unit normal at a point with all four neighbours on the grid, otherwise zero.
vec3 normal_inside(ivec2 at) {
    bool inside = in_grid(at - 1, grid - 2) && is_present(at) && goes_on(at, ivec2(1, 0)) && goes_on(at, ivec2(0, 1));
    return inside ? normal(at) : vec3(0.0);
}

// Compares the normal at a point with those one and two steps away, at a sample of the points.
void measure_turns(ivec2 at) {
    ivec2 every = (grid + (LOOKS - 1)) / LOOKS;
    if (min(at.x, at.y) < 1 || any(notEqual((at - 1) % every, ivec2(0)))) return;
    // The normals are computed in one loop, since compilers would otherwise inline the code of a normal five
    // times. The order is: here, one and two steps to the east, one and two steps to the north.
    vec3 here = vec3(0.0);
    float turned = 0.0;
    for (int i = 0; i < 5; i++) {
        ivec2 step = i < 3 ? ivec2(1, 0) : ivec2(0, -1);
        int steps = i < 3 ? i : i - 2;
        vec3 there = normal_inside(at + steps * step);
        bool is_known = dot3(there, there) > 0.5;
        if (i == 0) {
            if (!is_known) return;
            here = there;
            continue;
        }
        vec3 apart = there - here;
        float square = dot3(apart, apart);
        if (steps == 1) {
            // A negative value means that the squared difference is not known.
            turned = is_known ? square : -1.0;
            if (!is_known) continue;
            atomicAdd(compared, 1u);
            if (dot3(here, there) < SHARP_COSINE) atomicAdd(sharp, 1u);
        } else if (is_known && turned >= 0.0) {
            atomicAdd(continued, 1u);
            atomicAdd(turns[0], uint(turned * float(TURN_UNITS) + 0.5));
            atomicAdd(turns[1], uint(square * float(TURN_UNITS) + 0.5));
        }
    }
}
