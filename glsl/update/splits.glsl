// Computes fronts through the parts of obtuse triangles. Such a triangle is not updated as a whole. A grid point beyond
// the triangle's base is unfolded into the triangle's plane, and splits the triangle into two parts. If no point splits
// the triangle, only its edges are used.
// Twin: crates/surface/src/unfold.rs, where unfolding is explained.
//
// The including shader defines
//     vec2 front_at(ivec2 point)          arrival time and carried value at any point of the grid
//     float surface_at(ivec2 point)       surface value there
//     float slowness_at(ivec2 point)      slowness there, if SLOWED is set

#include "update/wavefront.glsl"
#include "update/reach.glsl"
#include "shared/edge_image.glsl"

vec2 front_at(ivec2 point);

// A grid point unfolded into the plane of x0's triangle.
struct Unfolded {
    ivec2 step; // from x0
    vec2 place; // position in the plane, relative to x0
    vec3 front; // arrival time, carried value and surface value there
    float slowness;
};

float known_slowness_at(ivec2 point) {
    return SLOWED != 0 ? slowness_at(point) : 1.0;
}

// Returns the length of an edge on the surface, without the slowness.
float length_on_surface(ivec2 point, ivec2 step) {
    float length = edge_length(point, step);
    if (SLOWED == 0 || length >= FAR) return length;
    return (length + length) / (slowness_at(point) + slowness_at(point + step));
}

// Returns whether the place `a` lies to the left of the place `other`, as seen from x0, by more than rounding.
bool follows(vec2 a, vec2 other) {
    float across = other.x * a.y - other.y * a.x;
    return across > SPLIT_MARGIN * (dot(a, a) + dot(other, other));
}

bool is_obtuse(vec2 a, vec2 b) {
    float base = dot(a - b, a - b);
    return dot(a, a) / base + dot(b, b) / base < OBTUSE;
}

// Finds the place to the right of an edge from `u` to `w` that has the given distances to both ends. Returns false if
// the three lengths form no triangle.
bool unfold(vec2 u, vec2 w, float base, float to_u, float to_w, out vec2 place) {
    place = vec2(0.0);
    if (max(base, max(to_u, to_w)) >= FAR) return false;
    float per_base = 1.0 / base;
    to_u = to_u * per_base;
    to_w = to_w * per_base;
    float foot = 0.5 * ((to_u * to_u - to_w * to_w) + 1.0);
    float height_squared = (to_u - foot) * (to_u + foot);
    if (!(height_squared > 0.0)) return false;
    vec2 along = w - u;
    place = u + foot * along + sqrt(height_squared) * vec2(along.y, -along.x);
    return true;
}

// Finds the grid point beyond the edge from `u` to `w`, and unfolds it into x0's plane. If both grid points beyond the
// edge can be unfolded, a point between the directions `right` and `left` is preferred, then the one nearer to x0.
// Returns false if none can be unfolded.
bool find_beyond(ivec2 x0, Unfolded u, Unfolded w, int turn, vec2 right, vec2 left, inout Unfolded apex) {
    ivec2 along = w.step - u.step;
    ivec2 away = turn * ivec2(-along.y, along.x);
    bool is_diagonal = along.x != 0 && along.y != 0;
    float base = length_on_surface(x0 + u.step, along);
    const float CLEARLY = 1.0 - SPLIT_MARGIN;
    bool found = false;
    bool was_inside = false;
    float other_around = FAR;
    for (int i = 0; i < (is_diagonal ? 1 : 2); i++) {
        ivec2 step = i == 1 ? along + away : is_diagonal ? (along + away) / 2 : away;
        ivec2 from_x0 = u.step + step;
        if (max(abs(from_x0.x), abs(from_x0.y)) > SPLITS) continue;
        vec2 place;
        float to_u = length_on_surface(x0 + u.step, step);
        float to_w = length_on_surface(x0 + w.step, step - along);
        if (!unfold(u.place, w.place, base, to_u, to_w, place)) continue;
        bool inside = follows(place, right) && follows(left, place);
        float around = to_u + to_w;
        float squared = dot(place, place);
        float other = dot(apex.place, apex.place);
        bool as_near = !(squared < other * CLEARLY) && !(other < squared * CLEARLY);
        bool nearer = as_near ? around < other_around * CLEARLY : squared < other;
        if (!found || (inside == was_inside ? nearer : inside)) {
            apex.step = from_x0;
            apex.place = place;
            was_inside = inside;
            other_around = around;
        }
        found = true;
    }
    return found;
}

vec3 known_at(ivec2 point) {
    return vec3(front_at(point), CARRIES ? surface_at(point) : 0.0);
}

