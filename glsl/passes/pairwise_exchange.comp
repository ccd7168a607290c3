// Gives all copies of a point of a glued surface the earliest front among them, on all maps of a batch that are
// not done. It runs after the start and after each scan. One workgroup is one map, and the third dimension of the
// dispatch is the map's number; see exchange.glsl.
// Twin: crates/cpu/src/fronts/exchange.rs.

#include "passes/pairwise_progress.glsl"
#include "passes/pairwise_layers.glsl"
#include "shared/groups.glsl"

layout(push_constant) uniform Push {
    int parts;
    int members;
    int groups;
    int copy_texels; // number of texels with copies
};

layout(local_size_x = EXCHANGE_WORKGROUP) in;

// The image that was written last.
layout(set = 2, binding = 0, rgba32f) uniform restrict image2DArray new_fronts;

#include "passes/copies.glsl"

uint map() {
    return group_number().z;
}

void load(ivec2 texel, out vec4 time, out vec4 held) {
    held = vec4(0.0);
    time = imageLoad(new_fronts, ivec3(texel, layer_of(map(), TIME)));
    if (CARRIES) held = imageLoad(new_fronts, ivec3(texel, layer_of(map(), CARRIED)));
}

void store(ivec2 texel, vec4 time, vec4 held) {
    imageStore(new_fronts, ivec3(texel, layer_of(map(), TIME)), time);
    if (CARRIES) imageStore(new_fronts, ivec3(texel, layer_of(map(), CARRIED)), held);
}

bool renews_fronts() {
    return maps[map()].renews != 0u;
}

int slot_of(int part) {
    return int(map()) * parts + part;
}

void note_changes(ivec2 texel, vec4 time_before, vec4 held_before, vec4 time, vec4 held) {
    atomicMax(maps[map()].residual, change_of(time_before, time, held_before, held));
}

#include "passes/exchange.glsl"

void main() {
    if (maps[map()].done == 0u) exchange_all();
}
