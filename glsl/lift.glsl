// Lifts the vertices of curves to the surface: what the shaders lift_from_*.comp share. The
// workgroups in line of a dispatch are one curve, with an invocation for every so many vertices.
//
// The including shader defines
//     float component(ivec2 at, int index)              of what the host holds for a point
// Twin: Curve::lift in src/geometry/curve.rs.

float component(ivec2 at, int index);

layout(push_constant) uniform Lift {
    ivec2 grid;       // columns and rows of the whole grid
    int first_word;   // of the host's buffer
    int stride;       // words from point to point
    vec2 spacing;     // along columns and rows of a height field; 0 if points have positions
    int first_vertex; // its word
    int capacity;     // vertices of a curve, at most
};

vec3 position_at(ivec2 at) {
    if (spacing.x > 0.0) return vec3(spacing * vec2(at), component(at, 0));
    return vec3(component(at, 0), component(at, 1), component(at, 2));
}

bool is_present(vec3 position) {
    return is_usable(position.x) && is_usable(position.y) && is_usable(position.z);
}

// Bilinear between four points, linear between three beside a hole.
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