// Returns the earliest of the fronts at x0 through the parts of its obtuse triangle. `a` and `b` are the steps to the
// ends of the triangle's base. All four components are equal.
Fronts through_parts(ivec2 x0, ivec2 a, ivec2 b) {
    Fronts first = Fronts(vec4(FAR), vec4(0.0), bvec4(false));
    ivec2 base = b - a;
    // The ends are put in counter-clockwise order, so that all scans find the same parts.
    if (base.x * a.y - base.y * a.x < 0) {
        a = b;
        base = -base;
        b = a + base;
    }
    float la = length_on_surface(x0, a);
    float lb = length_on_surface(x0, b);
    float c = length_on_surface(x0 + a, base);
    float x = 0.5 * (la * la + lb * lb - c * c) / la;
    float height_squared = lb * lb - x * x;
    if (max(la, lb) >= FAR || !(height_squared > 0.0)) return first;
    float surface = CARRIES ? surface_at(x0) : 0.0;
    Unfolded right = Unfolded(a, vec2(la, 0.0), known_at(x0 + a), known_slowness_at(x0 + a));
    Unfolded left = Unfolded(b, vec2(x, sqrt(height_squared)), known_at(x0 + b), known_slowness_at(x0 + b));
    float own_slowness = known_slowness_at(x0);
    // If the slowness jumps between the points visited, parts are updated with the largest slowness among them.
    float least = min(own_slowness, min(right.slowness, left.slowness));
    float largest = max(own_slowness, max(right.slowness, left.slowness));
    // Ends of the edge beyond which the next point is searched.
    Unfolded u = right;
    Unfolded w = left;
    int turn = base.x * a.y - base.y * a.x > 0 ? 1 : -1;
    Unfolded apex = right;
    const int STEPS = SPLITS > SPLIT_REACH ? STEPS_PER_LINE * SPLITS : SPLIT_STEPS;
    for (int i = 0; i < STEPS; i++) {
        if (!find_beyond(x0, u, w, turn, right.place, left.place, apex)) break;
        apex.slowness = known_slowness_at(x0 + apex.step);
        least = min(least, apex.slowness);
        largest = max(largest, apex.slowness);
        if (!follows(apex.place, right.place)) {
            u = apex;
            continue;
        }
        if (!follows(left.place, apex.place)) {
            w = apex;
            continue;
        }
        apex.front = known_at(x0 + apex.step);
        // The part to the right of the point is in x, the part to its left in y. An obtuse part brings no front:
        // its lengths are set to FAR.
        bool right_obtuse = is_obtuse(right.place, apex.place);
        bool left_obtuse = is_obtuse(apex.place, left.place);
        vec2 ends = vec2(right_obtuse ? FAR : 0.0, left_obtuse ? FAR : 0.0);
        vec4 far = ends.xyxy;
        vec3 l = sqrt(vec3(dot(right.place, right.place), dot(apex.place, apex.place), dot(left.place, left.place)));
        vec2 to_right = apex.place - right.place;
        vec2 to_left = left.place - apex.place;
        vec2 bases = sqrt(vec2(dot(to_right, to_right), dot(to_left, to_left)));
        EndFronts end1 = EndFronts(max(vec2(right.front.x, apex.front.x).xyxy, far), vec2(right.front.y, apex.front.y).xyxy,
                         vec2(right.front.z, apex.front.z).xyxy, vec4(0.0));
        EndFronts end2 = EndFronts(max(vec2(apex.front.x, left.front.x).xyxy, far), vec2(apex.front.y, left.front.y).xyxy,
                         vec2(apex.front.z, left.front.z).xyxy, vec4(0.0));
        vec4 slowness = vec4(0.0);
        if (SLOWED != 0) {
            bool jumps = largest > EVEN_SLOWNESS * least;
            vec3 known = jumps ? vec3(largest) : vec3(right.slowness, apex.slowness, left.slowness);
            slowness = vec4(jumps ? largest : own_slowness);
            end1.slowness = known.xyxy;
            end2.slowness = known.yzyz;
            l *= 0.5 * (slowness.xyz + known);
            bases *= 0.5 * (known.xy + known.yz);
        }
        Fronts parts = update(end1, end2, vec4(surface), slowness, max(l.xyxy, far), max(l.yzyz, far),
                              max(bases.xyxy, far), bvec4(false));
        Fronts others = Fronts(parts.time.yxyx, parts.carried.yxyx, parts.whole.yxyx);
        first = earlier(first, earlier(parts, others));
        if (right_obtuse) {
            left = apex;
            w = apex;
        } else if (left_obtuse) {
            right = apex;
            u = apex;
        } else {
            break;
        }
    }
    return first;
}

// Adds the fronts through the parts of obtuse triangles to the fronts of four points. `left` and `right` tell
// which of their triangles are obtuse.
void add_parts(Places places, bvec4 left, bvec4 right, inout Fronts fronts) {
    if (SPLITS == 0 || !any(either(left, right))) return;
    // One loop handles left and right triangles, since drivers are slow to compile two copies of this code.
    for (int i = 0; i < 8; i++) {
        int k = i & 3;
        if (!(i < 4 ? left[k] : right[k])) continue;
        ivec2 x0 = places.first + (k & 1) * places.to_second + (k >> 1) * places.to_third;
        ivec2 a = i < 4 ? -places.ahead - places.along : -places.ahead;
        Fronts parts = through_parts(x0, a, a + places.along);
        Fronts all = earlier(fronts, parts);
        bvec4 here = equal(ivec4(k), ivec4(0, 1, 2, 3));
        fronts.time = mix(fronts.time, all.time, here);
        fronts.carried = mix(fronts.carried, all.carried, here);
        fronts.whole = either(both(here, all.whole), both(not(here), fronts.whole));
    }
}
