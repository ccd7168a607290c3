// Defines the list of the copies of points of a glued surface, and where its parts are. It is written by
// src/vulkan/copies.rs.
//
// The including shader declares
//     int parts;         number of parts of groups
//     int members;       number of copies
//     int groups;        number of groups
//     int copy_texels;   number of texels with copies

layout(set = 0, binding = 3) restrict coherent buffer Copies {
    // For each part of a group its first member, and the number of members at the end. Then for each member
    // its point in the images, as column + 65536 row. Then for each group its first part, and the number of
    // parts at the end. Then for each texel with copies COPY_TEXEL_WORDS words: the texel, packed like a
    // point, and for each of its points the number of its group, counted from 1, or 0 if it has no group.
    // Then for each part its earliest front: time and carried value. In a renderer's frame the rings of
    // share_curvature.comp follow.
    uint copies[];
};

int first_group() {
    return parts + 1 + members;
}

int copy_texel_at(int index) {
    return first_group() + groups + 1 + COPY_TEXEL_WORDS * index;
}

int earliest_at(int part) {
    return copy_texel_at(copy_texels) + 2 * part;
}

ivec2 unpacked(uint word) {
    return ivec2(word & 0xffffu, word >> 16);
}

// Returns the point of a member.
ivec2 point_of_member(uint member) {
    return unpacked(copies[parts + 1 + int(member)]);
}
