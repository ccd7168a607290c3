// Gives all copies of a point of a glued surface the largest of their words. It runs after each pass over the sources:
// these passes store complements, of which the largest stands for the earliest front or the first source. One
// invocation is one group of copies.
// Twin: share_starts() in crates/cpu/src/twins/regions.rs.

layout(local_size_x = WORKGROUP) in;

layout(push_constant) uniform Push {
    ivec2 grid;     // columns and rows of the whole grid
    int first_word; // place of the first point's word
};

layout(set = 1, binding = 1) restrict buffer Output {
    uint words[];
};

layout(set = 0, binding = 3) readonly restrict buffer CopiesByRow {
    uint copies[];
};

#include "shared/copies_by_row.glsl"

void main() {
    int group = int(gl_GlobalInvocationID.x);
    if (group >= groups_in_list()) return;
    ivec2 members = members_of_group(group);
    uint largest = 0u;
    for (int i = members.x; i < members.y; i++) largest = max(largest, words[first_word + member_index(i)]);
    for (int i = members.x; i < members.y; i++) words[first_word + member_index(i)] = largest;
}
