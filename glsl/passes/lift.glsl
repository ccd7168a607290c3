// Lifts the vertices of curves to the surface, for the shaders lift_from_*.comp. One row of workgroups of a
// dispatch is one curve. One invocation handles every n-th vertex, where n is the number of invocations in
// the row.
// Twin: Curve::lift in crates/geometry/src/curve.rs.
//
// The including shader defines
//     float component(ivec2 at, int index)              a component of the host's data for a point

#include "shared/cell.glsl"
#include "shared/usable.glsl"
#include "shared/curve.glsl"

float component(ivec2 at, int index);

layout(push_constant) uniform Lift {
    ivec2 grid;       // columns and rows of the whole grid
    int first_word;   // offset in the host's buffer
    int stride;       // words from point to point
    vec2 spacing;     // spacing of columns and rows of a height field; 0 if points have positions
    int first_vertex; // index of the word at which the vertices begin
    int capacity;     // largest number of vertices of a curve
};

// Returns the position of a point.
vec3 position_at(ivec2 at) {
    if (spacing.x > 0.0) return vec3(spacing * vec2(at), component(at, 0));
    return vec3(component(at, 0), component(at, 1), component(at, 2));
}

bool is_present(vec3 position) {
    return is_usable(position.x) && is_usable(position.y) && is_usable(position.z);
}

// Interpolates the position of a place: bilinearly between four points, linearly between three beside a hole.
vec3 lifted(vec2 place) {
    ivec2 first = ivec2(place);
    vec3 corners[4];
    bvec4 there;
    for (int i = 0; i < 4; i++) {
        corners[i] = position_at(up_to_last(first + to_corner(i), grid));
        there[i] = is_present(corners[i]);
    }
    vec4 weights;
    vec3 position = vec3(0.0);
    corner_weights(there, place - vec2(first), weights);
    for (int i = 0; i < 4; i++) {
        if (there[i] && weights[i] > 0.0) position += weights[i] * corners[i];
    }
    return position;
}

void main() {
    int curve = int(gl_WorkGroupID.y);
    int count = int(min(vertices_of(curve), uint(capacity)));
    int together = int(gl_NumWorkGroups.x) * WORKGROUP;
    for (int i = int(gl_GlobalInvocationID.x); i < count; i += together) {
        int at = first_vertex + VERTEX_WORDS * (curve * capacity + i);
        vec2 place = place_at(at);
        if (is_on_grid(place, grid)) write_position(at, lifted(place));
    }
}
