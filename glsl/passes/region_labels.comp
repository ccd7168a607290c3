// Labels points whose way has led nowhere with the label of their first ancestor that has one. The parent of
// a point is the nearer end of the base that its way crosses, which is always earlier. One invocation is one
// point.
// Twin: crates/cpu/src/twins/regions.rs.

layout(local_size_x = WORKGROUP) in;

#include "passes/regions.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(at, grid)) return;
    int index = index_of(at);
    uint link = regions[link_word(from, index)];
    for (int i = 0; i < PARENT_JUMPS && !is_known(link); i++) {
        link = regions[link_word(from, int(link))];
    }
    if (is_last != 0u) link = is_known(link) && link != NO_REGION ? link & ~KNOWN : NO_REGION;
    regions[link_word(1 - from, index)] = link;
}
