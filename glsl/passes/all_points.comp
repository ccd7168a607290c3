#version 450
#extension GL_GOOGLE_include_directive : require
// Updates all points at once from their eight triangles. One invocation is one texel.
// Twin: src/cpu/twins/all_points.rs.

#include "shared/constants.glsl"
#include "shared/chart.glsl"
#define WITH_ORIGINS
#include "update/wavefront.glsl"
#include "shared/edge_image.glsl"
#include "shared/surface_image.glsl"
#include "shared/progress.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray old_fronts;
layout(set = 2, binding = 0, rgba32f) uniform writeonly restrict image2DArray new_fronts;

layout(push_constant) uniform Size {
    ivec2 texels; // columns and rows of texels, without the border
};

// Returns the 4 x 4 points around the texel, row by row, from one layer of the 3 x 3 texels around it.
float[16] around(vec4 texels[9]) {
    return float[](texels[0].w, texels[1].z, texels[1].w, texels[2].z,
                   texels[3].y, texels[4].x, texels[4].y, texels[5].x,
                   texels[3].w, texels[4].z, texels[4].w, texels[5].z,
                   texels[6].y, texels[7].x, texels[7].y, texels[8].x);
}

// The index of the texel's first point among the 4 x 4 points around the texel.
const int FIRST = 5;

// Returns the values at the texel's four points, shifted by `step`.
vec4 at_step(float values[16], ivec2 step) {
    ivec4 four = FIRST + corners_row_major(step, 4);
    return vec4(values[four.x], values[four.y], values[four.z], values[four.w]);
}

// Returns the lengths of the edges that lead along `step` from the four points shifted by `from`.
vec4 edge_lengths(vec4 lengths[16], ivec2 from, ivec2 step) {
    bool here = stored_here(step);
    ivec2 at = from + (here ? ivec2(0) : step);
    ivec2 way = here ? step : -step;
    ivec4 four = FIRST + corners_row_major(at, 4);
    return vec4(stored_length(lengths[four.x], way), stored_length(lengths[four.y], way),
                stored_length(lengths[four.z], way), stored_length(lengths[four.w], way));
}

vec2 front_at(ivec2 point) {
    ivec2 texel = texel_of(point);
    vec4 times = imageLoad(old_fronts, ivec3(texel, TIME));
    vec4 carried = imageLoad(old_fronts, ivec3(texel, CARRIED));
    return vec2(times[component_of(point)], carried[component_of(point)]);
}

#include "update/splits.glsl"
#include "update/anchored_ways.glsl"

void main() {
    ivec2 inner = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(inner, texels)) return;
    ivec2 texel = with_border(inner);
    bool may_renew = renews != 0u;
    if (gl_LocalInvocationIndex == 0u) atomicAdd(visited, 1u);
    causal = fronts_meet != 0u;
    holds = fronts_meet != FRONTS_ARE_ADDED;
    latest = limit;

    vec4 nine[9];
    for (int i = 0; i < 9; i++) {
        nine[i] = imageLoad(old_fronts, ivec3(texel + around_texel(i), TIME));
    }
    vec4 old = nine[4];
    float times[16] = around(nine);
    float carried_around[16];
    float surface_around[16];
    float slowness_around[16];
    vec4 old_carried = vec4(0.0);
    if (CARRIES) {
        for (int i = 0; i < 9; i++) {
            nine[i] = imageLoad(old_fronts, ivec3(texel + around_texel(i), CARRIED));
        }
        old_carried = nine[4];
        carried_around = around(nine);
        for (int i = 0; i < 9; i++) {
            nine[i] = surface_of(texel + around_texel(i));
        }
        surface_around = around(nine);
    }
    if (SLOWED != 0) {
        for (int i = 0; i < 9; i++) {
            nine[i] = slowness_of(texel + around_texel(i));
        }
        slowness_around = around(nine);
    }
    vec4 lengths[16];
    for (int i = 0; i < 16; i++) {
        lengths[i] = imageLoad(edges, first_point(texel) - 1 + from_row_major(i, 4));
    }

    vec4 time = old;
    vec4 carried = old_carried;
    for (int scan = 0; scan < 4; scan++) {
        ivec2 ahead = ahead_of(scan);
        ivec2 along = along_of(scan);
        NeighboursBehind sight;
        for (int i = 0; i < 3; i++) {
            ivec2 step = -ahead + (i - 1) * along;
            sight.ends[i] = EndFronts(at_step(times, step), vec4(0.0), vec4(0.0), vec4(0.0));
            if (SLOWED != 0) sight.ends[i].slowness = at_step(slowness_around, step);
            if (CARRIES) {
                sight.ends[i].carried = at_step(carried_around, step);
                sight.ends[i].surface = at_step(surface_around, step);
            }
            sight.edges[i] = edge_lengths(lengths, ivec2(0), step);
        }
        Fronts fronts;
        Places four = Places(first_point(texel), ivec2(1, 0), ivec2(0, 1), ahead, along);
        if (HAS_ANCHORS) {
            fronts = ways_to(sight, four, 15u, uint(scan) + 1u, may_renew, time, carried);
        } else {
            vec4 base_left = edge_lengths(lengths, -ahead - along, along);
            vec4 base_right = edge_lengths(lengths, -ahead, along);
            vec4 own = CARRIES ? at_step(surface_around, ivec2(0)) : vec4(0.0);
            vec4 own_slowness = SLOWED != 0 ? at_step(slowness_around, ivec2(0)) : vec4(0.0);
            fronts = update_four(sight, own, own_slowness, base_left, base_right, four);
            bvec4 left = are_obtuse_at_x0(sight.ends[0], sight.ends[1], own_slowness, sight.edges[0], sight.edges[1], base_left);
            bvec4 right = are_obtuse_at_x0(sight.ends[1], sight.ends[2], own_slowness, sight.edges[1], sight.edges[2], base_right);
            add_parts(four, left, right, fronts);
        }
        accept(fronts, uint(scan) + 1u, may_renew, time, carried);
    }
    imageStore(new_fronts, ivec3(texel, TIME), time);
    if (CARRIES) imageStore(new_fronts, ivec3(texel, CARRIED), carried);
    uint change = change_of(old, time, old_carried, carried);
    if (change > 0u) atomicMax(residual, change);
}
