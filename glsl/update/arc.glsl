// Computes lengths of edges along the surface rather than along chords.
// Twin: crates/surface/src/arc.rs, where the formulas are explained.
//
// The including shader declares
//     int arcs                                          0 for chords, else for lengths along the surface (band.glsl)
//     Point load(ivec2 at)                              a point of the band's buffer
//     bool is_present(ivec2 at)                         whether the surface has that point (edges.glsl)
//     vec3 difference(Point a, Point b, ivec2 step)     from a point to its neighbour

float dot3(vec3 a, vec3 b) {
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

vec3 unit(vec3 a) {
    float size = sqrt(dot3(a, a));
    return size > 0.0 ? a / size : vec3(0.0);
}

// Returns the step from a point to its neighbour, or zero if the neighbour is missing.
vec3 way(ivec2 at, ivec2 step) {
    return is_present(at + step) ? difference(load(at), load(at + step), step) : vec3(0.0);
}

// Returns the unit vector along a grid line, or zero. On surfaces whose grid lines have corners (WITH_CORNERS), the
// shorter of two steps counts more, as in the derivative of a parabola.
vec3 along(ivec2 at, ivec2 step) {
    vec3 ahead = way(at, step);
    vec3 behind = way(at, -step);
    if (arcs == WITH_CORNERS) {
        vec2 squares = vec2(dot3(ahead, ahead), dot3(behind, behind));
        if (min(squares.x, squares.y) > 0.0) {
            squares /= squares.x + squares.y;
            ahead *= squares.y;
            behind *= squares.x;
        }
    }
    return unit(ahead - behind);
}

// Returns the surface's unit normal at a point, or zero where the neighbours do not determine one.
vec3 normal(ivec2 at) {
    vec3 u = along(at, ivec2(1, 0));
    vec3 v = along(at, ivec2(0, -1));
    vec3 across = vec3(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
    return dot3(across, across) > 1e-6 ? unit(across) : vec3(0.0);
}

// Returns whether the grid line continues on both sides of a point.
bool goes_on(ivec2 at, ivec2 step) {
    return is_present(at + step) && is_present(at - step);
}

// Returns the unit normal at an end of an edge in xyz, and the bend of the grid line there in w: the second difference
// of the positions along the line, projected on the normal. On surfaces whose grid lines have corners (WITH_CORNERS),
// the bend is divided by the mean of the squared steps to both neighbours. Where the grid line ends, the bends at the
// next two points inwards are used: the one that is smaller in magnitude, or 0 if their signs differ or one of them is
// unknown.
vec4 bend(ivec2 at, ivec2 step) {
    bool inside = goes_on(at, step);
    ivec2 inwards = inside ? ivec2(0) : is_present(at + step) ? step : -step;
    bool known = inside || (goes_on(at + inwards, step) && goes_on(at + 2 * inwards, step));
    vec3 up = vec3(0.0);
    float smaller = 0.0;
    // One loop body serves the end and both points inwards, since compilers would inline three calls.
    for (int i = 0; i < (inside || !known ? 1 : 3); i++) {
        ivec2 point = at + i * inwards;
        vec3 normal_there = normal(point);
        vec3 ahead = way(point, step);
        vec3 back = way(point, -step);
        float across = dot3(ahead + back, normal_there);
        if (arcs == WITH_CORNERS) {
            float square = 0.5 * (dot3(ahead, ahead) + dot3(back, back));
            across = square > 0.0 ? across / square : 0.0;
        }
        if (i == 0) up = normal_there;
        if (i < 2) {
            smaller = across;
        } else {
            float least = abs(smaller) < abs(across) ? smaller : across;
            smaller = (smaller > 0.0) == (across > 0.0) ? least : 0.0;
        }
    }
    return vec4(up, known ? smaller : 0.0);
}

// Returns the distance from a point to its neighbour along the surface, or along the chord if `arcs` is 0.
float separation(ivec2 at, ivec2 step) {
    vec3 d = difference(load(at), load(at + step), step);
    float chord = sqrt(dot3(d, d));
    if (arcs == 0 || chord <= 0.0) return chord;
    float sum = 0.0;
    float product = 1.0;
    vec3 apart = vec3(0.0);
    for (int end = 0; end < 2; end++) {
        vec4 found = bend(at + end * step, step);
        float turn = clamp(arcs == WITH_CORNERS ? found.w * chord : found.w / chord, -1.0, 1.0);
        sum += turn;
        product *= turn;
        apart = found.xyz - apart;
    }
    float square = 0.5 * abs(sum) * sqrt(max(product, 0.0));
    float next = dot3(apart, apart) * (1.0 / 180.0) - square * (1.0 / 1152.0);
    return chord + chord * (square * (1.0 / 24.0 + next));
}
