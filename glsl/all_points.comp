#version 450
#extension GL_GOOGLE_include_directive : require
// An update of all points at once from their eight triangles. One invocation is one texel.
// Twin: src/cpu/twins/all_points.rs.

#include "constants.glsl"
#include "texel.glsl"
#include "update.glsl"
#include "front.glsl"
#include "progress.glsl"
#include "anchors.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 0, rgba32f) uniform readonly restrict image2D edges;
layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2D gaussians;
layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray old_fronts;
layout(set = 0, binding = 4, rgba32f) uniform writeonly restrict image2DArray new_fronts;

layout(push_constant) uniform Size {
    ivec2 texels; // columns and rows of texels, without the border
};

// The 4 x 4 points around the texel, row by row, of one layer.
float[16] around(vec4 texels[9]) {
    return float[](texels[0].w, texels[1].z, texels[1].w, texels[2].z,
                   texels[3].y, texels[4].x, texels[4].y, texels[5].x,
                   texels[3].w, texels[4].z, texels[4].w, texels[5].z,
                   texels[6].y, texels[7].x, texels[7].y, texels[8].x);
}

vec4 at_step(float values[16], ivec2 step) {
    int first = 5 + 4 * step.y + step.x;
    return vec4(values[first], values[first + 1], values[first + 4], values[first + 5]);
}

// The lengths of the edges that lead from the four points, shifted by `from`, along `step`.
vec4 edge_lengths(vec4 lengths[16], ivec2 from, ivec2 step) {
    ivec2 at = from + (stored_here(step) ? ivec2(0) : step);
    ivec2 way = stored_here(step) ? step : -step;
    int first = 5 + 4 * at.y + at.x;
    return vec4(stored_length(lengths[first], way), stored_length(lengths[first + 1], way),
                stored_length(lengths[first + 4], way), stored_length(lengths[first + 5], way));
}

vec2 front_at(ivec2 point) {
    vec4 times = imageLoad(old_fronts, ivec3(point / 2, TIME));
    vec4 held = imageLoad(old_fronts, ivec3(point / 2, CURVATURE));
    int i = 2 * (point.y & 1) + (point.x & 1);
    return vec2(times[i], held[i]);
}

float gaussian_at(ivec2 point) {
    return imageLoad(gaussians, point / 2)[2 * (point.y & 1) + (point.x & 1)];
}

int points_in_row() {
    return imageSize(edges).x;
}

#include "anchored.glsl"

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (place.x >= texels.x) return;
    ivec2 texel = place + BORDER;
    bool may_renew = renews != 0u;

    vec4 nine[9];
    for (int i = 0; i < 9; i++) {
        nine[i] = imageLoad(old_fronts, ivec3(texel + ivec2(i % 3, i / 3) - 1, TIME));
    }
    vec4 old = nine[4];
    float times[16] = around(nine);
    float curvatures[16];
    float bends[16];
    vec4 old_curvature = vec4(0.0);
    if (HAS_TWO_LAYERS) {
        for (int i = 0; i < 9; i++) {
            nine[i] = imageLoad(old_fronts, ivec3(texel + ivec2(i % 3, i / 3) - 1, CURVATURE));
        }
        old_curvature = nine[4];
        curvatures = around(nine);
        for (int i = 0; i < 9; i++) {
            nine[i] = imageLoad(gaussians, texel + ivec2(i % 3, i / 3) - 1);
        }
        bends = around(nine);
    }
    vec4 lengths[16];
    for (int i = 0; i < 16; i++) {
        lengths[i] = imageLoad(edges, 2 * texel - 1 + ivec2(i % 4, i / 4));
    }

    vec4 time = old;
    vec4 curvature = old_curvature;
    for (int scan = 0; scan < 4; scan++) {
        int way = 1 - 2 * (scan & 1);
        ivec2 ahead = scan < 2 ? ivec2(0, way) : ivec2(way, 0);
        ivec2 along = scan < 2 ? ivec2(1, 0) : ivec2(0, 1);
        Ends ends[3];
        vec4 to[3];
        for (int i = 0; i < 3; i++) {
            ivec2 step = -ahead + (i - 1) * along;
            ends[i] = Ends(at_step(times, step), vec4(0.0), vec4(0.0));
            if (HAS_TWO_LAYERS) {
                ends[i].curvature = at_step(curvatures, step);
                ends[i].gaussian = at_step(bends, step);
            }
            to[i] = edge_lengths(lengths, ivec2(0), step);
        }
        Fronts fronts;
        if (HAS_ANCHORS) {
            Sight sight = Sight(ends, to);
            Places four = Places(2 * texel, ivec2(1, 0), ivec2(0, 1), ahead, along);
            fronts = ways_to(sight, four, 15u, uint(scan) + 1u, may_renew, time, curvature);
        } else {
            vec4 base_left = edge_lengths(lengths, -ahead - along, along);
            vec4 base_right = edge_lengths(lengths, -ahead, along);
            vec4 own = HAS_TWO_LAYERS ? at_step(bends, ivec2(0)) : vec4(0.0);
            bvec4 alone = are_alone(to[1]);
            fronts = earlier(update(ends[0], ends[1], own, to[0], to[1], base_left, alone),
                             update(ends[1], ends[2], own, to[1], to[2], base_right, alone));
        }
        accept(fronts, uint(scan) + 1u, may_renew, time, curvature);
    }
    imageStore(new_fronts, ivec3(texel, TIME), time);
    if (HAS_TWO_LAYERS) imageStore(new_fronts, ivec3(texel, CURVATURE), curvature);
    uint change = change_of(old, time, old_curvature, curvature);
    if (change > 0u) atomicMax(residual, change);
}
