// Gives the copies of each point of a glued surface the mean of their Gaussian curvatures. A point inside the glued
// surface has all its triangles, although each copy alone has only some of them. So the tag of such a point is cleared.
//
// A single workgroup is dispatched, since its invocations wait for each other. First, each invocation adds up some
// parts of groups, then finds the values of some groups, then writes some texels. Points in the middles of folded
// sides are groups of one member.
// Twin: crates/surface/src/gluing/curvature.rs. How rings are closed is explained in crates/surface/src/gluing/rings.rs.

#include "update/tag.glsl"
#include "shared/edge_image.glsl"

layout(local_size_x = EXCHANGE_WORKGROUP) in;

layout(set = 0, binding = 1, rgba32f) uniform restrict image2D gaussians;

layout(push_constant) uniform Push {
    int parts;
    int members;
    int groups;
    int copy_texels;
};

#include "passes/copies.glsl"

// The rings: for each part its first cell, and the number of cells at the end. Then for each cell its first point,
// packed like the point of a member, and a code of the ends of its sides on the ring. Then for each part the sum of its
// curvatures, the tags that any of them has, whether any of its cells exists, and the exclusive or of the codes of the
// cells that exist.
int first_cell_at(int part) {
    return earliest_at(parts) + part;
}

int cell_at(uint cell) {
    return first_cell_at(parts) + 1 + 2 * int(cell);
}

int sum_at(int part) {
    return cell_at(copies[first_cell_at(parts)]) + 4 * part;
}

bool exists(ivec2 first) {
    float lengths[6] = edges_of_cell(first);
    bool all_there = true;
    for (int i = 0; i < 6; i++) all_there = all_there && lengths[i] < FAR;
    return all_there;
}

void add_up(int part) {
    float sum = 0.0;
    uint tags = 0u;
    uint end = copies[part + 1];
    for (uint member = copies[part]; member < end; member++) {
        ivec2 point = point_of_member(member);
        float curvature = imageLoad(gaussians, texel_of(point))[component_of(point)];
        sum += curvature;
        tags |= tag_of(curvature);
    }
    uint found = 0u;
    uint ends = 0u;
    end = copies[first_cell_at(part + 1)];
    for (uint cell = copies[first_cell_at(part)]; cell < end; cell++) {
        if (!exists(unpacked(copies[cell_at(cell)]))) continue;
        found = 1u;
        ends ^= copies[cell_at(cell) + 1];
    }
    copies[sum_at(part)] = floatBitsToUint(sum);
    copies[sum_at(part) + 1] = tags;
    copies[sum_at(part) + 2] = found;
    copies[sum_at(part) + 3] = ends;
}

// Replaces the sum of a group's first part by the value of the group's points.
void find_value(int group) {
    float sum = 0.0;
    uint tags = 0u;
    uint found = 0u;
    uint ends = 0u;
    int first = int(copies[first_group() + group]);
    int end = int(copies[first_group() + group + 1]);
    for (int part = first; part < end; part++) {
        sum += uintBitsToFloat(copies[sum_at(part)]);
        tags |= copies[sum_at(part) + 1];
        found |= copies[sum_at(part) + 2];
        ends ^= copies[sum_at(part) + 3];
    }
    float mean = sum / float(copies[end] - copies[first]);
    bool goes_round = found != 0u && ends == 0u;
    copies[sum_at(first)] = floatBitsToUint(with_tag(mean, goes_round ? 0u : tags));
}

void write(int index) {
    ivec2 texel = unpacked(copies[copy_texel_at(index)]);
    vec4 values = imageLoad(gaussians, texel);
    for (int j = 0; j < 4; j++) {
        int group = int(copies[copy_texel_at(index) + 1 + j]) - 1;
        if (group < 0) continue;
        values[j] = uintBitsToFloat(copies[sum_at(int(copies[first_group() + group]))]);
    }
    imageStore(gaussians, texel, values);
}

void main() {
    int own = int(gl_LocalInvocationIndex);
    for (int part = own; part < parts; part += EXCHANGE_WORKGROUP) add_up(part);
    memoryBarrierBuffer();
    barrier();
    for (int group = own; group < groups; group += EXCHANGE_WORKGROUP) find_value(group);
    memoryBarrierBuffer();
    memoryBarrierImage();
    barrier();
    for (int index = own; index < copy_texels; index += EXCHANGE_WORKGROUP) write(index);
}
