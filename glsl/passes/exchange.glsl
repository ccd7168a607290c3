// Offers to each copy of a point the earliest front of all copies, on one map.
//
// Each workgroup handles one map, since its invocations wait for each other: all fronts are read before any is
// written. First, each invocation finds the earliest front of some parts of groups. A pole has many copies,
// so its group has many parts. Then each invocation writes some texels. Copies of several points may lie in
// one texel.
//
// Twin: crates/cpu/src/fronts/exchange.rs.
//
// The including shader defines
//     void load(ivec2 texel, out vec4 time, out vec4 held)
//     void store(ivec2 texel, vec4 time, vec4 held)     the fronts of a texel
//     bool renews_fronts()                              whether fronts are renewed
//     int slot_of(int part)                             number of the place for the earliest front of a part
//     void note_changes(ivec2 texel, vec4 time_before, vec4 held_before, vec4 time, vec4 held)
//                                                       records that fronts of a texel have changed

#include "update/wavefront.glsl"
#include "passes/copies.glsl"

// Finds the earliest front among the members of a part of a group. Fronts that an earlier exchange has
// brought do not count: the fronts from which they were copied may have been renewed since.
void gather(int part) {
    bool found = false;
    float time = FAR;
    float held = 0.0;
    uint end = copies[part + 1];
    for (uint member = copies[part]; member < end; member++) {
        ivec2 point = point_of_member(member);
        vec4 times;
        vec4 carried;
        load(texel_of(point), times, carried);
        int i = component_of(point);
        if (times[i] >= FAR || scan_of(carried[i]) == uint(EXCHANGED)) continue;
        take_first(times[i], carried[i], found, time, held);
    }
    copies[earliest_at(slot_of(part))] = floatBitsToUint(time);
    copies[earliest_at(slot_of(part)) + 1] = floatBitsToUint(held);
}

// Returns the earliest front of a group; its time is FAR if there is none.
vec2 earliest_of(int group) {
    bool found = false;
    vec2 front = vec2(FAR, 0.0);
    uint end = copies[first_group() + group + 1];
    for (uint part = copies[first_group() + group]; part < end; part++) {
        float time = uintBitsToFloat(copies[earliest_at(slot_of(int(part)))]);
        float held = uintBitsToFloat(copies[earliest_at(slot_of(int(part))) + 1]);
        if (time < FAR) take_first(time, held, found, front.x, front.y);
    }
    return front;
}

// Returns the front at a point after the earliest front of its copies has arrived there.
vec2 after_arrival(vec2 first, vec2 before) {
    bool is_own = floatBitsToUint(first) == floatBitsToUint(before);
    if (first.x >= FAR || is_own) return before;
    Fronts arrival = Fronts(vec4(first.x), vec4(first.y), bvec4((tag_of(first.y) & uint(WHOLE)) != 0u));
    uint scan = scan_of(first.y) == uint(EXACT) ? uint(EXACT) : uint(EXCHANGED);
    vec4 time = vec4(before.x);
    vec4 held = vec4(before.y);
    accept(arrival, scan, renews_fronts(), time, held);
    return vec2(time.x, held.x);
}

void scatter(int index) {
    ivec2 texel = unpacked(copies[copy_texel_at(index)]);
    vec4 time_before;
    vec4 held_before;
    load(texel, time_before, held_before);
    vec4 time = time_before;
    vec4 held = held_before;
    for (int j = 0; j < 4; j++) {
        int group = int(copies[copy_texel_at(index) + 1 + j]) - 1;
        if (group < 0) continue;
        vec2 after = after_arrival(earliest_of(group), vec2(time[j], held[j]));
        time[j] = after.x;
        held[j] = after.y;
    }
    bvec4 stays = equal(floatBitsToUint(time), floatBitsToUint(time_before));
    if (all(stays) && floatBitsToUint(held) == floatBitsToUint(held_before)) return;
    store(texel, time, held);
    note_changes(texel, time_before, held_before, time, held);
}

void exchange_all() {
    int own = int(gl_LocalInvocationIndex);
    for (int part = own; part < parts; part += EXCHANGE_WORKGROUP) gather(part);
    memoryBarrierBuffer();
    memoryBarrierImage();
    barrier();
    for (int index = own; index < copy_texels; index += EXCHANGE_WORKGROUP) scatter(index);
}
