// Computes the beginning of the way to each point. A point that a source's own front reaches first gets the source's
// label instead. On a glued surface this pass also stores when the front of each point arrives, for region_copies.comp.
// One invocation is one point.
// Twin: crates/cpu/src/twins/regions.rs.

#include "shared/edge_image.glsl"
#include "shared/surface_image.glsl"
#include "shared/times.glsl"
#include "update/base_crossing.glsl"

layout(local_size_x = WORKGROUP) in;

#include "passes/regions.glsl"
#include "shared/seams.glsl"
#include "shared/start.glsl"

float carried_at(ivec2 point) {
    return imageLoad(fronts, ivec3(texel_of(point), CARRIED))[component_of(point)];
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(at, grid)) return;
    int index = index_of(at);
    uint start = regions[link_word(1, index)];
    uint label = ~regions[link_word(0, index)];
    float here = time_at(at);
    uint link = NO_REGION;
    vec2 place = vec2(at);
    float arrival = FAR;
    if (is_reached(here)) {
        // The neighbours counter-clockwise from east, with the first repeated at the end. Ways lead only to earlier
        // points, so none leads in a circle. Copies of a point are one point, although their times may differ by
        // rounding.
        float times[9];
        float carried[9];
        float surface[9];
        float sides[9];
        float bases[8];
        int own_copy = first_copy(at);
        ivec2 members = copies_of(at);
        bool has_copies = members.x < members.y;
        for (int i = 0; i < 8; i++) {
            ivec2 other = at + NEIGHBOURS[i];
            float time = time_at(other);
            bool is_before = time < here || (time == here && first_copy(other) < own_copy);
            if (has_copies && is_before) is_before = first_copy(other) != own_copy;
            times[i] = is_before ? time : FAR;
            carried[i] = 0.0;
            surface[i] = 0.0;
            if (CARRIES) {
                carried[i] = carried_at(point_at(other));
                surface[i] = surface_at(point_at(other));
            }
            sides[i] = edge_length(point_at(at), NEIGHBOURS[i]);
            bases[i] = edge_length(point_at(other), NEIGHBOURS[(i + 1) % 8] - NEIGHBOURS[i]);
        }
        times[8] = times[0];
        carried[8] = carried[0];
        surface[8] = surface[0];
        sides[8] = sides[0];
        vec4 own = vec4(CARRIES ? surface_at(point_at(at)) : 0.0);
        float earliest = FAR;
        int first = 0;
        for (int i = 0; i < 8; i += 4) {
            EndFronts end1 = EndFronts(vec4(times[i], times[i + 1], times[i + 2], times[i + 3]),
                             vec4(carried[i], carried[i + 1], carried[i + 2], carried[i + 3]),
                             vec4(surface[i], surface[i + 1], surface[i + 2], surface[i + 3]), vec4(0.0));
            EndFronts end2 = EndFronts(vec4(end1.time.yzw, times[i + 4]),
                             vec4(end1.carried.yzw, carried[i + 4]),
                             vec4(end1.surface.yzw, surface[i + 4]), vec4(0.0));
            vec4 l1 = vec4(sides[i], sides[i + 1], sides[i + 2], sides[i + 3]);
            vec4 l2 = vec4(l1.yzw, sides[i + 4]);
            vec4 base = vec4(bases[i], bases[i + 1], bases[i + 2], bases[i + 3]);
            Fronts found = update(end1, end2, own, vec4(0.0), l1, l2, base, bvec4(false));
            for (int j = 0; j < 4; j++) {
                if (found.time[j] < earliest) {
                    earliest = found.time[j];
                    first = i + j;
                }
            }
        }
        if (start != 0u && time_of(~start) <= earliest) {
            link = KNOWN | label;
            arrival = time_of(~start);
        } else if (earliest < FAR) {
            ivec2 step = NEIGHBOURS[first];
            ivec2 next = NEIGHBOURS[(first + 1) % 8];
            float share = base_crossing(vec2(times[first], times[first + 1]),
                                        vec2(carried[first], carried[first + 1]),
                                        vec2(sides[first], sides[first + 1]), bases[first]);
            place = vec2(at) + (vec2(step) + share * vec2(next - step));
            link = uint(index_of(at + (share > 0.5 ? next : step)));
            arrival = earliest;
        }
    }
    regions[link_word(0, index)] = link;
    write_place(0, index, place);
    if (SEAMS != 0) regions[link_word(1, index)] = rank_of(arrival);
}
