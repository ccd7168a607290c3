// Extends the ways of all points by the ways of the points around their ends, and takes over the label of the
// nearest point there once it is known. One invocation is one point.
// Twin: crates/cpu/src/twins/regions.rs.

#include "shared/cell.glsl"

layout(local_size_x = WORKGROUP) in;

#include "passes/regions.glsl"

// Extends a way by the ways of the points around its end, or takes the label of the nearest of these points.
// Returns false if no way leads on.
bool step_on(inout uint link, inout vec2 place) {
    vec2 first = floor(place);
    vec4 weights = bilinear(place - first);
    ivec4 corners = corners_row_major(ivec2(first), grid.x);
    uvec4 links = uvec4(NO_REGION);
    float heaviest = 0.0;
    int nearest = 0;
    for (int i = 0; i < 4; i++) {
        if (weights[i] <= 0.0) continue;
        links[i] = regions[link_word(from, corners[i])];
        if (links[i] != NO_REGION && weights[i] > heaviest) {
            heaviest = weights[i];
            nearest = i;
        }
    }
    if (heaviest == 0.0) return false;
    if (is_known(links[nearest])) {
        link = links[nearest];
        return true;
    }
    vec2 on = place_at(from, corners[nearest]);
    vec2 off = vec2(0.0);
    float sum = 0.0;
    for (int i = 0; i < 4; i++) {
        if (is_known(links[i])) continue;
        vec2 apart = place_at(from, corners[i]) - on;
        // The front of this point comes from another side.
        if (max(abs(apart.x), abs(apart.y)) > NEAR_PLACES) continue;
        sum += weights[i];
        off += weights[i] * apart;
    }
    place = back_on_grid(on + off / sum, grid);
    return true;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(at, grid)) return;
    int index = index_of(at);
    uint link = regions[link_word(from, index)];
    if (!is_known(link)) {
        vec2 place = place_at(from, index);
        for (int i = 0; i < FLOW_JUMPS; i++) {
            if (is_known(link) || !step_on(link, place)) break;
        }
        write_place(1 - from, index, place);
    }
    regions[link_word(1 - from, index)] = link;
}
