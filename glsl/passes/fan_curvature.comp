// Computes the Gaussian curvature of each point's fan of triangles from edge lengths. It is written to the
// layer CARRIED of the second image of fronts, which is free until a map starts. One invocation is one texel.
// Twin: crates/surface/src/gaussian_curvature.rs, where the formulas are explained.

#include "update/tag.glsl"
#include "shared/edge_image.glsl"

layout(local_size_x = WORKGROUP) in;

#include "shared/surface_image.glsl"

layout(set = 0, binding = 2, rgba32f) uniform writeonly restrict image2DArray fronts_1;

layout(push_constant) uniform Size {
    ivec2 texels;       // columns and rows of texels, without the border
    float share_of_fan; // share of a fan's area to which its angle defect belongs
    uint is_slowed;     // whether the slowness of the surface varies
    ivec2 grid;         // columns and rows of the whole grid
    ivec2 lattice;      // see lattice.glsl
};

#include "shared/lattice.glsl"
#include "passes/over_seams.glsl"

// Returns the slowness at a point, which may lie beyond a side where the grid goes on.
float slowness_beside(ivec2 point) {
    return slowness_at(point_over_seams(point));
}

// Returns the length of an edge on the surface, without the slowness.
float length_on_surface(ivec2 point, ivec2 step) {
    float length = edge_over_seams(point, step);
    if (is_slowed == 0u || length >= FAR) return length;
    return (length + length) / (slowness_beside(point) + slowness_beside(point + step));
}

float squared(ivec2 point, ivec2 step) {
    float length = length_on_surface(point, step);
    return length * length;
}

// Returns the Gaussian curvature at a point, in the surface's metric scaled by the slowness. `gaussian` is
// the curvature of the surface itself.
float slowed(ivec2 point, float gaussian) {
    float own = slowness_at(point);
    float per_square = 1.0 / (own * own);
    if ((tag_of(own) & JUMPS) != 0u) return gaussian * per_square;
    float rise[8];
    for (int i = 0; i < 8; i++) rise[i] = log(slowness_beside(point + NEIGHBOURS[i]) / own);
    float flow = 0.0;
    float area = 0.0;
    for (int i = 0; i < 8; i++) {
        ivec2 to = NEIGHBOURS[i];
        ivec2 next = NEIGHBOURS[(i + 1) % 8];
        float first = squared(point, to);
        float second = squared(point, next);
        float inner = 0.5 * (first + second - squared(point + to, next - to));
        area += 0.5 * sqrt(max(first * second - inner * inner, 0.0));
        if ((i & 1) == 1) continue;
        // The neighbours to the left and right of `to`, as seen from the point.
        ivec2 left = NEIGHBOURS[(i + 2) % 8];
        ivec2 right = NEIGHBOURS[(i + 6) % 8];
        ivec2 previous = NEIGHBOURS[(i + 7) % 8];
        ivec2 there = point + to;
        float along = 0.25 * (squared(there, left) + squared(there, right) + squared(point, left) + squared(point, right));
        float skew = 0.125 * ((squared(point, next) - squared(there, left - to))
                              + (squared(there, right - to) - squared(point, previous)));
        float rises_along = 0.25 * (rise[(i + 1) % 8] - rise[(i + 7) % 8] + rise[(i + 2) % 8] - rise[(i + 6) % 8]);
        flow += (along * rise[i] - skew * rises_along) / sqrt(max(first * along - skew * skew, 1e-37));
    }
    float curvature = (gaussian - flow / (0.25 * area)) * per_square;
    return isinf(curvature) || isnan(curvature) ? gaussian * per_square : curvature;
}

// Returns the Gaussian curvature of a fan. If a triangle is missing, the result is zero with a tag.
float fan_curvature(ivec2 point) {
    bool whole = true;
    bool lacks = false;
    vec2 turn = vec2(1.0, 0.0);
    float area = 0.0;
    float a = length_on_surface(point, NEIGHBOURS[0]);
    for (int i = 0; i < 8; i++) {
        ivec2 to = NEIGHBOURS[(i + 1) % 8];
        float b = length_on_surface(point, to);
        float c = length_on_surface(point + NEIGHBOURS[i], to - NEIGHBOURS[i]);
        float longest = max(max(a, b), c);
        if (longest >= FAR) {
            lacks = true;
            a = b;
            continue;
        }
        whole = whole && longest + longest < a + b + c;
        float x = 0.5 * ((a * a + b * b) - c * c) / (a * b);
        float y = sqrt(max((1.0 - x) * (1.0 + x), 0.0));
        turn = vec2(turn.x * x - turn.y * y, turn.x * y + turn.y * x);
        area = area + 0.5 * (a * b) * y;
        a = b;
    }
    // Beside a hole or the border, `turn` has the cosine and sine of the angle that is open to fronts.
    if (lacks) return with_tag(0.0, turn.y < min(0.0, REFLEX * turn.x) ? LACKING | DIFFRACTS : LACKING);
    if (!whole) return with_tag(0.0, LACKING);
    float tangent = turn.x > 0.0 ? clamp(-turn.y / turn.x, -LARGEST_DEFECT, LARGEST_DEFECT)
                                 : (turn.y > 0.0 ? -LARGEST_DEFECT : LARGEST_DEFECT);
    float square = tangent * tangent;
    float defect = tangent * (1.0 - square * (1.0 / 3.0 - square * (1.0 / 5.0 - square * (1.0 / 7.0))));
    float signal = defect * defect / (defect * defect + DEFECT_NOISE * DEFECT_NOISE);
    float curvature = defect * signal / (share_of_fan * area);
    return with_tag(is_slowed != 0u ? slowed(point, curvature) : curvature, 0u);
}

void main() {
    ivec2 inner = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(inner, texels)) return;
    ivec2 texel = with_border(inner);
    vec4 curvature;
    for (int i = 0; i < 4; i++) {
        ivec2 point = first_point(texel) + to_corner(i);
        curvature[i] = in_grid(at_point(point), grid) ? fan_curvature(point) : with_tag(0.0, LACKING);
    }
    imageStore(fronts_1, ivec3(texel, CARRIED), curvature);
}
