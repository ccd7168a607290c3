// Continues two arcs that touch on the bases of triangles, each by itself, one triangle after another,
// since few points have such a base. Include after two_arcs.glsl.
// Twin: Fronts::through_quad in src/cpu/state.rs.
//
// The including shader defines
//     vec2 front_at(ivec2 point)                        arrival time and curvature two lines behind
//     float edge_length(ivec2 point, ivec2 step)        to a neighbour

// What four points see of the three neighbours each that a scan has just passed: before it, beside it
// and after it.
struct Sight {
    Ends before, beside, after;
    vec4 gaussian; // of the surface at the points themselves
    vec4 to_before, to_beside, to_after;
    vec4 base_before, base_after; // between the neighbours
};

// Where the points are: the first, how much further the second and the third, and the scan's way.
struct Places {
    ivec2 first, to_second, to_third;
    ivec2 ahead, along;
};

// Two points of a line, from the fronts and the edges of its update: left triangles in xy, right
// triangles in zw.
Sight sight_of_two(Ends behind, vec2 gaussian, vec4 l1, vec4 l2, vec4 base) {
    return Sight(Ends(behind.time.xyxy, behind.curvature.xyxy, behind.gaussian.xyxy),
                 Ends(behind.time.yzyz, behind.curvature.yzyz, behind.gaussian.yzyz),
                 Ends(behind.time.zwzw, behind.curvature.zwzw, behind.gaussian.zwzw),
                 gaussian.xyxy, l1.xyxy, l1.zwzw, l2.zwzw, base.xyxy, base.zwzw);
}

// The triangle of one of the points with the neighbour before it, or the one after it.
Base base_of(Sight sight, int i, bool after) {
    vec2 time = vec2(sight.before.time[i], sight.beside.time[i]);
    vec2 curvature = vec2(sight.before.curvature[i], sight.beside.curvature[i]);
    vec3 gaussian = vec3(sight.gaussian[i], sight.before.gaussian[i], sight.beside.gaussian[i]);
    vec2 sides = vec2(sight.to_before[i], sight.to_beside[i]);
    if (after) {
        time = vec2(time.y, sight.after.time[i]);
        curvature = vec2(curvature.y, sight.after.curvature[i]);
        gaussian = vec3(gaussian.x, gaussian.z, sight.after.gaussian[i]);
        sides = vec2(sides.y, sight.to_after[i]);
    }
    return Base(time, curvature, gaussian, sides, after ? sight.base_after[i] : sight.base_before[i]);
}

// The first end of the base of that triangle.
ivec2 x1_of(Places places, int i, bool after) {
    ivec2 point = places.first + (i & 1) * places.to_second + (i >> 1) * places.to_third;
    return point - places.ahead - (after ? ivec2(0) : places.along);
}

// Replaces those of the fronts through the triangles of the first points whose bases two arcs touch on.
void part_arcs(Sight sight, Places places, int points, inout Fronts from_before, inout Fronts from_after) {
    uvec4 each = mix(uvec4(0u), uvec4(1u, 2u, 4u, 8u), are_two_arcs(sight.before, sight.beside))
               | mix(uvec4(0u), uvec4(16u, 32u, 64u, 128u), are_two_arcs(sight.beside, sight.after));
    uint triangles = each.x | each.y;
    if (points > 2) triangles |= each.z | each.w;

    // Four tries for each: with the point across that is behind the neighbour beside the point, or with
    // the other one, and with it of the arc of x2 or of x1. Most are none, which a short loop finds.
    uint tries = 0u;
    while (triangles != 0u) {
        int number = findLSB(triangles);
        triangles &= triangles - 1u;
        bool after = number >= 4;
        Base triangle = base_of(sight, number & 3, after);
        ivec2 x1 = x1_of(places, number & 3, after);
        vec2 a = front_at(x1 + (after ? ivec2(0) : places.along) - places.ahead);
        vec2 b = front_at(x1 + (after ? places.along : ivec2(0)) - places.ahead);
        vec2 at_x1 = vec2(triangle.time.x, triangle.curvature.x);
        vec2 at_x2 = vec2(triangle.time.y, triangle.curvature.y);
        uint found = is_of_same(at_x2, at_x1, a) ? 1u : 0u;
        if (is_of_same(at_x1, at_x2, a)) found |= 2u;
        if (is_of_same(at_x2, at_x1, b)) found |= 4u;
        if (is_of_same(at_x1, at_x2, b)) found |= 8u;
        tries |= found << 4 * number;
    }

    vec3 best = NO_ARRIVAL;
    while (tries != 0u) {
        int number = findLSB(tries);
        tries &= tries - 1u;
        int i = number >> 2 & 3;
        bool after = number >= 16;
        Base triangle = base_of(sight, i, after);
        ivec2 x1 = x1_of(places, i, after);
        ivec2 x2 = x1 + places.along;
        ivec2 y = (((number & 2) != 0) == after ? x2 : x1) - places.ahead;
        vec2 front = front_at(y);
        vec2 sides = vec2(edge_length(x1, y - x1), edge_length(x2, y - x2));
        vec3 found = arrival_with((number & 1) != 0, triangle, Across(front.x, front.y, sides));
        if (found.z < best.z) best = found;
        bool is_last = (tries >> (number & ~3) & 15u) == 0u;
        if (!is_last) continue;
        float mean = after ? from_after.time[i] : from_before.time[i];
        if (best.z < NO_ARRIVAL.z && arrives(best.x, triangle, mean)) {
            if (after) {
                from_after.time[i] = best.x;
                from_after.curvature[i] = best.y;
                from_after.whole[i] = true;
            } else {
                from_before.time[i] = best.x;
                from_before.curvature[i] = best.y;
                from_before.whole[i] = true;
            }
        }
        best = NO_ARRIVAL;
    }
}
