// Which front a point keeps. Include after update.glsl. Twins: accept() and
// accept_anchored() in src/cpu/state.rs.

vec4 with_tags(vec4 values, uvec4 tags) {
    return vec4(with_tag(values.x, tags.x), with_tag(values.y, tags.y),
                with_tag(values.z, tags.z), with_tag(values.w, tags.w));
}

// Accepts fronts, brought by a scan numbered from 1, that are the first to arrive. Of those that arrive
// together whole triangles know better, then the front that is flatter by more than rounding; and
// those that this scan has brought before may be renewed, earlier or later, but for what rounding
// alone has changed. Else the one that is there stays.
// With anchors those are accepted that are shorter by more than rounding, or come again.
void accept(Fronts fronts, uint scan, bool renews, inout vec4 time, inout vec4 curvature) {
    if (WAVEFRONT < 2) {
        time = min(time, fronts.time);
    } else if (HAS_ANCHORS) {
        const float alike = 1.0 - ALIKE * PRECISION;
        vec4 tagged = with_tags(fronts.curvature, uvec4(scan));
        uvec4 held = floatBitsToUint(curvature);
        bvec4 first = lessThan(fronts.time, time * alike);
        bvec4 as_long = not(either(first, lessThan(time, fronts.time * alike)));
        bvec4 is_same = both(as_long, equal((held ^ floatBitsToUint(tagged)) & ~15u, uvec4(0u)));
        bvec4 again = both(both(bvec4(renews), lessThan(time, vec4(FAR))), equal(held & 7u, uvec4(scan)));
        bvec4 accepted = either(first, both(again, not(is_same)));
        curvature = mix(curvature, tagged, accepted);
        time = mix(time, fronts.time, accepted);
    } else {
        vec4 tagged = with_tags(fronts.curvature, mix(uvec4(scan), uvec4(scan | WHOLE), fronts.whole));
        uvec4 tag_before = floatBitsToUint(curvature) & 15u;
        bvec4 whole_before = greaterThanEqual(tag_before, uvec4(WHOLE));
        bvec4 alike = equal(uvec4(fronts.whole), uvec4(whole_before));
        bvec4 apart = greaterThan(curvature - tagged, abs(tagged) * BENT_APART);
        bvec4 flatter = both(alike, apart);
        bvec4 knows = either(both(fronts.whole, not(whole_before)), flatter);
        bvec4 reached = lessThan(time, vec4(FAR));
        bvec4 ties = both(reached, together(fronts.time, time));
        vec4 rounding = abs(tagged) * (BENT_AGAIN * PRECISION);
        bvec4 bends_alike = both(alike, lessThanEqual(abs(curvature - tagged), rounding));
        bvec4 is_new = not(both(ties, bends_alike));
        bvec4 comes_again = both(both(bvec4(renews), reached), equal(tag_before & 7u, uvec4(scan)));
        bvec4 first = either(both(not(ties), lessThan(fronts.time, time)), both(ties, knows));
        bvec4 accepted = either(first, both(comes_again, is_new));
        curvature = mix(curvature, tagged, accepted);
        vec4 arrival = mix(fronts.time, min(time, fronts.time), ties);
        time = mix(time, arrival, accepted);
    }
}

uint largest(uvec4 values) {
    return max(max(values.x, values.y), max(values.z, values.w));
}

// How much fronts have changed: the largest difference of arrival times in units of the last
// place, or what a change of curvature counts beside it, or another anchor.
uint change_of(vec4 old_time, vec4 time, vec4 old_curvature, vec4 curvature) {
    uvec4 old_bits = floatBitsToUint(old_time);
    uvec4 bits = floatBitsToUint(time);
    uvec4 units = max(old_bits, bits) - min(old_bits, bits);
    if (WAVEFRONT < 2) return largest(units);
    if (HAS_ANCHORS) {
        uvec4 turned = (floatBitsToUint(old_curvature) ^ floatBitsToUint(curvature)) & ~15u;
        return max(largest(units), largest(turned) != 0u ? uint(ANCHOR_COUNTS / PRECISION) : 0u);
    }
    vec4 bends = abs(curvature - old_curvature) * time;
    float bend = max(max(bends.x, bends.y), max(bends.z, bends.w)) * (CURVATURE_COUNTS / PRECISION);
    // However large, it is not taken for a point's first front.
    return max(largest(units), uint(min(bend, 1.0 / PRECISION)));
}
