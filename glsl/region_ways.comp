#version 450
#extension GL_GOOGLE_include_directive : require
// The beginning of the way to each point, or the label of a point that no front reaches before a
// source's own. One invocation is one point.

#include "constants.glsl"
#include "texel.glsl"
#include "fan.glsl"
#include "times.glsl"
#include "update.glsl"
#include "base_crossing.glsl"

layout(local_size_x = WORKGROUP) in;

layout(set = 0, binding = 1, rgba32f) uniform readonly restrict image2D gaussians;

#include "regions.glsl"
#include "start.glsl"

const bool IS_CURVED = WAVEFRONT == 2;

float curvature_at(ivec2 point) {
    ivec2 at = point + 2 * BORDER;
    return imageLoad(fronts, ivec3(at / 2, CURVATURE))[(at.x & 1) + 2 * (at.y & 1)];
}

float gaussian_at(ivec2 point) {
    ivec2 at = point + 2 * BORDER;
    return imageLoad(gaussians, at / 2)[(at.x & 1) + 2 * (at.y & 1)];
}

void main() {
    ivec2 point = ivec2(gl_GlobalInvocationID.xy);
    if (point.x >= grid.x) return;
    int index = index_of(point);
    uint start = regions[link_word(1, index)];
    uint label = ~regions[link_word(0, index)];
    float here = time_at(point);
    uint link = NO_REGION;
    vec2 place = vec2(point);
    if (is_reached(here)) {
        // The neighbours counter-clockwise from east, and the first again. Ways lead to earlier
        // points alone, so that none leads in a circle.
        float times[9];
        float curvatures[9];
        float bends[9];
        float sides[9];
        float bases[8];
        for (int i = 0; i < 8; i++) {
            ivec2 other = point + FAN[i];
            float time = time_at(other);
            bool is_before = time < here || (time == here && index_of(other) < index);
            times[i] = is_before ? time : FAR;
            curvatures[i] = 0.0;
            bends[i] = 0.0;
            if (IS_CURVED) {
                curvatures[i] = curvature_at(other);
                bends[i] = gaussian_at(other);
            }
            sides[i] = edge_length(point + 2 * BORDER, FAN[i]);
            bases[i] = edge_length(other + 2 * BORDER, FAN[(i + 1) % 8] - FAN[i]);
        }
        times[8] = times[0];
        curvatures[8] = curvatures[0];
        bends[8] = bends[0];
        sides[8] = sides[0];
        vec4 own = vec4(IS_CURVED ? gaussian_at(point) : 0.0);
        float earliest = FAR;
        int first = 0;
        for (int i = 0; i < 8; i += 4) {
            Ends end1 = Ends(vec4(times[i], times[i + 1], times[i + 2], times[i + 3]),
                             vec4(curvatures[i], curvatures[i + 1], curvatures[i + 2], curvatures[i + 3]),
                             vec4(bends[i], bends[i + 1], bends[i + 2], bends[i + 3]));
            Ends end2 = Ends(vec4(end1.time.yzw, times[i + 4]),
                             vec4(end1.curvature.yzw, curvatures[i + 4]),
                             vec4(end1.gaussian.yzw, bends[i + 4]));
            vec4 l1 = vec4(sides[i], sides[i + 1], sides[i + 2], sides[i + 3]);
            vec4 l2 = vec4(l1.yzw, sides[i + 4]);
            vec4 base = vec4(bases[i], bases[i + 1], bases[i + 2], bases[i + 3]);
            Fronts found = update(end1, end2, own, l1, l2, base, bvec4(false));
            for (int j = 0; j < 4; j++) {
                if (found.time[j] < earliest) {
                    earliest = found.time[j];
                    first = i + j;
                }
            }
        }
        if (start != 0u && time_of(~start) <= earliest) {
            link = KNOWN | label;
        } else if (earliest < FAR) {
            ivec2 step = FAN[first];
            ivec2 next = FAN[(first + 1) % 8];
            float share = base_crossing(vec2(times[first], times[first + 1]),
                                        vec2(curvatures[first], curvatures[first + 1]),
                                        vec2(sides[first], sides[first + 1]), bases[first]);
            place = vec2(point) + (vec2(step) + share * vec2(next - step));
            link = uint(index_of(point + (share > 0.5 ? next : step)));
        }
    }
    regions[link_word(0, index)] = link;
    write_place(0, index, place);
}
