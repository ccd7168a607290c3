// Gives all copies of a point of a glued surface the way on which its front has come. At first each copy has a way
// through the cells of its own side alone. The right one is the way of the copy whose front has arrived first. One
// invocation is one group of copies.
// Twin: share_ways() in crates/cpu/src/twins/regions.rs.

layout(local_size_x = WORKGROUP) in;

#include "passes/regions.glsl"

layout(set = 0, binding = 3) readonly restrict buffer CopiesByRow {
    uint copies[];
};

#include "shared/copies_by_row.glsl"

void main() {
    int group = int(gl_GlobalInvocationID.x);
    if (group >= groups_in_list()) return;
    ivec2 members = members_of_group(group);
    int first = member_index(members.x);
    for (int i = members.x + 1; i < members.y; i++) {
        int other = member_index(i);
        if (regions[link_word(1, other)] < regions[link_word(1, first)]) first = other;
    }
    uint link = regions[link_word(0, first)];
    vec2 place = place_at(0, first);
    for (int i = members.x; i < members.y; i++) {
        int copy = member_index(i);
        regions[link_word(0, copy)] = link;
        write_place(0, copy, place);
    }
}
